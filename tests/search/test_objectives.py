"""How good a candidate is: laws of aggregation, and that a fall never flatters."""

from __future__ import annotations

from dataclasses import replace
from math import inf, isfinite, isinf, nan

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from gaitlab.experiment import study as s
from gaitlab.experiment.study import BACKWARDS, MEASURED, MISLEADING, NOWHERE
from gaitlab.metrics import lookup
from gaitlab.search.objectives import (
    TrialOutcome,
    aggregated,
    counted,
    evaluate,
    misses,
    score,
    violation_names,
)

NUMBERS = st.floats(-1e3, 1e3).map(lambda x: round(x, 6))
LISTS = st.lists(NUMBERS, min_size=1, max_size=12)
SHARES = st.floats(0.01, 1.0)
DIRECTIONS = st.sampled_from(["maximize", "minimize"])
AGGREGATES = st.one_of(
    st.sampled_from(["mean", "worst"]).map(lambda kind: s.Aggregate(kind=kind)),
    st.builds(s.Aggregate, kind=st.sampled_from(["quantile", "cvar"]), share=SHARES),
)
METRICS = st.sampled_from(["energy", "walking_speed", "zmp_margin_p5", "saturation_share"])
OBJECTIVES = st.builds(
    s.Objective,
    metric=METRICS,
    direction=DIRECTIONS,
    over_seeds=AGGREGATES,
    over_surfaces=AGGREGATES,
    fallen=st.none() | NUMBERS,
)
CONSTRAINTS = st.builds(
    s.Constraint,
    metric=METRICS,
    bound=NUMBERS,
    at_least=st.booleans(),
    over_seeds=AGGREGATES,
    over_surfaces=AGGREGATES,
    fallen=st.none() | NUMBERS,
)


def study(*objectives: s.Objective, constraints: tuple[s.Constraint, ...] = ()) -> s.Study:
    return s.Study(
        sampler="tpe",
        sampler_options={},
        trials=10,
        seed=0,
        batch=4,
        search=(s.Numbers(path="gait.step_height", low=0.01, high=0.05),),
        objectives=objectives,
        constraints=constraints,
        racing=None,
        early_stop=None,
    )


STUDIES = st.builds(
    lambda objectives, constraints: study(*objectives, constraints=tuple(constraints)),
    st.lists(OBJECTIVES, min_size=1, max_size=2),
    st.lists(CONSTRAINTS, max_size=2),
)


def standing(surface: str = "floor", seed: int = 0, **metrics: float) -> TrialOutcome:
    found = {"fell": False, "stable": True, "walked_time": 10.0, "upright_time": 10.0, **metrics}
    return TrialOutcome(surface=surface, seed=seed, state="DONE", metrics=found)


def fallen(
    surface: str = "floor", seed: int = 0, after: float = 1.0, **metrics: float
) -> TrialOutcome:
    found = {"fell": True, "stable": False, "walked_time": after, "upright_time": after, **metrics}
    return TrialOutcome(surface=surface, seed=seed, state="DONE", metrics=found)


def unwalked(trial: TrialOutcome) -> TrialOutcome:
    return replace(trial, state="INFEASIBLE", metrics={})


TRIALS = st.lists(
    st.builds(
        lambda surface, seed, fell, time, values: (fallen if fell else standing)(
            surface, seed, **{"walked_time": time, "upright_time": time, **values}
        ),
        st.sampled_from(["floor", "grass"]),
        st.integers(0, 99),
        st.booleans(),
        st.floats(0.0, 20.0),
        st.fixed_dictionaries(
            {
                "energy": NUMBERS,
                "walking_speed": NUMBERS,
                "zmp_margin_p5": NUMBERS,
                "saturation_share": NUMBERS,
            }
        ),
    ),
    min_size=1,
    max_size=10,
)


def badness(wanted: s.Objective, value: float) -> float:
    return -value if wanted.direction == "maximize" else value


