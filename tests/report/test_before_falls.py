"""What precedes a fall: laws on logs that are written by formula."""

from __future__ import annotations

from math import isnan, radians

import numpy as np
import pandas as pd
import pytest

from gaitlab.log import TrialLog
from gaitlab.report.before_falls import (
    Firmness,
    Stand,
    firmness_table,
    first_axis,
    measured,
    pairs_of,
    piece_before,
    row_at,
    stand,
    zmp_ahead,
)
from tests.synthetic import HEADER, fall, mirrored, sine, walk

PERIOD = HEADER.gait_period  # s


def stood(log: TrialLog) -> Stand:
    return stand(log.header, {name: log[name] for name in log.arrays})


def test_the_zmp_is_ahead_of_the_sole_that_carries_or_of_the_middle_of_both() -> None:
    log = walk(left_foot_x=0.04, right_foot_x=0.0, zmp_x=0.05)
    ahead, support = zmp_ahead(log), log["support"]
    for feet, expected in ((1, 0.01), (2, 0.05), (3, 0.03)):
        assert ahead[support == feet] == pytest.approx(expected, abs=1e-7)


def test_a_walk_that_stays_up_stands_well_to_its_end_and_falls_never() -> None:
    log = walk()
    until = stood(log)
    assert until.row == len(log) - 1
    assert isnan(until.lead)
    assert until.cycles == pytest.approx(6.0)


@pytest.mark.parametrize("direction", ["forward", "backward", "left", "right"])
def test_a_robot_that_topples_stood_well_until_it_leaned_by_twenty_degrees(direction: str) -> None:
    log = fall(direction, at=3.0)  # topples at 3 rad/s
    until = stood(log)
    leaned = 3.0 + radians(20.0) / 3.0
    assert until.cycles * PERIOD == pytest.approx(leaned, abs=1.5 * HEADER.dt)
    assert until.lead == pytest.approx(radians(25.0) / 3.0 + 0.1, abs=3.0 * HEADER.dt)
    assert row_at(log.header, until.cycles) == until.row


def test_a_margin_that_is_lost_before_a_fall_ends_the_good_stand() -> None:
    log = fall("forward", at=3.0, zmp_margin=lambda walked: np.where(walked < 2.0, 0.02, 0.004))
    assert stood(log).cycles * PERIOD == pytest.approx(2.0, abs=1.5 * HEADER.dt)


def test_a_margin_that_is_lost_without_a_fall_ends_nothing() -> None:
    assert stood(walk(zmp_margin=-0.01)).cycles == pytest.approx(6.0)


@pytest.mark.parametrize(
    ("direction", "axis"),
    [
        ("forward", "fore-aft"),
        ("backward", "fore-aft"),
        ("left", "sideways"),
        ("right", "sideways"),
    ],
)
def test_the_axis_that_leaves_its_range_first_is_that_of_the_fall(
    direction: str, axis: str
) -> None:
    other = {"roll" if axis == "fore-aft" else "pitch": sine(0.05)}
    log = fall(direction, at=3.0, **other)
    assert first_axis(log, round((HEADER.startup_time + 2.9) / HEADER.dt)) == axis


def test_a_mirror_changes_no_measure() -> None:
    log = walk(
        pitch=sine(0.05, offset=-0.04),
        roll=sine(0.03, offset=0.01),
        zmp_x=sine(0.01, offset=-0.02),
        zmp_y=sine(0.02),
        left_foot_qy=0.05,
        left_foot_qw=float(np.sqrt(1.0 - 0.05**2)),
        right_foot_plough_force=sine(2.0),
        left_foot_z=0.015,
        right_foot_z=0.012,
    )
    here, there = (measured(piece_before(each, len(log) - 1)) for each in (log, mirrored(log)))
    assert np.isfinite(list(here.values())).all()
    assert there == pytest.approx(here, rel=1e-5, abs=1e-9)


def test_measures_are_what_the_formula_put_in() -> None:
    turn = 0.1  # rad, toe down
    qy, qw = float(np.sin(turn / 2.0)), float(np.cos(turn / 2.0))
    log = walk(
        pitch=sine(0.05, offset=-0.04),
        roll=sine(0.03),
        zmp_x=-0.02,
        left_foot_z=0.018,
        right_foot_z=0.018,
        right_foot_plough_force=3.0,
        left_foot_qy=qy,
        left_foot_qw=qw,
        right_foot_qy=qy,
        right_foot_qw=qw,
    )
    found = measured(piece_before(log, len(log) - 1))
    expected = {
        "pitch": 0.05,
        "roll": 0.03,
        "lean": -0.04,
        "ahead": -0.02,
        "sink": 0.012,  # of a pile of 30 mm
        "lift": 0.02,
        "plough": 3.0,
        "margin_min": 0.02,
        "tip": turn,
        "toe_first": 1.0,
        "single": 0.8,  # two feet of duty 0.6 share a fifth of the time
    }
    for name, value in expected.items():
        assert found[name] == pytest.approx(value, abs=2e-3), name


def test_a_gait_cycle_that_the_log_does_not_hold_is_not_measured() -> None:
    log = walk()
    assert piece_before(log, 10) is None
    assert piece_before(log, len(log)) is None
    assert all(isnan(value) for value in measured(None).values())


def walks(*rows: tuple[str, float, int, float]) -> pd.DataFrame:
    return pd.DataFrame(rows, columns=["trial_id", "step", "seed", "cycles"])


def test_a_pair_is_looked_at_where_the_first_of_the_two_last_stood_well() -> None:
    first = walks(("a", 0.0, 0, 2.0), ("b", 0.0, 1, 5.0), ("c", 0.1, 0, 1.0))
    second = walks(("e", 0.0, 1, 4.0), ("d", 0.0, 0, 9.0))
    found = pairs_of(first, second, "step")
    assert found.ids == (["a", "b"], ["d", "e"])
    assert found.cycles.tolist() == [2.0, 4.0]
    assert found.seeds.tolist() == [0, 1]


def test_walks_of_other_seeds_make_no_pair() -> None:
    found = pairs_of(walks(("a", 0.0, 0, 2.0)), walks(("b", 0.0, 1, 2.0)), "step")
    assert found.ids == ([], [])
    assert len(found.cycles) == len(found.cells) == len(found.seeds) == 0


def held(stiffness: float) -> Firmness:
    return Firmness(sink=0.01, stiffness=stiffness, tipping=(1.0, 2.0))


def test_the_softest_ground_stands_first() -> None:
    text = firmness_table({"a": held(np.inf), "b": held(2e4)}, {"a": "0 of 9"}, "plain")
    assert text.index("| b ") < text.index("| a ")
    assert "inf" in text
    assert "0 of 9" in text
