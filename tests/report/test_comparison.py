"""The comparison of a report: says which is better when it is, and nothing when it is not."""

from __future__ import annotations

import re

import numpy as np
import pytest

from gaitlab.report.comparison import (
    Comparison,
    compared_grounds,
    compared_variants,
    comparison_blocks,
)
from gaitlab.report.matching import Matched, matched, matched_grounds
from gaitlab.report.page import not_told_apart, seeds_needed, told_apart
from gaitlab.report.results import Results
from gaitlab.statistics import judged
from tests.report.builder import results_of, trial

SURFACES = ("grass_50mm", "carpet_4mm")


def walks(
    seeds: range = range(20),
    *,
    shares: tuple[float, float] = (0.9, 0.3),
    rows: tuple[float, ...] = (0.04, 0.08),
    shift: float = 0.0,
    draw: int = 0,
    second_seeds: range | None = None,
) -> Results:
    """Two variants, plain and with heel strike, that stay up with these shares."""
    rng = np.random.default_rng(draw)
    found = []
    variants = (("none", shares[0], seeds), ("add", shares[1], second_seeds or seeds))
    for heel, share, given in variants:
        for surface in SURFACES:
            for row in rows:
                for seed in given:
                    up = bool(rng.random() < share)
                    walk = trial(row, surface, heel, seed, up=up) | {"stable_strict": up}
                    added = shift if heel == "add" else 0.0
                    walk |= {"pitch_amplitude": 0.1 + added + 0.01 * rng.normal()}
                    found.append(walk | {"cost_of_transport": 1.0 + 0.1 * rng.normal()})
    return results_of(found, compare=False)


def pairs(results: Results) -> Matched:
    return matched(results, *results.variants)


def comparison(results: Results) -> str:
    blocks = comparison_blocks(results, compared_variants(results), compared_grounds(results))
    return "\n\n".join(block for block in blocks if block)


def only(results: Results) -> Comparison:
    (found,) = compared_variants(results)
    return found


def line(page: str, start: str) -> str:
    return next(text for text in page.splitlines() if text.startswith(f"| {start}"))


def only_plain(results: Results, *surfaces: str) -> Results:
    trials = results.trials.drop(columns="variant").to_dict("records")
    plain = [walk for walk in trials if walk["gait.heel_strike"] == "none"]
    return results_of([w for w in plain if w["surface"] in surfaces], paths=(), compare=False)


def test_one_variant_on_one_ground_is_nothing_to_compare():
    assert comparison(only_plain(walks(), SURFACES[0])) == ""


def test_of_one_variant_the_grounds_are_compared_pair_by_pair():
    results = only_plain(walks(), *SURFACES[:2])
    runs = matched_grounds(results, *SURFACES[:2])
    assert runs.paired
    assert (runs.first["seed"] == runs.second["seed"]).all()
    assert set(runs.first["surface"]) == {SURFACES[0]}
    assert set(runs.second["surface"]) == {SURFACES[1]}
    assert compared_grounds(results)[0].counted.startswith("40 pairs")


def test_two_grounds_are_compared_over_all_variants() -> None:
    results = walks()
    trials = results.trials.drop(columns="variant").to_dict("records")
    two = results_of([w for w in trials if w["surface"] in SURFACES[:2]], compare=False)
    (grounds,) = compared_grounds(two)
    assert grounds.counted.startswith("80 pairs")
    assert "### carpet 4 mm against grass 50 mm" in comparison(two)


def test_a_ground_is_as_much_better_as_the_other_is_worse():
    results = only_plain(walks(), *SURFACES[:2])
    there = matched_grounds(results, *SURFACES[:2]).contrast("stable")
    back = matched_grounds(results, *reversed(SURFACES[:2])).contrast("stable")
    assert there.difference == -back.difference
    assert there.p_value == back.p_value


def test_the_gait_that_falls_is_worse_and_the_other_way_round_better():
    worse = comparison(walks())
    assert "**worse**" in line(worse, "stable runs")
    assert "stays up less often than *plain*" in told_apart([only(walks())])
    assert "**better**" in line(comparison(walks(shares=(0.3, 0.9))), "stable runs")


def test_less_rocking_is_better_because_the_metric_says_so():
    page = comparison(walks(shares=(1.0, 1.0), shift=-0.03))
    assert "**better**" in line(page, "pitch amplitude")
    assert "less is better" in line(page, "pitch amplitude")


