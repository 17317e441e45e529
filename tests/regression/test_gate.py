"""The decision of the gate, on nights whose truth is known."""

from __future__ import annotations

import json
import re
from dataclasses import replace

import numpy as np
import pytest

from gaitlab.regression import Baseline, compared, outcome_json, outcome_page, quantities
from gaitlab.regression.matching import matched
from gaitlab.regression.quantities import FALSE_ALARMS
from tests.regression.nights import night

NIGHTS = 60  # benchmarks/gate.py counts 2000, of real walks


def found(before: Baseline, tonight: Baseline) -> set[tuple[str, str]]:
    return {(q.name, q.surface) for q in compared(before, tonight).worse}


def test_equal_bits_are_the_end_of_it():
    outcome = compared(night(1), night(1))
    assert (outcome.mode, outcome.exit_code, outcome.compared) == ("exact", 0, 48)
    assert outcome.quantities == ()


def test_a_few_walks_with_equal_bits_are_enough():
    assert compared(night(1, seeds=range(2)), night(1, seeds=range(2))).mode == "exact"


def test_one_changed_bit_is_named_and_no_alarm():
    before = night(1)
    last = replace(before.walks[-1], log_digest="another")
    outcome = compared(before, replace(before, walks=(*before.walks[:-1], last)))
    assert outcome.differing == [last.trial_id]
    assert (outcome.mode, outcome.exit_code) == ("paired", 0)
    assert last.trial_id[:8] in outcome_page("edge", outcome)


def on(night_there: Baseline, *processors: str) -> Baseline:
    return replace(night_there, provenance={**night_there.provenance, "processor": processors})


def test_other_bits_on_another_processor_are_put_down_to_it_and_on_the_same_one_to_nobody_known():
    before, other = on(night(1), "one"), on(night(1), "another")
    last = replace(before.walks[-1], log_digest="another")
    elsewhere = compared(before, replace(other, walks=(*other.walks[:-1], last)))
    assert list(elsewhere.surroundings) == [("processor", "one", "another")]
    assert (elsewhere.mode, elsewhere.exit_code) == ("paired", 0)
    assert json.loads(outcome_json("edge", elsewhere))["surroundings"] == [
        {"name": "processor", "before": "one", "tonight": "another"}
    ]
    page = outcome_page("edge", elsewhere)
    assert "- processor: one -> another" in page
    assert "the versions, the processor or the code above did" in page
    here = compared(before, replace(before, walks=(*before.walks[:-1], last)))
    assert here.surroundings == []
    assert "nothing that is known did" in outcome_page("edge", here)


@pytest.mark.parametrize("processors", [(), ("one", "another")], ids=["unknown", "two"])
def test_only_one_known_processor_is_the_same_as_before(processors: tuple[str, ...]):
    before = on(night(1), "one")
    tonight = on(night(1), *processors) if processors else night(1)
    names = [name for name, _, _ in compared(before, tonight).surroundings]
    assert names == ["processor"]
    assert compared(before, tonight).mode == "exact"  # equal bits are equal wherever they come from


@pytest.mark.parametrize("seeds", [range(12), range(100, 112)], ids=["paired", "unpaired"])
def test_nights_of_pure_noise_raise_hardly_any_alarm(seeds):
    alarms = 0
    for k in range(NIGHTS):
        runs = matched(night(2 * k), night(2 * k + 1, seeds=seeds))
        alarms += any(q.finding == "worse" for q in quantities.tested(runs))
    # At most 1 % is claimed; of 60 nights four or more would then be a chance of 0.3 %.
    assert alarms <= 3


@pytest.mark.parametrize("seeds", [range(12), range(100, 112)], ids=["paired", "unpaired"])
def test_a_gait_that_falls_more_often_is_caught(seeds):
    worse = [found(night(k), night(50 + k, share=0.1, seeds=seeds)) for k in range(10)]
    assert sum(("stable", "") in quantities for quantities in worse) >= 8


