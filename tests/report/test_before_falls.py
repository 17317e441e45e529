"""What precedes a fall: laws on logs that are written by formula."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from math import isnan, radians
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from gaitlab.log import TrialLog
from gaitlab.report.before_falls.accounts import common, toes, what_differs
from gaitlab.report.before_falls.comparing import Contrast, contrasts, fell_and_stayed, same_seed
from gaitlab.report.before_falls.courses import courses, growth, slope, zmp_ahead
from gaitlab.report.before_falls.firmness import Firmness, firmness_order
from gaitlab.report.before_falls.measures import MEASURES, measured, piece_before
from gaitlab.report.before_falls.pair import telling_pair, write_strip
from gaitlab.report.before_falls.standing import Stand, first_axis, row_at, stand, support_at
from gaitlab.report.results import Results
from gaitlab.statistics import Interval
from gaitlab.surfaces.tipping import Settled
from tests.report.builder import results_of, toy_trials
from tests.synthetic import HEADER, fall, mirrored, sine, walk
from tests.walked import walked

PERIOD = HEADER.gait_period  # s
GROWING = 0.3  # 1/s


def stood(log: TrialLog) -> Stand:
    return stand(log.header, {name: log[name] for name in log.arrays})


def growing(start: float, rate: float) -> Callable[[np.ndarray], np.ndarray]:
    """A sine of the gait period whose amplitude grows at a rate in [1/s]."""
    return lambda walked: start * np.exp(rate * walked) * np.sin(2.0 * np.pi * walked / PERIOD)


def test_a_sine_that_grows_has_its_rate_of_growth() -> None:
    log = walk(pitch=growing(0.02, GROWING), roll=growing(0.05, -GROWING))
    found = courses(log, len(log) - 1)
    assert found.cycles == 6
    assert found.pitch_growth == pytest.approx(np.expm1(GROWING * PERIOD), rel=1e-4)
    assert found.roll_growth == pytest.approx(np.expm1(-GROWING * PERIOD), rel=1e-4)


def test_a_steady_sine_does_not_grow_whatever_it_leans() -> None:
    log = walk(pitch=sine(0.05, offset=0.1), roll=sine(0.03))
    found = courses(log, len(log) - 1)
    assert found.pitch_growth == pytest.approx(0.0, abs=1e-5)
    assert found.roll_growth == pytest.approx(0.0, abs=1e-5)


@pytest.mark.parametrize("heading", [0.0, 0.7, -2.0])
def test_a_zmp_that_moves_ahead_drifts_by_so_much_a_cycle(heading: float) -> None:
    speed = 0.003  # m/s, ahead of soles that stay where they are
    log = walk(
        heading=heading,
        zmp_x=lambda walked: speed * walked * np.cos(heading),
        zmp_y=lambda walked: speed * walked * np.sin(heading),
    )
    assert courses(log, len(log) - 1).zmp_drift == pytest.approx(speed * PERIOD, rel=1e-3)
    aside = walk(
        heading=heading,
        zmp_x=lambda walked: -speed * walked * np.sin(heading),
        zmp_y=lambda walked: speed * walked * np.cos(heading),
    )
    assert courses(aside, len(aside) - 1).zmp_drift == pytest.approx(0.0, abs=1e-7)


def test_the_zmp_is_ahead_of_the_sole_that_carries_or_of_the_middle_of_both() -> None:
    log = walk(left_foot_x=0.04, right_foot_x=0.0, zmp_x=0.05)
    ahead, support = zmp_ahead(log), log["support"]
    for feet, expected in ((1, 0.01), (2, 0.05), (3, 0.03)):
        assert ahead[support == feet] == pytest.approx(expected, abs=1e-7)


def test_two_cycles_carry_no_rate() -> None:
    log = walk(cycles=2.0, pitch=growing(0.02, GROWING))
    found = courses(log, len(log) - 1)
    assert found.cycles == 2
    assert isnan(found.pitch_growth)
    assert isnan(slope(np.array([1.0, np.nan, 2.0])))
    assert isnan(growth([0.1, 0.0, 0.1]))


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


def test_feet_are_named_by_the_load_they_carry() -> None:
    log = walk()
    names = {int(code): support_at(log, row) for row, code in enumerate(log["support"])}
    assert names == {1: "left foot", 2: "right foot", 3: "both feet"}


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
        "lift_base": 0.05,
        "plough": 3.0,
        "plough_share": 3.0 / HEADER.weight,
        "margin_min": 0.02,
        "tip": turn,
        "rock": 0.0,
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


def trials(*rows: tuple[str, float, int, bool, float]) -> pd.DataFrame:
    return pd.DataFrame(rows, columns=["trial_id", "step", "seed", "fell", "cycles"])


def test_walks_that_stay_up_are_looked_at_where_those_of_their_cell_fall() -> None:
    asked = fell_and_stayed(
        trials(
            ("a", 0.0, 0, True, 2.0),
            ("b", 0.0, 1, True, 4.0),
            ("c", 0.0, 2, True, 3.0),
            ("d", 0.0, 3, False, 9.0),
            ("e", 0.1, 0, True, 1.0),  # a cell in which all fell
            ("f", 0.2, 0, False, 9.0),  # a cell in which none did
        ),
        ["step"],
    )
    assert dict(zip(asked["trial_id"], asked["cycles"], strict=True)) == {
        "a": 2.0,
        "b": 4.0,
        "c": 3.0,
        "d": 3.0,
    }
    assert asked.loc[asked["side"] == 1, "trial_id"].tolist() == ["d"]


def test_a_pair_is_looked_at_where_the_first_of_the_two_last_stood_well() -> None:
    first = trials(("a", 0.0, 0, True, 2.0), ("b", 0.0, 1, True, 5.0), ("c", 0.1, 0, True, 1.0))
    second = trials(("d", 0.0, 0, False, 9.0), ("e", 0.0, 1, True, 4.0))
    asked = same_seed(first, second, ["step", "seed"]).set_index("trial_id")
    assert asked["cycles"].to_dict() == {"a": 2.0, "d": 2.0, "b": 4.0, "e": 4.0}
    assert asked["side"].to_dict() == {"a": 0, "b": 0, "d": 1, "e": 1}


def compared(gap: float, *, paired: bool) -> dict[str, Contrast]:
    """Every measure of twelve walks that are higher by a gap than twelve others, with scatter."""
    noise = np.random.default_rng(4).normal(0.0, 0.1, 24)
    side = np.repeat([0, 1], 12)
    stratum = np.tile(np.arange(12), 2) if paired else np.tile(np.repeat([0, 1], 6), 2)
    asked = pd.DataFrame(
        {
            "trial_id": [f"t{k}" for k in range(24)],
            "cycles": 1.0,
            "stratum": stratum,
            "side": side,
        }
    )
    values = 0.5 + noise + np.where(side == 0, gap, 0.0)
    found = asked[["trial_id", "cycles"]].assign(**dict.fromkeys(MEASURES, values))
    return contrasts(asked, found, paired=paired)


@pytest.mark.parametrize("paired", [True, False])
def test_a_difference_is_found_and_none_is_made_up(paired: bool) -> None:
    high, none = compared(0.4, paired=paired), compared(0.0, paired=paired)
    assert high["sink"].clear
    assert high["sink"].interval.low < 0.4 < high["sink"].interval.high
    assert high["sink"].groups == (12 if paired else 2)
    assert not none["sink"].clear


def test_a_difference_of_shares_stays_within_what_there_can_be() -> None:
    far = compared(5.0, paired=True)
    assert far["toe_first"].interval.high == 1.0
    assert far["sink"].interval.high > 1.0


def contrast(low: float, high: float) -> dict[str, Contrast]:
    side = np.array([0.4, 0.5, 0.6])
    middle = 0.5 * (low + high)
    return {
        "toe_first": Contrast(
            measure="toe_first",
            first=side + middle,
            second=side,
            means=(0.5 + middle, 0.5),
            interval=Interval(low, high),
            groups=3,
        )
    }


@pytest.mark.parametrize(
    ("low", "high", "claim"),
    [
        (0.1, 0.3, "may have a part"),
        (-0.3, -0.1, "no sign of toes that catch in landing"),
        (-0.05, 0.05, "at most 5 points more: no sign"),
        (-0.05, 0.4, "cannot be told"),
    ],
)
def test_no_more_is_said_of_toes_than_the_interval_carries(
    low: float, high: float, claim: str
) -> None:
    assert claim in toes(contrast(low, high))


def test_toes_that_are_always_alike_tell_nothing() -> None:
    same = contrast(0.0, 0.0)["toe_first"]
    flat = replace(same, first=np.zeros(5), second=np.zeros(5))
    assert "cannot be told" in toes({"toe_first": flat})


def test_the_means_of_a_sentence_differ_by_its_difference_however_cells_are_filled() -> None:
    walks = [  # of the first cell mostly falls, of the second mostly none; falls are 1 lower
        (cell, side, 10.0 * cell - (side == 0))
        for cell, counts in enumerate([(9, 3), (3, 9)])
        for side, count in enumerate(counts)
        for _ in range(count)
    ]
    asked = pd.DataFrame(walks, columns=["stratum", "side", "sink"])
    asked = asked.assign(trial_id=[str(n) for n in range(len(asked))], cycles=1.0)
    found = asked[["trial_id", "cycles", "sink"]].reindex(columns=["trial_id", "cycles", *MEASURES])
    made = contrasts(asked[["trial_id", "cycles", "stratum", "side"]], found, paired=False)["sink"]
    assert made.means == (4.0, 5.0)
    assert made.difference == -1.0
    assert np.mean(made.first) < 3.0 < 7.0 < np.mean(made.second)


def test_a_sentence_says_what_was_measured_in_fewer_pairs() -> None:
    many, few = contrast(0.1, 0.3)["toe_first"], replace(contrast(0.1, 0.3)["toe_first"], groups=2)
    told = what_differs({"sink": many, "toe_first": few}, "Against it", "pair", ())
    assert "(3 pairs)" in told
    assert told.count("n = 2") == 1


def test_only_clear_differences_are_named() -> None:
    assert "toe-first landings" in what_differs(contrast(0.1, 0.3), "Against it", "cell", ())
    assert "nothing can be told" in what_differs(contrast(-0.1, 0.3), "Against it", "cell", ())
    assert what_differs({}, "Against it", "cell") == ""


def test_only_what_differs_the_same_way_on_every_ground_is_common() -> None:
    up, more, down = (
        {name: c for name, c in compared(gap, paired=True).items() if name in ("sink", "lean")}
        for gap in (0.4, 0.8, -0.4)
    )
    full = {name: compared(0.0, paired=True) for name in ("a", "b")}
    alike = common({"a": full["a"] | up, "b": full["b"] | more}, "Falls")
    assert alike.startswith("Falls on each of a, b: ")
    assert "sink of the stance sole higher by" in alike
    share = {"toe_first": full["a"]["toe_first"], "single": up["sink"]}
    shares = {name: full[name] | share for name in ("a", "b")}
    assert re.search(r"time on one foot higher by [\d.]+ to [\d.]+ points", common(shares, "Falls"))
    opposed = common({"a": full["a"] | up, "b": full["b"] | down}, "Falls")
    assert "no measure differs clearly on all of them" in opposed
    assert common({"a": full["a"] | up}, "Falls") == ""


def held(stiffness: float) -> Firmness:
    return Firmness(rest=Settled(0.01, stiffness), pitch={}, roll={}, kind="flat")


@pytest.mark.parametrize(
    ("fell", "told"),
    [
        ((0.9, 0.5, 0.0), "3 have more falls on the softer, 0 on the firmer: the falls come in"),
        ((0.9, 0.0, 0.5), "2 have more falls on the softer, 1 on the firmer: the orders differ"),
        ((0.0, 0.0, 0.0), "0 have more falls on the softer, 0 on the firmer: nothing contradicts"),
    ],
)
def test_the_order_of_firmness_is_claimed_only_where_every_pair_shows_it(fell, told) -> None:
    grounds = {"a": held(1e4), "b": held(2e4), "c": held(4e4)}
    assert told in firmness_order(grounds, dict(zip(grounds, fell, strict=True)))


def test_the_pair_is_the_first_seed_of_the_first_cell_in_which_only_one_falls() -> None:
    results = results_of(toy_trials())
    pair = telling_pair(results, *results.variants)
    assert pair is not None
    assert pair.rule
    first = next(row for row in results.row_values if row != 0.0)
    assert pair.fall["gait.step_length"] == first
    assert pair.fall["surface"] == results.column_values[0]
    assert pair.fall["seed"] == pair.other["seed"] == 1  # seed 0 never falls there
    assert pair.fall["fell"]
    assert not pair.other["fell"]


def test_where_both_always_fall_the_pair_is_the_one_that_differs_most_in_time() -> None:
    rows = toy_trials()
    for row in rows:
        later = 0.5 * int(str(row["seed"])) if row["gait.heel_strike"] == "add" else 0.0
        row |= {"fell": True, "time_to_fall": 2.0 + later}
    pair = telling_pair(results_of(rows), *results_of(rows).variants)
    assert pair is not None
    assert not pair.rule
    assert pair.fall["seed"] == 3


def test_without_a_fall_there_is_no_pair() -> None:
    rows = [row | {"fell": False} for row in toy_trials()]
    results = results_of(rows)
    assert telling_pair(results, *results.variants) is None


def test_a_strip_shows_both_walks_and_stays_small(tmp_path: Path) -> None:
    walks = {name: walked(name) for name in ("grass_50mm", "carpet_4mm")}
    results = results_of(toy_trials())
    shown = Results(
        **{
            **vars(results),
            "log": lambda name: walks[name][1],
            "trial": lambda name: walks[name][0],
        }
    )
    pair = telling_pair(results, *results.variants)
    assert pair is not None
    named = pair._replace(
        fall=pd.Series({"trial_id": "grass_50mm"}), other=pd.Series({"trial_id": "carpet_4mm"})
    )
    write_strip(shown, named, tmp_path / "strip.png")
    assert 20_000 < (tmp_path / "strip.png").stat().st_size < 400_000