def test_equal_gaits_cannot_be_told_and_it_says_how_many_seeds_would():
    page = comparison(walks(shares=(0.7, 0.7), draw=3))
    stable = line(page, "stable runs")
    assert "cannot tell" in stable
    assert re.search(r"\| +(\d+|more than 1000) +\|$", stable)


def test_there_is_one_verdict_on_a_question_and_its_advice_asks_for_more_seeds():
    for draw in range(6):
        results = walks(range(3), shares=(0.9, 0.6), draw=draw)
        found = only(results)
        assert found.stable.verdict == "cannot tell"
        seeds = seeds_needed([found])
        said = not_told_apart([found])
        if seeds is None:
            assert "some" not in said
        else:
            assert seeds > 3
            assert f"some {seeds} seeds a cell" in said
            assert re.search(rf"\| +{seeds} +\|$", line(comparison(results), "stable runs"))
        assert told_apart([found]) == ""


def test_of_comparisons_without_a_difference_few_name_one():
    named = 0
    for draw in range(20):
        found = only(walks(range(10), shares=(0.7, 0.7), draw=draw))
        family = [found.stable, *found.columns.values(), *found.metrics]
        named += any(item.verdict in ("better", "worse") for item in family)
    assert named <= 6  # 10 % claimed of two families; seven or more of 20 are a chance of 0.2 %


def test_runs_are_paired_by_seed_whatever_their_order():
    results = walks()
    runs = pairs(results)
    assert runs.paired
    assert (runs.first["seed"] == runs.second["seed"]).all()
    assert (runs.first["cell"] == runs.second["cell"]).all()
    shuffled = results.trials.sample(frac=1.0, random_state=1)
    again = pairs(results_of(shuffled.drop(columns="variant").to_dict("records"), compare=False))
    assert again.contrast("stable").difference == runs.contrast("stable").difference


def test_without_common_seeds_cells_are_compared_and_it_is_said():
    results = walks(second_seeds=range(50, 75))
    page = comparison(results)
    assert "without common seeds" in only(results).counted
    assert "**worse**" in line(page, "stable runs")
    assert not pairs(results).paired


def test_only_shared_cells_are_compared_and_the_rest_is_counted():
    results = walks()
    trials = [
        walk
        for walk in results.trials.drop(columns="variant").to_dict("records")
        if walk["gait.step_length"] != 0.08 or walk["gait.heel_strike"] == "none"
    ]
    found = only(results_of(trials, compare=False))
    assert found.unshared.startswith("2 cells")
    assert found.counted.startswith("40 pairs")


def test_nothing_shared_is_said_to_be_that():
    trials = [
        walk
        for walk in walks().trials.drop(columns="variant").to_dict("records")
        if (walk["gait.step_length"] == 0.08) == (walk["gait.heel_strike"] == "none")
    ]
    assert "share no cell" in comparison(results_of(trials, compare=False))


def test_a_difference_is_second_less_first():
    contrast = pairs(walks(shares=(1.0, 1.0), shift=0.05)).contrast("pitch_amplitude")
    assert contrast.difference == pytest.approx(0.05, abs=0.01)
    assert contrast.second - contrast.first == pytest.approx(contrast.difference)
    assert contrast.interval.low < contrast.difference < contrast.interval.high


def test_a_metric_of_a_walk_is_not_taken_from_falls_but_distance_is():
    runs = pairs(walks(shares=(1.0, 0.5)))
    assert runs.contrast("distance").n == runs.n
    assert runs.contrast("pitch_amplitude").n < runs.n


def test_one_seed_a_cell_and_a_metric_nobody_has_are_no_trouble():
    page = comparison(walks(range(1)))
    assert "cannot tell" in page
    nothing = pairs(walks()).contrast("peak_torque")
    assert (nothing.n, judged([nothing])[0].verdict) == (0, "no data")


def test_the_same_trials_give_the_same_page():
    assert comparison(walks()) == comparison(walks())


def test_infeasible_steps_count_as_not_stable():
    found = [trial(0.04, "grass_50mm", "none", seed) for seed in range(12)]
    found += [trial(0.04, "grass_50mm", "add", seed, state="INFEASIBLE") for seed in range(12)]
    assert "**worse**" in line(comparison(results_of(found, compare=False)), "stable runs")