@pytest.mark.parametrize("seeds", [range(12), range(100, 112)], ids=["paired", "unpaired"])
def test_more_rocking_is_worse_and_less_is_better(seeds):
    before, rocking = night(1), night(2, pitch=0.13, seeds=seeds)
    assert ("pitch_amplitude", "") in found(before, rocking)
    calm = compared(before, night(3, pitch=0.07, seeds=seeds))
    assert (calm.exit_code, [q.name for q in calm.improved]) == (0, ["pitch_amplitude"])


@pytest.mark.parametrize("seeds", [range(12), range(100, 112)], ids=["paired", "unpaired"])
def test_what_would_be_noticed_is_noticed_four_times_in_five(seeds):
    told = [
        q.detectable
        for k in range(6)
        for q in compared(night(k), night(20 + k, seeds=seeds)).quantities
        if q.name == "pitch_amplitude"
    ]
    caught = [
        any(
            (q.name, q.finding) == ("pitch_amplitude", "worse")
            for q in quantities.tested(
                matched(night(k), night(100 + k, pitch=0.1 + np.mean(told), seeds=seeds))
            )
        )
        for k in range(60)
    ]
    assert 0.6 < np.mean(caught) < 0.99


def test_without_common_seeds_cells_are_compared_and_it_is_said():
    before, tonight = night(1), night(2, seeds=range(50, 62))
    outcome = compared(before, tonight)
    assert outcome.mode == "unpaired"
    assert "without common seeds" in outcome_page("edge", outcome)


def test_fewer_seeds_are_compared_with_their_own_partners():
    before = night(1)
    half = replace(before, walks=tuple(walk for walk in before.walks if walk.seed < 10))
    changed = tuple(replace(walk, log_digest="x") for walk in half.walks)
    outcome = compared(before, replace(half, walks=changed))
    assert (outcome.mode, outcome.runs.n) == ("paired", 40)
    assert all(q.difference == 0.0 for q in outcome.quantities)


def test_an_empty_comparison_is_undecided():
    outcome = compared(night(1), replace(night(2), walks=()))
    assert (outcome.mode, outcome.exit_code) == ("none", 6)


def test_too_few_seeds_say_how_many_would_do():
    outcome = compared(night(1, seeds=range(3)), night(2, seeds=range(3)))
    assert outcome.exit_code == 6
    assert re.search(r"with 3 seeds a cell.*some \d+ seeds a cell would do", outcome.undecided)


def test_a_single_seed_never_decides():
    outcome = compared(night(1, share=1.0, seeds=range(1)), night(2, share=0.0, seeds=range(1)))
    assert (outcome.verdict, outcome.exit_code) == ("undecided", 6)


def test_with_the_seeds_it_asks_for_it_decides():
    refused = compared(night(1, seeds=range(3)), night(2, seeds=range(3))).undecided
    asked = int(refused.split("; some ")[1].split()[0])
    needed = round(1.5 * asked)  # the shares are drawn anew, so a few more make sure
    assert compared(night(1, seeds=range(needed)), night(2, seeds=range(needed))).exit_code == 0


def test_cells_in_which_everybody_falls_cannot_get_worse():
    assert "stays up more often" in compared(night(1, share=0.0), night(2, share=0.0)).undecided


def test_a_redefined_metric_is_no_regression():
    before = night(1)
    doubled = tuple(
        replace(w, metrics={**w.metrics, "distance": 2.0 * float(str(w.metrics["distance"]))})
        for w in before.walks
    )
    outcome = compared(before, replace(before, walks=doubled))
    assert (outcome.exit_code, outcome.worse) == (6, [])
    assert "distance is not defined as it was" in outcome.undecided


def test_what_was_declared_and_what_surrounds_it_is_said():
    before = night(1)
    later = replace(night(2), basis={"gait": "f" * 16}, provenance={"code": ("abc",)})
    page = outcome_page("edge", compared(before, later))
    assert "Declared: gait changed" in page
    assert "-> abc" in page


def test_a_page_states_its_false_alarm_rate_and_what_it_would_notice():
    page = outcome_page("edge", compared(night(1), night(2)))
    assert f"{100.0 * FALSE_ALARMS:.0f} % of nights" in page
    assert "would notice" in page