@given(STUDIES, TRIALS, st.randoms())
def test_the_order_of_the_trials_does_not_matter(asked, trials, chance) -> None:
    shuffled = list(trials)
    chance.shuffle(shuffled)
    assert evaluate(asked, shuffled) == evaluate(asked, trials)


@given(LISTS, DIRECTIONS, AGGREGATES)
def test_an_aggregate_lies_between_worst_and_best(values, direction, how) -> None:
    found = aggregated(how, values, direction)
    assert min(values) - 1e-9 <= found <= max(values) + 1e-9


@given(LISTS, AGGREGATES)
def test_the_worst_is_no_better_than_any_other_aggregate(values, how) -> None:
    worst = aggregated(s.Aggregate(kind="worst"), values, "maximize")
    assert worst == min(values)
    assert worst <= aggregated(how, values, "maximize") + 1e-9


@given(LISTS, DIRECTIONS)
def test_cvar_of_everything_is_the_mean(values, direction) -> None:
    mean = aggregated(s.Aggregate(), values, direction)
    whole = s.Aggregate(kind="cvar", share=1.0)
    assert aggregated(whole, values, direction) == pytest.approx(mean, abs=1e-9)


@given(LISTS, DIRECTIONS, st.floats(0.01, 1.0))
def test_cvar_and_quantile_of_at_most_one_trial_are_the_worst(values, direction, part) -> None:
    worst = aggregated(s.Aggregate(kind="worst"), values, direction)
    for kind in ("cvar", "quantile"):
        how = s.Aggregate(kind=kind, share=part / len(values))
        assert aggregated(how, values, direction) == pytest.approx(worst)


@given(LISTS, SHARES, SHARES, st.sampled_from(["quantile", "cvar"]))
def test_a_larger_share_from_the_worst_is_never_worse(values, one, other, kind) -> None:
    low, high = sorted((one, other))
    small, large = (s.Aggregate(kind=kind, share=share) for share in (low, high))
    assert aggregated(small, values, "maximize") <= aggregated(large, values, "maximize") + 1e-9


@given(LISTS, AGGREGATES)
def test_the_smallest_of_f_is_the_largest_of_minus_f(values, how) -> None:
    mirrored = aggregated(how, [-value for value in values], "maximize")
    assert aggregated(how, values, "minimize") == pytest.approx(-mirrored)


@given(LISTS, AGGREGATES, DIRECTIONS, st.integers(2, 3))
def test_a_whole_repetition_of_all_trials_changes_nothing(values, how, direction, times) -> None:
    assume(how.kind != "cvar" or how.share * len(values) >= 1.0)  # below, it is the worst alone
    repeated = aggregated(how, values * times, direction)
    assert repeated == pytest.approx(aggregated(how, values, direction), abs=1e-6)


def test_quantile_and_cvar_worked_by_hand() -> None:
    values = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]
    assert aggregated(s.Aggregate(kind="quantile", share=0.25), values, "maximize") == 2.0
    assert aggregated(s.Aggregate(kind="quantile", share=0.5), values, "minimize") == 5.0
    assert aggregated(s.Aggregate(kind="cvar", share=0.25), values, "maximize") == 1.5
    # Of 0.3 x 8 = 2.4 trials the third worst counts for 0.4.
    found = aggregated(s.Aggregate(kind="cvar", share=0.3), values, "maximize")
    assert found == pytest.approx((1.0 + 2.0 + 0.4 * 3.0) / 2.4)


@pytest.mark.parametrize("share", [k / 30 for k in range(1, 31)])
def test_a_share_of_whole_trials_is_not_moved_by_rounding(share: float) -> None:
    values = [float(k) for k in range(1, 31)]
    place = round(share * 30)
    how = s.Aggregate(kind="quantile", share=share)
    assert aggregated(how, values, "maximize") == place


