"""`gaitlab check` and `baseline` as a nightly job meets them: exit codes, pages, files."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

import gaitlab.simulation.trial
from gaitlab.cli import run_command_line
from gaitlab.regression import read_baseline, write_baseline
from gaitlab.store import Store
from tests.regression.nights import FILE, night, walker

EDGE = str(FILE)
CHECK = ("check", EDGE, "--baseline", "b.json", "-j", "0")


class Printed(tuple[int, str, str]):
    """Exit code, stdout and stderr of a command."""

    code = property(lambda self: self[0])
    out = property(lambda self: self[1])
    err = property(lambda self: self[2])


Command = Callable[..., Printed]


@pytest.fixture
def gaitlab_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd) -> Command:
    """Run a command in an empty folder, with drawn walks instead of simulated ones."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("gaitlab.running.processes.simulated", walker(0))

    def command(*arguments: str) -> Printed:
        code = run_command_line(arguments)
        return Printed((code, *capfd.readouterr()))

    return command


@pytest.fixture(scope="module")
def first_night(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a store and its baseline, for copies."""
    folder = tmp_path_factory.mktemp("night")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.setattr("gaitlab.running.processes.simulated", walker(0))
        assert run_command_line(["run", EDGE, "-j", "0", "--quiet"]) == 0
        assert run_command_line(["baseline", EDGE, "--output", "b.json"]) == 0
    return folder


@pytest.fixture
def based(gaitlab_command: Command, first_night: Path, tmp_path: Path) -> Command:
    """The same, after a baseline was made."""
    shutil.copytree(first_night, tmp_path, dirs_exist_ok=True)
    return gaitlab_command


@pytest.fixture
def other_night(monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """Let the code of tomorrow walk otherwise."""

    def change(draw: int, **how: float) -> None:
        monkeypatch.setattr("gaitlab.running.processes.simulated", walker(draw, **how))
        for part in ("running.provenance", "regression.current"):
            monkeypatch.setattr(f"gaitlab.{part}.code_digest", lambda *_: f"tomorrow {draw}")
        monkeypatch.setattr("tests.regression.nights.code_digest", lambda *_: f"tomorrow {draw}")

    return change


def test_nothing_changed_is_exit_0_and_walks_nothing_twice(based):
    done = based(*CHECK)
    assert done.code == 0
    assert "Nothing changed, bit for bit, in 60 trials" in done.out
    assert "60 cached" in done.err


def test_an_empty_store_is_walked_first(based):
    done = based(*CHECK, "--store", "fresh")
    assert done.code == 0
    assert "bit for bit" in done.out
    assert len(Store(Path("fresh")).states()) == 60


def test_the_walks_of_other_code_are_walked_again(based, other_night):
    other_night(7)
    done = based(*CHECK)
    assert "60 trials in data came from other code: walked again" in done.err
    assert done.code == 0
    assert "Other bits in 60 of 60 trials" in done.out
    assert "code: " in done.out
    again = based(*CHECK)
    assert "60 cached" in again.err
    assert "walked again" not in again.err
    assert again.out == done.out


def test_code_that_falls_more_often_is_exit_5_with_one_readable_page(based, other_night):
    other_night(7, share=0.2)
    done = based(*CHECK, "--summary", "page.md")
    assert done.code == 5
    assert done.out.startswith("# edge: worse than the baseline")
    assert "**Worse: stable walks" in done.out
    assert Path("page.md").read_text().strip() == done.out.strip()


def test_a_summary_is_added_to_what_the_file_holds(based):
    Path("page.md").write_text("# Before\n")
    based(*CHECK, "--summary", "page.md")
    assert Path("page.md").read_text().startswith("# Before\n# edge: nothing changed")


def test_json_says_the_same_in_one_object(based, other_night):
    exact = json.loads(based(*CHECK, "--json").out)
    assert (exact["verdict"], exact["mode"], exact["exit_code"]) == ("as good", "exact", 0)
    other_night(7, share=0.2)
    worse = json.loads(based(*CHECK, "--json").out)
    assert (worse["verdict"], worse["mode"], worse["exit_code"]) == ("worse", "paired", 5)
    assert {"quantity": "stable", "surface": "all"} in worse["worse"]


def test_seeds_beyond_the_baselines_are_left_out_and_fewer_are_paired(based):
    more = based(*CHECK, "--seeds", "16")
    assert (more.code, "in 60 trials" in more.out) == (0, True)
    fewer = based(*CHECK, "--seeds", "5")
    assert (fewer.code, "in 20 trials" in fewer.out) == (0, True)


def test_other_seeds_are_compared_without_pairs(based):
    done = based(*CHECK, "--set", f"seeds={list(range(100, 130))}")
    assert done.code == 0
    assert "without common seeds" in done.out


def test_too_few_other_seeds_are_refused_before_anything_walks(based):
    done = based(*CHECK, "--set", "seeds=[100]", "--store", "fresh")
    assert done.code == 6
    assert "seeds a cell would do" in done.out
    assert not Path("fresh").exists()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"experiment": "another"}, "is of the experiment another, not of edge"),
        ({"physics_version": 99}, "physics version 99"),
        ({"walks": ()}, "shares no cell"),
    ],
)
def test_a_baseline_of_something_else_is_exit_6_before_anything_walks(based, change, message):
    write_baseline(replace(read_baseline(Path("b.json")), **change), Path("b.json"))
    done = based(*CHECK, "--store", "fresh", "--summary", "page.md")
    assert done.code == 6
    assert done.out.startswith("# edge: the gate could not decide")
    assert message in done.out
    assert message in Path("page.md").read_text()
    assert not Path("fresh").exists()


def test_a_new_physics_version_asks_for_a_new_baseline(based, monkeypatch):
    monkeypatch.setattr(
        "gaitlab.regression.gate.PHYSICS_VERSION", gaitlab.simulation.trial.PHYSICS_VERSION + 1
    )
    done = based(*CHECK)
    assert done.code == 6
    assert "make a new one with `gaitlab baseline" in done.out


def test_a_grid_without_a_common_cell_is_exit_6(based):
    done = based(*CHECK, "--set", "grid.gait.step_length=[0.03]", "--store", "fresh")
    assert (done.code, "shares no cell" in done.out) == (6, True)
    assert not Path("fresh").exists()


@pytest.mark.parametrize("name", ["none.json", "."])
def test_a_missing_baseline_is_exit_6(gaitlab_command, name):
    done = gaitlab_command("check", EDGE, "--baseline", name, "--json")
    assert done.code == 6
    assert json.loads(done.out)["verdict"] == "undecided"


def test_failed_trials_are_exit_6_with_their_reason(based, other_night):
    other_night(7, fail=2)
    done = based(*CHECK)
    assert done.code == 6
    assert "2 of 60 trials of edge failed" in done.out


def test_failed_trials_are_tried_again_the_next_time(based, other_night):
    other_night(7, fail=2)
    based(*CHECK)
    assert based(*CHECK).code == 0


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (("check", "nightlee", "--baseline", "b.json"), 3, "nightly"),
        (("check", EDGE), 2, "--baseline"),
        (("check", EDGE, "--baseline", "b.json", "-j", "-1"), 2, "-1"),
        (("check", EDGE, "--baseline", "b.json", "--seeds", "0"), 2, "--seeds 0"),
        (("check", EDGE, "--baseline", "b.json", "--summary", "."), 2, "folder"),
        (("check", EDGE, "--baseline", "b.json", "--summary", "no/such/page.md"), 7, "no/such"),
        (("baseline", EDGE), 2, "--output"),
        (("baseline", EDGE, "--output", "."), 2, "folder"),
        (("baseline", EDGE, "--output", "c.json", "--store", "empty"), 6, "gaitlab run"),
        (("baseline", EDGE, "--output", "c.json", "--seeds", "16"), 6, "4 of 64 trials"),
    ],
)
def test_mistakes_get_a_message_and_no_traceback(based, arguments, code, message):
    done = based(*arguments)
    assert done.code == code
    assert message in done.out + done.err
    assert "Traceback" not in done.err


def test_a_worse_baseline_replaces_a_better_one_only_by_force(based, other_night):
    kept = Path("b.json").read_bytes()
    other_night(7, share=0.2)
    assert based("run", EDGE, "-j", "0", "--store", "worse").code == 0
    again = ("baseline", EDGE, "--output", "b.json", "--store", "worse")
    refused = based(*again)
    assert refused.code == 5
    assert "stable walks" in refused.err
    assert Path("b.json").read_bytes() == kept
    assert based(*again, "--force").code == 0
    assert Path("b.json").read_bytes() != kept


def test_a_baseline_as_good_replaces_the_old_one(based, other_night):
    other_night(7)
    assert based(*CHECK).code == 0
    assert based("baseline", EDGE, "--output", "b.json").code == 0
    assert "bit for bit" in based(*CHECK).out


def facts(done: Printed) -> dict:
    """The JSON object of a check."""
    return json.loads(done.out)


TALLY = {"stable", "fell", "out_of_reach", "n"}


def test_the_first_line_counts_falls_and_other_bits_whatever_was_decided(based, other_night):
    before = facts(based(*CHECK, "--json"))["falls"]["before"]
    assert f"{before['fell']} of 60" in based(*CHECK).out.splitlines()[0]
    other_night(7)
    first = based(*CHECK).out.splitlines()[0]
    assert "other bits in 60 of 60" in first
    assert f"{before['fell']} of 60" in first


def test_json_counts_falls_of_all_and_of_each_cell(based, other_night):
    other_night(7, share=0.2)
    found = facts(based(*CHECK, "--json"))
    assert (found["equal_ids"], len(found["other_bits"])) == (60, 60)
    for side in ("before", "tonight"):
        total, cells = found["falls"][side], [each[side] for each in found["falls"]["cells"]]
        assert set(total) == TALLY
        assert {name: sum(cell[name] for cell in cells) for name in TALLY} == total
    assert found["falls"]["tonight"]["fell"] > found["falls"]["before"]["fell"]


def test_failed_trials_leave_the_falls_of_the_others_on_the_page(based, other_night):
    other_night(7, share=0.0, fail=2)
    done = based(*CHECK)
    assert done.code == 6
    assert "58 of 58" in done.out.splitlines()[0]
    other_night(8, share=0.0, fail=2)
    found = facts(based(*CHECK, "--json"))
    assert (found["verdict"], found["falls"]["tonight"]["n"]) == ("undecided", 58)
    assert len(found["other_bits"]) == 58


def test_nothing_walked_still_tells_the_falls_of_the_baseline(based):
    found = facts(based(*CHECK, "--json", "--set", "seeds=[100]", "--store", "fresh"))
    assert (found["exit_code"], found["falls"]["before"]["n"]) == (6, 60)
    assert found["falls"]["tonight"] is None
    fell = found["falls"]["before"]["fell"]
    page = based(*CHECK, "--set", "seeds=[100]", "--store", "fresh").out
    assert f"{fell} of 60" in page.splitlines()[0]


def test_every_answer_has_the_same_keys(based, other_night):
    exact = facts(based(*CHECK, "--json"))
    none = facts(based("check", EDGE, "--baseline", "none.json", "--json"))
    other_night(7, share=0.2)
    worse = facts(based(*CHECK, "--json"))
    assert set(exact) == set(none) == set(worse)
    assert (exact["reason"], worse["reason"]) == (None, None)
    assert none["falls"] == {
        "before": None,
        "tonight": None,
        "alone_before": None,
        "alone_tonight": None,
        "cells": [],
    }


def test_no_other_file_is_taken_for_an_old_baseline(based):
    Path("notes.txt").write_text("mine")
    done = based("baseline", EDGE, "--output", "notes.txt")
    assert (done.code, "--force" in done.err) == (6, True)
    assert Path("notes.txt").read_text() == "mine"
    write_baseline(replace(night(1), experiment="another"), Path("c.json"))
    assert "is the baseline of another" in based("baseline", EDGE, "--output", "c.json").err