def fallen(night_before: Baseline, k: int | None = None) -> Baseline:
    """The same trials with other bits, of which the first k fell; all by default."""
    walks = tuple(
        replace(
            w, log_digest="other", metrics={**w.metrics, "stable": False, "stable_strict": False}
        )
        if k is None or place < k
        else w
        for place, w in enumerate(night_before.walks)
    )
    return replace(night_before, walks=walks)


def one_cell(seeds: int) -> Baseline:
    before = night(1, share=1.0, seeds=range(seeds))
    return replace(before, walks=tuple(w for w in before.walks if w.place == before.walks[0].place))


def test_six_of_six_that_fell_are_in_the_first_line_though_nothing_is_decided():
    before = one_cell(6)
    outcome = compared(before, fallen(before))
    page = outcome_page("edge", outcome)
    assert outcome.exit_code == 6
    first = page.splitlines()[0]
    assert "0 of 6" in first
    assert first.count("6 of 6") == 2  # falls, and trials with other bits
    assert "| 6 of 6 | 0 of 6 |" in page
    assert {q.finding for q in outcome.quantities} == {"undecided"}


def test_cells_that_changed_are_counted_and_the_others_not():
    before = night(1, share=1.0)
    outcome = compared(before, fallen(before, 12))
    changed = outcome.falls.changed
    assert [(c.before.stable, c.tonight.stable) for c in changed] == [(12, 0)]
    assert "from 0 of 12 to 12 of 12" in outcome_page("edge", outcome).splitlines()[0]


def test_falls_are_those_of_the_walks_that_are_compared():
    before = night(1, share=1.0)
    outcome = compared(before, night(2, share=0.0, seeds=range(6)))
    assert (outcome.falls.before.n, outcome.falls.tonight.n) == (24, 24)
    assert (outcome.falls.before.fell, outcome.falls.tonight.fell) == (0, 24)


def test_nights_without_a_common_cell_are_counted_all_the_same():
    outcome = compared(one_cell(6), replace(night(2), walks=night(2, share=0.0).walks[12:24]))
    assert outcome.exit_code == 6
    first = outcome_page("edge", outcome).splitlines()[0]
    assert "0 of 6" in first
    assert "12 of 12" in first


def one_partner(before: Baseline, tonight: Baseline, move: int) -> Baseline:
    """Tonight with each seed called by another one's name, the same in all cells."""
    named = {w.seed: (w.seed + move) % 12 for w in tonight.walks}
    return replace(before, walks=tuple(replace(w, seed=named[w.seed]) for w in tonight.walks))


def test_seeds_whose_cells_share_their_luck_raise_hardly_any_alarm():
    """Every walk of a seed is alike, so that there are twelve outcomes and not 48."""

    def alike(draw: int) -> Baseline:
        drawn = night(draw, share=0.5)
        first = {w.seed: w.metrics for w in reversed(drawn.walks)}
        return replace(drawn, walks=tuple(replace(w, metrics=first[w.seed]) for w in drawn.walks))

    alarms = 0
    for k in range(NIGHTS):
        runs = matched(alike(2 * k), one_partner(alike(2 * k), alike(2 * k + 1), k))
        alarms += any(q.finding == "worse" for q in quantities.tested(runs))
    assert alarms <= 3


def test_no_walk_of_either_night_is_left_out_of_the_falls():
    before, tonight = night(1), night(1)
    new = [replace(walk, cell={**walk.cell, "surface": "hard_floor"}) for walk in tonight.walks]
    fallen = [
        replace(walk, metrics={**walk.metrics, "stable": False, "stable_strict": False})
        for walk in new[:12]
    ]
    more_seeds = [replace(walk, seed=walk.seed + 99) for walk in before.walks[:5]]
    before = replace(before, walks=(*before.walks, *more_seeds))
    tonight = replace(tonight, walks=(*tonight.walks, *fallen))
    found = compared(before, tonight)
    counts = json.loads(outcome_json("edge", found))["falls"]
    for side, night_ in (("before", before), ("tonight", tonight)):
        parts = [counts[side], counts[f"alone_{side}"]]
        assert sum(part["n"] for part in parts) == len(night_.walks)
        assert sum(part["fell"] for part in parts) == sum(not w.stable for w in night_.walks)
    assert "12 of 12 that only tonight has" in outcome_page("edge", found).splitlines()[0]
