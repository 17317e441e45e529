"""What racing may give up, and what it may not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitlab.experiment.study import Aggregate, Constraint, Numbers, Objective, Racing, Study
from gaitlab.search.objectives import TrialOutcome, evaluate, score
from gaitlab.search.racing import Rival, best_of, hopeless, reachable

SEEDS = 8
PLACES = [(surface, seed) for seed in range(SEEDS) for surface in ("grass", "carpet")]
SPEED = Objective(metric="walking_speed", direction="maximize")
STABLE = Constraint(metric="stable", bound=0.75, at_least=True)
AGGREGATES = [
    Aggregate(),
    Aggregate(kind="worst"),
    Aggregate(kind="quantile", share=0.25),
    Aggregate(kind="cvar", share=0.5),
]


def study(*objectives: Objective, constraints: tuple[Constraint, ...] = ()) -> Study:
    return Study(
        sampler="random",
        sampler_options={},
        trials=10,
        seed=0,
        batch=4,
        search=(Numbers(path="gait.step_height", low=0.01, high=0.06),),
        objectives=objectives or (SPEED,),
        constraints=constraints,
        racing=Racing(rounds=(2, 4, 8)),
        early_stop=None,
    )


def outcomes(speeds: np.ndarray, falls: np.ndarray | None = None) -> list[TrialOutcome]:
    """One trial a place, in the order of the places."""
    fell = np.zeros(len(speeds), dtype=bool) if falls is None else falls
    return [
        TrialOutcome(
            surface=surface,
            seed=seed,
            state="DONE",
            metrics={
                "walking_speed": float(speed),
                "fell": bool(down),
                "stable": not down,
                "walked_time": 4.0,
            },
        )
        for (surface, seed), speed, down in zip(PLACES, speeds, fell, strict=False)
    ]


trials = (
    st.integers(0, 2**32 - 1)
    .map(np.random.default_rng)
    .map(
        lambda random: outcomes(
            random.uniform(-0.1, 0.3, len(PLACES)), random.random(len(PLACES)) < random.random()
        )
    )
)


@given(
    trials, st.integers(1, len(PLACES)), st.sampled_from(AGGREGATES), st.sampled_from(AGGREGATES)
)
def test_nothing_better_comes_than_what_is_reachable(
    whole: list[TrialOutcome], walked: int, seeds: Aggregate, surfaces: Aggregate
) -> None:
    for wanted in (SPEED, STABLE, replace(SPEED, direction="minimize")):
        item = replace(wanted, over_seeds=seeds, over_surfaces=surfaces)
        best, found = reachable(item, whole[:walked], PLACES), score(item, whole)
        assert best >= found - 1e-9 if item.direction == "maximize" else best <= found + 1e-9


@given(trials, st.integers(2, len(PLACES)), st.sampled_from(AGGREGATES))
def test_a_candidate_stopped_by_a_constraint_would_have_broken_it(
    whole: list[TrialOutcome], walked: int, seeds: Aggregate
) -> None:
    wanted = study(constraints=(replace(STABLE, over_seeds=seeds),))
    if hopeless(wanted, whole[:walked], PLACES, []):
        assert not evaluate(wanted, whole).feasible


@given(trials, trials, st.integers(2, len(PLACES)))
def test_a_candidate_called_certainly_worse_would_have_been(
    one: list[TrialOutcome], other: list[TrialOutcome], walked: int
) -> None:
    worst = replace(SPEED, over_seeds=Aggregate(kind="worst"), over_surfaces=AGGREGATES[1])
    wanted = study(worst)
    reason = hopeless(wanted, one[:walked], PLACES, [Rival(number=1, outcomes=other)])
    if "certainly" in reason:
        assert score(worst, one) < score(worst, other)


@given(trials, trials, st.integers(2, len(PLACES)), st.randoms(use_true_random=False))
def test_the_order_in_which_trials_ended_decides_nothing(
    one: list[TrialOutcome], other: list[TrialOutcome], walked: int, chance: object
) -> None:
    mixed = one[:walked]
    chance.shuffle(mixed)  # type: ignore[attr-defined]
    rivals = [Rival(number=1, outcomes=other)]
    wanted = study(constraints=(STABLE,))
    assert hopeless(wanted, mixed, PLACES, rivals) == hopeless(wanted, one[:walked], PLACES, rivals)


@given(trials, st.integers(2, len(PLACES)))
def test_nobody_loses_against_an_equal(whole: list[TrialOutcome], walked: int) -> None:
    assert hopeless(study(), whole[:walked], PLACES, [Rival(number=1, outcomes=whole)]) == ""


def test_a_robot_that_is_slower_with_every_seed_is_given_up_after_two() -> None:
    slow, fast = np.full(16, 0.08) + np.linspace(0, 0.01, 16), np.full(16, 0.15)
    rival = [Rival(number=7, outcomes=outcomes(fast))]
    reason = hopeless(study(), outcomes(slow)[:4], PLACES, rival)
    assert reason == "walking_speed is probably worse than candidate 7"


def test_noise_of_the_seeds_is_no_reason() -> None:
    random = np.random.default_rng(4)
    one, other = random.normal(0.10, 0.05, 16), random.normal(0.11, 0.05, 16)
    rival = [Rival(number=7, outcomes=outcomes(other))]
    assert hopeless(study(), outcomes(one)[:8], PLACES, rival) == ""


@pytest.mark.long
def test_the_better_of_two_equally_noisy_ones_is_seldom_given_up() -> None:
    """At a confidence of 0.9 no more than about one in ten, whichever round it is."""
    random, wrong, total = np.random.default_rng(0), 0, 1000
    for _ in range(total):
        common = random.normal(0.0, 0.03, 16)
        one = outcomes(0.11 + common + random.normal(0.0, 0.02, 16))
        other = outcomes(0.11 + common + random.normal(0.0, 0.02, 16))
        wrong += bool(hopeless(study(), one[:8], PLACES, [Rival(number=1, outcomes=other)]))
    assert wrong / total < 0.13


def test_worse_on_the_worst_ground_alone_is_enough_for_a_worst_case() -> None:
    wanted = study(replace(SPEED, over_surfaces=Aggregate(kind="worst")))
    good = outcomes(np.tile([0.10, 0.20], 8) + np.linspace(0.0, 0.001, 16))
    bad = outcomes(np.tile([0.02, 0.30], 8) + np.linspace(0.0, 0.002, 16))
    reason = hopeless(wanted, bad[:8], PLACES, [Rival(number=2, outcomes=good)])
    assert reason == "walking_speed on grass is probably worse than candidate 2"
    assert hopeless(wanted, good[:8], PLACES, [Rival(number=3, outcomes=bad)]) == ""


def test_a_candidate_is_beaten_only_by_one_that_is_better_in_everything() -> None:
    drift = Objective(metric="lateral_drift", direction="minimize")
    slow = outcomes(np.full(16, 0.05))
    fast = outcomes(np.full(16, 0.15))
    with_drift = [
        [replace(o, metrics={**o.metrics, "lateral_drift": d}) for o in trials]
        for trials, d in ((slow, 0.01), (fast, 0.30))
    ]
    rival = [Rival(number=1, outcomes=with_drift[1])]
    assert hopeless(study(SPEED, drift), with_drift[0][:8], PLACES, rival) == ""
    assert hopeless(study(SPEED), with_drift[0][:8], PLACES, rival) != ""


@pytest.mark.parametrize("state", ["INFEASIBLE", "FAILED"])
def test_a_lost_trial_ends_it(state: str) -> None:
    lost = [replace(outcomes(np.full(1, 0.1))[0], state=state, metrics={})]
    assert hopeless(study(), lost, PLACES, []) == f"{state} on grass with seed 0"


def test_the_best_of_several_breaks_no_constraint() -> None:
    fallen = outcomes(np.full(16, 0.3), np.ones(16, dtype=bool))
    rivals = [
        Rival(number=0, outcomes=fallen),
        Rival(number=1, outcomes=outcomes(np.full(16, 0.1))),
        Rival(number=2, outcomes=outcomes(np.full(16, 0.2))),
    ]
    assert [r.number for r in best_of(study(constraints=(STABLE,)), rivals)] == [2]
