"""How walks are drawn: geometry of feet and support, phases, loads, and which trials are shown."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from gaitlab.kinematics.transforms import axis_rotation, quaternion_of
from gaitlab.log import TrialLog
from gaitlab.report.figures.balance import WalkPanel, balance_figure
from gaitlab.report.figures.foot_paths import foot_paths, shown_rows
from gaitlab.report.figures.gait_phases import runs, swings
from gaitlab.report.figures.heading import seen, support_extent
from gaitlab.report.figures.joint_loads import most_loaded
from gaitlab.report.representative import (
    RepresentativeTrial,
    extremes,
    extremes_blocks,
    shortened,
    walks_of,
)
from tests.report.builder import results_of, toy_trial, toy_trials, trial, walk_log

NAME = "none-grass_50mm-0.04-0"


def standing(
    yaw: float = 0.0, pitch: float = 0.0, left_only: bool = False, torque: float = 0.0
) -> TrialLog:
    """A robot that stands at (1, 2) with its feet 0.1 m apart, turned by a yaw in [rad]."""
    log = walk_log()
    n = len(log)
    arrays = {name: np.array(values) for name, values in log.arrays.items()}
    arrays["trunk_x"], arrays["trunk_y"], arrays["yaw"] = (
        np.ones(n),
        2 * np.ones(n),
        yaw + np.zeros(n),
    )
    turn = axis_rotation("z", np.array(yaw)) @ axis_rotation("y", np.array(pitch))
    for foot, side in (("left", 1.0), ("right", -1.0)):
        place = axis_rotation("z", np.array(yaw)) @ np.array([0.0, 0.05 * side, 0.0])
        arrays[f"{foot}_foot_x"], arrays[f"{foot}_foot_y"] = (
            1 + place[0] + np.zeros(n),
            2 + place[1] + np.zeros(n),
        )
        for axis, value in zip("xyzw", quaternion_of(turn), strict=True):
            arrays[f"{foot}_foot_q{axis}"] = value + np.zeros(n)
        arrays[f"{foot}_foot_contact"] = np.full(n, foot == "left" or not left_only)
    arrays["left_knee_torque"] = torque + np.zeros(n)
    return TrialLog(header=log.header, arrays=arrays)


def walk(log: TrialLog) -> RepresentativeTrial:
    return RepresentativeTrial(
        label="", seed=0, trial=toy_trial(NAME), log=log, amplitude=np.nan, others=(), falls=0
    )


@pytest.mark.parametrize("yaw", [0.0, 0.7, -2.0])
def test_the_support_of_two_soles_does_not_depend_on_the_heading(yaw: float) -> None:
    log = standing(yaw)
    extent = support_extent(log)[-1]
    header = log.header
    assert extent[0] == pytest.approx([-header.sole_length / 2, header.sole_length / 2], abs=1e-6)
    assert extent[1] == pytest.approx([-0.05 - header.sole_width / 2, 0.05 + header.sole_width / 2])


def test_an_unloaded_sole_supports_nothing() -> None:
    log = standing(left_only=True)
    assert support_extent(log)[-1, 1, 0] == pytest.approx(0.01, abs=1e-6)


def test_in_flight_there_is_no_support() -> None:
    assert np.isnan(support_extent(walk_log())).all()


def test_points_are_seen_from_where_the_walk_starts() -> None:
    ahead = np.array([1.0 + np.cos(0.7), 2.0 + np.sin(0.7)])
    assert seen(standing(0.7), ahead) == pytest.approx([1.0, 0.0], abs=1e-6)


def test_heel_and_toe_are_a_sole_apart_and_a_toe_that_points_down_is_lower() -> None:
    log = standing(yaw=0.4, pitch=0.2)
    paths = foot_paths(walk(log), 0, slice(10, 20))
    assert np.linalg.norm(paths.toe - paths.heel, axis=1) == pytest.approx(log.header.sole_length)
    assert (paths.toe[:, 1] < paths.heel[:, 1]).all()
    assert (paths.ankle[:, 1] > paths.heel[:, 1]).all()


def test_two_cycles_are_shown_up_to_the_fall() -> None:
    log = walk_log(fall_at=4.0)
    rows = shown_rows(log)
    assert log.fall_index is not None
    assert rows.stop == log.fall_index + 1
    assert (rows.stop - rows.start) * log.header.dt == pytest.approx(2 * log.header.gait_period)


def test_the_shading_covers_what_the_gait_commands() -> None:
    log = walk_log()
    spans = swings(log, toy_trial(NAME).gait, toy_trial(NAME).robot)
    assert [span.foot for span in spans[:4]] == [0, 1, 0, 1]
    first = [span for span in spans if span.foot == 0][1]
    assert first.start == pytest.approx(0.8, abs=2 * log.header.dt)
    assert first.end == pytest.approx(1.2, abs=2 * log.header.dt)


def test_runs_are_the_stretches_of_true_values() -> None:
    flags = np.array([True, False, True, True, False, True])
    assert list(runs(flags)) == [(0, 1), (2, 4), (5, 6)]
    assert list(runs(np.zeros(3, dtype=bool))) == []


def test_the_joint_at_its_torque_limit_comes_first() -> None:
    limit = standing().header.torque_limits[0]
    loads = most_loaded(walk(standing(torque=-limit)), slice(0, 50))
    assert [load.joint for load in loads] == ["left_knee", "right_knee"]
    assert loads[0].saturated.all()
    assert loads[0].limits[0] == (-1.0, 2.0)
    assert not loads[1].saturated.any()


def test_balance_has_a_row_for_each_signal_and_a_column_for_each_walk() -> None:
    columns = [WalkPanel(walk=walk(standing()), others=[walk_log(seed=1)])] * 2
    assert len(balance_figure(columns).axes) == 10


def test_of_many_variants_the_two_that_differ_most_are_drawn() -> None:
    trials = [
        {**trial(0.04, "carpet_4mm", "none", seed, up=seed < height), "gait.step_height": height}
        for height in (1, 4, 2, 0)
        for seed in range(4)
    ]
    results = results_of(trials, paths=("gait.step_height",), compare=False)
    walks = walks_of(results, 0.04, "carpet_4mm")
    assert [walk.falls for walk in walks] == [0, 4]


def test_best_is_the_farthest_walk_and_worst_the_earliest_fall() -> None:
    found = {what: row for what, row in extremes(results_of(toy_trials()))}
    best, worst = found["farthest walk without a fall"], found["earliest fall"]
    done = results_of(toy_trials()).done
    up, down = done[~done["fell"].astype(bool)], done[done["fell"].astype(bool)]
    assert best["distance"] == up["distance"].max()
    assert worst["time_to_fall"] == down["time_to_fall"].min()


def test_a_robot_that_never_falls_and_one_that_always_does_have_extremes_too() -> None:
    for up, names in ((True, ["farthest", "shortest"]), (False, ["latest", "earliest"])):
        trials = [trial(0.04, "carpet_4mm", "none", seed, up=up) for seed in range(3)]
        assert [what.split()[0] for what, _ in extremes(results_of(trials))] == names


def test_a_short_name_tells_a_trial_from_every_other() -> None:
    known = pd.Series(["abcdef0123456789", "abcdef0129999999", "ffff000000000000"])
    assert shortened(list(known), known) == ["abcdef0123", "abcdef0129", "ffff0000"]


def test_the_commands_name_the_store_that_holds_the_trials() -> None:
    text = "\n".join(extremes_blocks(results_of(toy_trials()), " --store elsewhere"))
    assert text.count("gaitlab replay ") == 2
    assert text.count("--store elsewhere") == 2


def test_the_same_walk_gives_the_same_picture(tmp_path: Path) -> None:
    from gaitlab.render.figure_style import save

    column = WalkPanel(walk=replace(walk(standing()), amplitude=0.1), others=[])
    files = [save(balance_figure([column]), tmp_path, name) for name in "ab"]
    assert files[0].read_bytes() == files[1].read_bytes()
