"""Efficiencies and their gain, against the paper's own numbers and laws of the draws."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gaitlab.experiment.reference import load_reference
from gaitlab.papers.reproduction.answers import answers, forward_only
from gaitlab.papers.reproduction.efficiency import claims, differing, gain_draws
from gaitlab.papers.reproduction.headline import efficiencies, paired_runs, scored
from gaitlab.report.matching import matched
from gaitlab.report.scores import efficiency_draws
from tests.papers.reproduction.printed import printed_results, printed_trials
from tests.report.builder import results_of


def both(outcome=None, seeds=4):
    results = printed_results(*([outcome] if outcome else []), seeds=seeds)
    return answers({"a": results}, ["a"])


def test_the_papers_claims_are_those_that_counting_gives() -> None:
    stated, counted, forward, implied = claims()
    assert (stated.without, stated.with_) == (32.0, 80.0)
    assert (counted.without, counted.with_) == (50.0, 80.0)
    assert forward.without == pytest.approx(100 * (1 + 1 + 3 + 6) / 28)
    assert forward.with_ == pytest.approx(100 * (5 + 5 + 6 + 7) / 28)
    assert (implied.without, implied.with_) == (32.5, 80.0)


def test_results_as_printed_have_the_counted_efficiencies() -> None:
    before, after = both()
    found = efficiencies(before, after)
    assert (found.without, found.with_, found.gain) == (50.0, 80.0, 30.0)
    forward = efficiencies(forward_only(before), forward_only(after))
    assert forward.gain == pytest.approx(100 * 12 / 28)


@pytest.mark.parametrize("kept", [1.0, 0.6])
@pytest.mark.parametrize("draw", range(4))
def test_what_differs_adds_up_to_what_the_gain_lacks(draw: int, kept: float) -> None:
    generator = np.random.default_rng(draw)
    verdicts: dict[object, bool] = {}

    def outcome(table, place, stable, seed):
        return verdicts.setdefault((table, place), bool(generator.random() < 0.5))

    results = printed_results(outcome)
    rows = results.trials["gait.step_length"] <= (0.12 if kept == 1.0 else 0.04)
    some = replace(results, trials=results.trials[rows])
    (column,) = scored(answers({"a": some}, ["a"]), {})
    printed = {
        name: [c for c in column.cells if c.table.name == name]
        for name in ("eros_table7", "eros_table8")
    }
    here, theirs = (
        [100.0 * np.mean([side(c) for c in cells]) for cells in printed.values()]
        for side in (lambda c: c.ours.verdict("stable"), lambda c: c.printed)
    )
    found = differing(column.cells)
    assert len(found) > 2
    assert sum(each.points for each in found) == pytest.approx(
        (here[1] - here[0]) - (theirs[1] - theirs[0])
    )
    assert sum(each.n for each in found) == sum(not cell.agrees() for cell in column.cells)
    assert [each.points for each in found] == sorted(each.points for each in found)


def test_nothing_differs_where_all_is_as_printed() -> None:
    (column,) = scored(both(), {})
    assert differing(column.cells) == []


def test_many_seeds_make_the_gain_certain() -> None:
    before, after = both(seeds=60)
    low, high = efficiencies(before, after).gain_interval
    assert low == high == pytest.approx(30.0)


def test_the_gain_of_nothing_is_symmetric_about_zero() -> None:
    def outcome(table, place, stable, seed):
        return seed % 2 == 0

    before, after = both(outcome, seeds=10)
    draws = gain_draws(paired_runs(before, after))
    assert abs(np.mean(draws)) < 1.0  # points; the draws spread by some ten
    assert np.mean(draws > 0) == pytest.approx(np.mean(draws < 0), abs=0.05)


def test_the_gain_backward_is_the_loss() -> None:
    def outcome(table, place, stable, seed):
        return stable if seed < 3 else not stable

    before, after = both(outcome, seeds=5)
    there, back = (gain_draws(paired_runs(*pair)) for pair in ((before, after), (after, before)))
    assert np.mean(there) == pytest.approx(-np.mean(back), abs=1.0)
    assert np.std(there) == pytest.approx(np.std(back), rel=0.1)


def test_each_side_of_a_pair_alone_has_the_draws_of_a_single_variant() -> None:
    def outcome(table, place, stable, seed):
        return table == "eros_table7" and seed < 2  # after: never

    before, after = both(outcome, seeds=4)
    alone = efficiency_draws(before.columns)
    never = efficiency_draws(after.columns, stream=1)
    paired = -gain_draws(paired_runs(before, after))
    assert np.mean(paired) == pytest.approx(np.mean(alone) - np.mean(never), abs=1.0)


def test_pairs_that_go_together_give_a_narrower_gain_than_independent_ones() -> None:
    def together(table, place, stable, seed):
        return seed < 5

    def apart(table, place, stable, seed):
        return seed < 5 if table == "eros_table7" else seed >= 5

    widths = [
        np.std(gain_draws(paired_runs(*both(outcome, seeds=10)))) for outcome in (together, apart)
    ]
    assert widths[0] < 0.8 * widths[1]


def test_cells_out_of_reach_on_one_side_are_certain() -> None:
    trials = [
        {**row, "state": "INFEASIBLE", "stable": None} if row["gait.heel_strike"] == "add" else row
        for row in printed_trials(lambda *_: True, seeds=60)
    ]
    before, after = answers({"a": results_of(trials)}, ["a"])
    draws = gain_draws(paired_runs(before, after))
    assert set(draws) == {-100.0}


def test_without_common_seeds_the_gain_is_of_independent_draws() -> None:
    first, second = (
        results_of([row for row in printed_trials() if row["gait.heel_strike"] == heel])
        for heel in ("none", "add")
    )
    shifted = second.trials.assign(seed=second.trials["seed"] + 100)
    second = replace(
        second,
        trials=shifted,
        variants=tuple(replace(v, compare=load_reference("eros_table8")) for v in second.variants),
    )
    before, after = answers({"a": first, "b": second}, ["a", "b"])
    found = efficiencies(before, after)
    assert not found.paired
    assert found.gain == 30.0
    assert not matched(first, first.variants[0], first.variants[0]).unshared
