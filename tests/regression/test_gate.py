"""The decision of the gate, on nights whose truth is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gaitlab.errors import Undecided
from gaitlab.regression import Baseline, compared, summary_page
from gaitlab.regression.quantities import FALSE_ALARMS
from tests.regression.nights import night

NIGHTS = 60  # benchmarks/gate.py counts 200, of real walks


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
    assert last.trial_id[:8] in summary_page(before, before, outcome)


@pytest.mark.parametrize("seeds", [range(12), range(100, 112)], ids=["paired", "unpaired"])
def test_nights_of_pure_noise_raise_hardly_any_alarm(seeds):
    alarms = sum(
        bool(compared(night(2 * k), night(2 * k + 1, seeds=seeds)).worse) for k in range(NIGHTS)
    )
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


def test_what_would_be_noticed_is_noticed_four_times_in_five():
    before = night(1)
    quantity = next(q for q in compared(before, night(2)).quantities if q.name == "pitch_amplitude")
    caught = [
        ("pitch_amplitude", "") in found(night(k), night(100 + k, pitch=0.1 + quantity.detectable))
        for k in range(60)
    ]
    assert 0.6 < np.mean(caught) < 0.97


def test_without_common_seeds_cells_are_compared_and_it_is_said():
    before, tonight = night(1), night(2, seeds=range(50, 62))
    outcome = compared(before, tonight)
    assert outcome.mode == "unpaired"
    assert "without common seeds" in summary_page(before, tonight, outcome)


def test_fewer_seeds_are_compared_with_their_own_partners():
    before = night(1)
    half = replace(before, walks=tuple(walk for walk in before.walks if walk.seed < 10))
    changed = tuple(replace(walk, log_digest="x") for walk in half.walks)
    outcome = compared(before, replace(half, walks=changed))
    assert (outcome.mode, outcome.runs.n) == ("paired", 40)
    assert all(q.difference == 0.0 for q in outcome.quantities)


def test_an_empty_comparison_is_undecided():
    with pytest.raises(Undecided, match="nothing was compared"):
        compared(night(1), replace(night(2), walks=()))


def test_too_few_seeds_say_how_many_would_do():
    with pytest.raises(Undecided, match=r"with 3 seeds a cell.*some \d+ seeds a cell would do"):
        compared(night(1, seeds=range(3)), night(2, seeds=range(3)))


def test_with_the_seeds_it_asks_for_it_decides():
    with pytest.raises(Undecided) as refused:
        compared(night(1, seeds=range(3)), night(2, seeds=range(3)))
    asked = int(str(refused.value).split("; some ")[1].split()[0])
    needed = round(1.5 * asked)  # the shares are drawn anew, so a few more make sure
    assert compared(night(1, seeds=range(needed)), night(2, seeds=range(needed))).exit_code == 0


def test_cells_in_which_everybody_falls_cannot_get_worse():
    with pytest.raises(Undecided, match="stays up more often"):
        compared(night(1, share=0.0), night(2, share=0.0))


def test_a_redefined_metric_is_no_regression():
    before = night(1)
    doubled = tuple(
        replace(w, metrics={**w.metrics, "distance": 2.0 * float(str(w.metrics["distance"]))})
        for w in before.walks
    )
    with pytest.raises(Undecided, match="distance is not defined as it was"):
        compared(before, replace(before, walks=doubled))


def test_what_was_declared_and_what_surrounds_it_is_said():
    before = night(1)
    later = replace(night(2), basis={"gait": "f" * 16}, provenance={"code": ("abc",)})
    page = summary_page(before, later, compared(before, later))
    assert "Declared: gait changed" in page
    assert "-> abc" in page


def test_a_page_states_its_false_alarm_rate_and_what_it_would_notice():
    page = summary_page(night(1), night(2), compared(night(1), night(2)))
    assert f"{FALSE_ALARMS:.0%} of nights" in page
    assert "would notice" in page