@given(STUDIES, TRIALS, st.integers(0, 99), st.booleans(), st.floats(0.0, 20.0), METRICS, NUMBERS)
def test_a_fall_never_makes_a_candidate_look_better(
    asked, trials, place, walks, after, flattered, value
) -> None:
    place %= len(trials)
    before = trials[place]
    assume(not before.fell)
    after = fallen(before.surface, before.seed, after, **{flattered: value})
    instead = [*trials[:place], after if walks else unwalked(before), *trials[place + 1 :]]
    stood, fell = evaluate(asked, trials), evaluate(asked, instead)
    for wanted, was, now in zip(asked.objectives, stood.objectives, fell.objectives, strict=True):
        assert badness(wanted, now) >= badness(wanted, was) - 1e-9
    for was, now in zip(stood.violations, fell.violations, strict=True):
        assert now >= was - 1e-9
    assert stood.feasible or not fell.feasible


@given(STUDIES, TRIALS)
def test_violations_are_finite_and_say_whether_it_is_feasible(asked, trials) -> None:
    found = evaluate(asked, trials)
    assert all(map(isfinite, found.violations))
    assert found.feasible == all(violation <= 0.0 for violation in found.violations)
    assert len(found.violations) == len(violation_names(asked))
    assert found.n == len(trials)
    assert not found.feasible or all(map(isfinite, found.objectives))


def test_a_candidate_that_saves_energy_by_falling_has_no_value_and_is_not_feasible() -> None:
    asked = study(s.Objective(metric="energy", direction="minimize"))
    found = evaluate(asked, [standing(seed=0, energy=50.0), fallen(seed=1, energy=0.1)])
    assert found.objectives == (inf,)
    assert not found.feasible


def test_the_later_it_falls_the_smaller_the_violation() -> None:
    asked = study(s.Objective(metric="energy", direction="minimize"))
    sizes = [
        evaluate(asked, [fallen(seed=0, after=after), standing(seed=1, energy=5.0)]).violations[-1]
        for after in (0.0, 0.5, 2.0, 9.0)
    ]
    never = evaluate(asked, [unwalked(standing()), standing(seed=1, energy=5.0)]).violations[-1]
    assert never > sizes[0]
    assert sizes == sorted(sizes, reverse=True)
    assert len(set(sizes)) == 4


def test_gaits_that_all_miss_a_constraint_are_told_apart_by_how_soon_they_fall() -> None:
    speed = s.Constraint(metric="walking_speed", bound=0.2, at_least=True)
    asked = study(s.Objective(metric="upright_time", direction="maximize"), constraints=(speed,))
    falls = [evaluate(asked, [fallen(after=after, walking_speed=0.5)]) for after in (0.1, 1.0, 5.0)]
    assert [found.violations[0] for found in falls] == [1.0, 1.0, 1.0]
    sizes = [sum(found.violations) for found in falls]
    assert sizes == sorted(set(sizes), reverse=True)
    allowed = [standing(seed=seed, walking_speed=0.9) for seed in range(3)]
    assert evaluate(asked, [*allowed, fallen(seed=3)]).violations[1] == 0.0


def test_a_share_of_falls_can_be_allowed_by_a_quantile() -> None:
    half = s.Aggregate(kind="quantile", share=0.5)
    asked = study(s.Objective(metric="energy", direction="minimize", over_seeds=half))
    trials = [standing(seed=seed, energy=10.0 + seed) for seed in range(3)]
    found = evaluate(asked, [*trials, fallen(seed=3, energy=0.1)])
    assert found.objectives == (12.0,)  # the second worst of four
    assert found.feasible


def test_falls_can_be_given_a_value_and_nothing_counts_as_worse() -> None:
    wanted = s.Objective(metric="zmp_margin_p5", direction="maximize", fallen=-0.05)
    trials = [standing(zmp_margin_p5=v) for v in (0.01, -0.2)] + [fallen(zmp_margin_p5=0.03)]
    assert [counted(wanted, trial) for trial in trials] == [0.01, -0.05, -0.05]
    assert evaluate(study(wanted), trials).feasible


def test_a_robot_that_fell_gets_nowhere() -> None:
    wanted = s.Objective(metric="walking_speed", direction="maximize")
    trials = [standing(seed=0, walking_speed=0.2), fallen(seed=1, walking_speed=0.9)]
    assert evaluate(study(wanted), trials).objectives == (0.1,)


