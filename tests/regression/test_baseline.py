"""The file of a baseline: comes back as it was, and nothing else is taken for one."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from gaitlab.errors import Undecided
from gaitlab.regression import read_baseline, write_baseline
from gaitlab.simulation.trial import PHYSICS_VERSION as NOW
from tests.regression.nights import night


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "made" / "baseline.json"
    write_baseline(night(1), path)
    return path


def test_a_baseline_comes_back_as_it_was(file):
    assert read_baseline(file) == night(1)


def test_the_same_baseline_is_the_same_file(file, tmp_path):
    write_baseline(night(1), tmp_path / "again.json")
    assert (tmp_path / "again.json").read_bytes() == file.read_bytes()


def test_every_trial_has_its_line(file):
    lines = file.read_text().splitlines()
    assert sum('"trial_id"' in line for line in lines) == len(night(1).walks)


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (lambda text: text.replace('"stable": true', '"stable": false', 1), "by hand"),
        (lambda text: text.replace(f'"physics_version": {NOW}', '"physics_version": 9'), "by hand"),
        (lambda text: text.replace('"gaitlab_baseline": 1', '"gaitlab_baseline": 99'), "format 99"),
        (lambda text: text.replace('"gaitlab_baseline"', '"another"'), "no baseline of gaitlab"),
        (lambda text: text.replace('"walks"', '"trials"'), "damaged or was edited"),
        (lambda text: text.replace('"seed": 3', '"sead": 3', 1), "damaged or was edited"),
        (lambda text: text[: len(text) // 2], "not JSON"),
        (lambda text: "", "not JSON"),
        (lambda text: "[1, 2]", "no baseline of gaitlab"),
        (lambda text: "<<<<<<< ours\n" + text, "not JSON"),
    ],
)
def test_what_is_no_whole_baseline_is_refused(file, damage, message):
    file.write_text(damage(file.read_text()))
    with pytest.raises(Undecided, match=message):
        read_baseline(file)


def test_any_changed_number_is_noticed(file):
    content = json.loads(file.read_text())
    content["walks"][7]["metrics"]["distance"] += 1e-9
    file.write_text(json.dumps(content))
    with pytest.raises(Undecided, match="by hand"):
        read_baseline(file)


def test_a_file_in_other_spacing_is_the_same_baseline(file):
    file.write_text(json.dumps(json.loads(file.read_text())))
    assert read_baseline(file) == night(1)


def test_a_missing_file_and_a_folder_are_said_to_be_that(tmp_path):
    with pytest.raises(Undecided, match="there is no baseline"):
        read_baseline(tmp_path / "none.json")
    with pytest.raises(Undecided, match="a directory"):
        read_baseline(tmp_path)


def test_bytes_that_are_no_text_are_refused(tmp_path):
    (tmp_path / "b.json").write_bytes(b"\xff\xfe\x00\x80")
    with pytest.raises(Undecided, match="not JSON"):
        read_baseline(tmp_path / "b.json")


def test_a_baseline_from_before_there_was_another_engine_is_one_of_bullet(tmp_path: Path) -> None:
    before = replace(night(1), provenance={"pybullet_version": ("3.2.7",), "code": ("0" * 16,)})
    write_baseline(before, tmp_path / "b.json")
    found = read_baseline(tmp_path / "b.json")
    assert found.provenance == {
        "code": ("0" * 16,),
        "engine": ("bullet",),
        "engine_version": ("3.2.7",),
    }
    assert replace(found, provenance=before.provenance) == before
