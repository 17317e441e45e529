"""Maps over two parameters, the notes of grounds and servos, and pages of little."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gaitlab.experiment import load_experiment
from gaitlab.report.cells import verdicts_note
from gaitlab.report.maps import pair_maps, varied_paths
from gaitlab.report.page import Sources, write_page
from gaitlab.report.provenance import DescribedPart, file_notes, ground_notes
from gaitlab.report.results import Results
from gaitlab.servos.files import load_servo
from tests.report.builder import SURFACES, results_of, toy_trials, trial

SOURCES = Sources(
    facts={}, parts=[], grounds="", command="gaitlab report toy", runs="gaitlab run toy"
)


def three_axes() -> Results:
    """Step length, step height and ground, each varied on its own."""
    trials = [
        {
            **trial(row, surface, "none", seed, up=height < 0.03),
            "gait.step_height": height,
        }
        for row in (0.0, 0.04)
        for surface in SURFACES[:2]
        for height in (0.02, 0.03)
        for seed in range(2)
    ]
    results = results_of(trials, paths=("gait.step_height",), compare=False)
    return replace(results, units={"gait.step_length": "m", "gait.step_height": "m"})


def test_with_three_axes_the_other_pairs_are_mapped_without_being_asked_for(tmp_path: Path) -> None:
    text = pair_maps(three_axes(), tmp_path)
    assert "over step length and step height" in text
    assert "over step height and surface" in text
    assert "step length and surface" not in text
    assert {"map_1.png", "map_2.png"} <= {file.name for file in tmp_path.iterdir()}


def test_only_the_maps_that_are_asked_for_are_drawn(tmp_path: Path) -> None:
    results = replace(three_axes(), maps=(("surface", "gait.step_length"),))
    assert pair_maps(results, tmp_path).count("![") == 1


def test_parameters_that_move_together_count_once() -> None:
    results = results_of(toy_trials(seeds=1))
    moved = replace(results, units={"gait.heel_strike": "-", "gait.landing_deceleration": "-"})
    assert varied_paths(moved) == ["gait.step_length", "surface", "gait.heel_strike"]
    assert pair_maps(moved, Path()) == ""


@pytest.mark.parametrize(("name", "key"), [("grass_50mm", "height"), ("carpet_4mm", "friction")])
def test_the_notes_of_a_ground_are_those_of_its_file(name: str, key: str) -> None:
    notes = ground_notes(load_experiment("eros_quick"))[name]
    assert notes.sources[key]
    assert notes.values[key] == getattr(load_experiment("eros_quick").parts.surfaces[name], key)


def test_a_ground_whose_file_is_gone_has_no_notes(tmp_path: Path) -> None:
    assert not file_notes("surface", "./gone.yaml", tmp_path).sources


def test_a_servo_shows_the_source_of_its_file_unless_the_experiment_set_the_number() -> None:
    servo = load_servo("mx_64")
    notes = file_notes("servo", "mx_64", Path())
    asked = replace(servo, position_gain=30.0)
    part = DescribedPart(title="servo", path="servo", value=asked, varied=frozenset(), notes=notes)
    lines = {line.split("|")[1].strip(): line for line in part.table().splitlines()}
    assert "ROBOTIS e-Manual MX-64, 12 V" in lines["`stall_torque`"]
    assert "set by the experiment, nobody published it" in lines["`position_gain`"]
    assert {path for path, _, _ in part.unpublished} >= {"servo.torque_limit", "servo.latency"}


def test_a_page_names_the_command_for_what_is_missing(tmp_path: Path) -> None:
    there = trial(0.04, "a", "none", 0, state="INFEASIBLE")
    missing = trial(0.04, "a", "none", 1, state="MISSING")
    results = results_of([there, missing], compare=False)
    text = write_page(results, SOURCES, tmp_path).read_text(encoding="utf-8")
    assert "1 of 2 planned trials" in text
    assert "gaitlab run toy" in text.split("Stable runs")[0]


def test_verdicts_near_one_half_are_counted_as_open() -> None:
    trials = [trial(0.04, "a", "none", seed, up=seed < 6) for seed in range(12)]
    assert verdicts_note(results_of(trials, compare=False)).startswith("**1 of 1 verdict rests on")


def test_runs_without_any_number_still_make_a_page(tmp_path: Path) -> None:
    nothing = dict.fromkeys(("distance", "walking_speed", "pitch_amplitude", "fall_phase"), np.nan)
    trials = [{**trial(0.04, "a", "none", seed, up=False), **nothing} for seed in range(2)]
    text = write_page(results_of(trials, compare=False), SOURCES, tmp_path).read_text("utf-8")
    assert "The robot fell in 2 of 2 simulated runs" in text