def test_time_on_the_feet_is_taken_as_measured() -> None:
    wanted = s.Objective(metric="upright_time", direction="maximize")
    trials = [standing(seed=0), fallen(seed=1, after=4.0), unwalked(standing(seed=2))]
    assert [counted(wanted, trial) for trial in trials] == [10.0, 4.0, 0.0]
    assert evaluate(study(wanted), trials[:2]).feasible
    assert not evaluate(study(wanted), trials).feasible


def test_a_metric_that_is_not_defined_is_lost_on_standing_feet_too() -> None:
    wanted = s.Objective(metric="cost_of_transport", direction="minimize")
    found = evaluate(study(wanted), [standing(cost_of_transport=nan), standing(seed=1)])
    assert isinf(found.objectives[0])
    assert not found.feasible


def test_a_value_that_is_not_defined_is_told_apart_from_a_miss_and_from_a_fall() -> None:
    inside = s.Constraint(metric="zmp_margin_p5", bound=0.1, at_least=True)
    asked = study(s.Objective(metric="energy", direction="minimize"), constraints=(inside,))

    def told(fell: bool, **metrics: float) -> str:
        known = {"fell": fell, "walked_time": 1.0, **metrics}
        found = evaluate(asked, [TrialOutcome(surface="a", seed=0, state="DONE", metrics=known)])
        return "; ".join(misses(asked, found.objectives, found.violations))

    assert told(False, energy=1.0, zmp_margin_p5=0.2) == ""
    assert told(False, energy=1.0, zmp_margin_p5=0.0) == "zmp_margin_p5 >= 0.1 (1)"
    assert told(False, energy=1.0, zmp_margin_p5=-9.0) == "zmp_margin_p5 >= 0.1 (at least 10)"
    assert told(False, energy=1.0) == "zmp_margin_p5, which has no value in these walks"
    assert told(False, zmp_margin_p5=0.2) == "energy, which has no value in these walks"
    assert "walking to the end (0.5)" in told(True, energy=1.0, zmp_margin_p5=0.2)
    assert "has no value" not in told(True, energy=1.0, zmp_margin_p5=0.2)


def test_a_violation_is_counted_in_sizes_of_its_bound() -> None:
    speed = s.Constraint(metric="walking_speed", bound=0.2, at_least=True)
    servos = s.Constraint(metric="saturation_share", bound=0.05, at_least=False)
    wanted = s.Objective(metric="upright_time", direction="maximize")
    trials = [standing(walking_speed=0.1, saturation_share=0.04)]
    found = evaluate(study(wanted, constraints=(speed, servos)), trials)
    assert found.violations == pytest.approx((0.5, -0.2, 0.0))
    assert violation_names(study(wanted, constraints=(speed, servos)))[:2] == (
        "walking_speed >= 0.2",
        "saturation_share <= 0.05",
    )


def test_seeds_become_one_number_before_surfaces_do() -> None:
    worst = s.Aggregate(kind="worst")
    wanted = s.Objective(metric="upright_time", direction="maximize", over_surfaces=worst)
    trials = [fallen("floor", 0, 2.0), fallen("floor", 1, 4.0), fallen("grass", 0, 1.0)]
    assert score(wanted, trials) == 1.0
    assert score(replace(wanted, over_surfaces=s.Aggregate()), trials) == 2.0


def test_a_candidate_without_trials_is_a_mistake_of_the_caller() -> None:
    with pytest.raises(ValueError, match="without trials"):
        evaluate(study(s.Objective(metric="stable", direction="maximize")), [])


def test_every_rule_on_falls_is_about_a_metric_that_exists() -> None:
    named = {name for name, _ in (*MEASURED, *NOWHERE, *BACKWARDS)}
    for name in (*named, *MISLEADING, *(instead for _, instead in MISLEADING.values())):
        assert lookup(name).name == name
