"""The section `report:` of an experiment: what it may name, and where a mistake stands."""

from __future__ import annotations

from pathlib import Path

import pytest

from gaitlab.errors import FileError
from gaitlab.experiment import Experiment, load_experiment

TEXT = """\
robot: eros
gait: eros
surfaces: [carpet_4mm]
grid: {gait.step_length: [0.0, 0.02], gait.step_height: [0.02, 0.03]}
report:
  KEY
"""


def read(folder: Path, key: str) -> Experiment:
    path = folder / "toy.yaml"
    path.write_text(TEXT.replace("KEY", key))
    return load_experiment(path)


@pytest.mark.parametrize(
    ("key", "complaint"),
    [
        ("metrics: [walking_spede]", "did you mean 'walking_speed'"),
        ("metrics: [fall_direction]", "found the text 'fall_direction'"),
        ("maps: [[gait.step_length, gait.step_hight]]", "did you mean 'gait.step_height'"),
        ("maps: [[gait.step_length]]", "two different paths"),
        ("maps: [[surface, surface]]", "two different paths"),
        ("maps: [[surface, gait.step_length, gait.step_height]]", "two different paths"),
    ],
)
def test_what_cannot_be_drawn_is_refused_where_it_stands(
    tmp_path: Path, key: str, complaint: str
) -> None:
    with pytest.raises(FileError, match=complaint) as caught:
        read(tmp_path, key)
    assert caught.value.problems[0].line == 6


def test_one_metric_and_one_map_need_no_list_of_their_own(tmp_path: Path) -> None:
    assert read(tmp_path, "metrics: walking_speed").report.metrics == ("walking_speed",)
    maps = read(tmp_path, "maps: [gait.step_length, surface]").report.maps
    assert maps == (("gait.step_length", "surface"),)


def test_what_is_drawn_does_not_change_what_was_asked(tmp_path: Path) -> None:
    bare = read(tmp_path, "columns: surface")
    drawn = read(tmp_path, "maps: [[gait.step_length, surface]]\n  metrics: [distance]")
    assert bare.digest == drawn.digest
