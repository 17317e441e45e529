"""After the search: the winner walked again, with walks that fall where we say."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

import pytest
from hypothesis import given
from hypothesis import strategies as st

import gaitlab.running.processes
from gaitlab.experiment import Experiment, Value, candidate
from gaitlab.experiment.plan import plan
from gaitlab.experiment.study import Choices, Numbers
from gaitlab.search import Candidate, History
from gaitlab.search.fresh import (
    DEFAULT,
    FIRST_FRESH,
    WINNER,
    Run,
    default_experiment,
    fresh_seeds,
    random_sibling,
    winner_experiment,
)
from gaitlab.search.margins import (
    HALVINGS,
    MOST_STEPS,
    Margin,
    Verdict,
    ladder,
    next_step,
    reach,
)
from gaitlab.search.validation import Validation, effort, running, validate
from gaitlab.store import Store, TrialRecord
from tests.search import searches

HEIGHT = Numbers(path="gait.step_height", low=0.01, high=0.06)
SWAY = Numbers(path="gait.lateral_sway", low=0.01, high=0.05)
HEEL = Choices(path="gait.heel_strike", options=("none", "add"))
SIDES: list[Literal[-1, 1]] = [-1, 1]
LOWEST, HIGHEST = 0.02, 0.0405  # m, step heights between which the pretended robot stays up
TOO_HIGH = 0.055  # m, out of reach


def limit_of(
    item: Numbers, value: float, sign: Literal[-1, 1], limit: float
) -> tuple[list[float], dict[float, Verdict], tuple[float, ...]]:
    """Every step that is walked when the robot falls beyond a limit."""
    rungs = ladder(item, value, sign, 0.0, None)
    walked: dict[float, Verdict] = {}
    steps = []
    while (step := next_step(item, value, rungs, walked)) is not None:
        steps.append(step)
        walked[step] = "holds" if (limit - step) * sign >= 0 else "fell"
        assert len(steps) <= MOST_STEPS
    return steps, walked, rungs


@given(
    value=st.floats(0.011, 0.059),
    distance=st.floats(0.0, 0.05),
    sign=st.sampled_from(SIDES),
    log=st.booleans(),
)
def test_a_limit_lies_between_what_holds_and_what_fails(
    value: float, distance: float, sign: Literal[-1, 1], log: bool
) -> None:
    item = replace(HEIGHT, log=log)
    limit = value + sign * distance
    steps, walked, rungs = limit_of(item, value, sign, limit)
    found = reach(item, value, rungs, walked)
    assert (limit - found.holds) * sign >= 0
    if found.fails is not None:
        assert (found.fails - limit) * sign > 0
        widest = max(abs(b - a) for a, b in zip((value, *rungs), rungs, strict=False))
        assert log or abs(found.fails - found.holds) <= widest / 2**HALVINGS + 1e-7
    else:
        assert all(walked[step] == "holds" for step in steps)


def test_a_limit_that_was_not_looked_for_yet_is_no_limit() -> None:
    rungs = ladder(HEIGHT, 0.03, 1, None, None)
    assert reach(HEIGHT, 0.03, rungs, {}).ending == "not walked yet"
    assert reach(HEIGHT, 0.03, rungs, dict.fromkeys(rungs, "holds")).ending == "no fall found"
    assert reach(HEIGHT, 0.03, (), {}).ending == "limit of the parameter"


@given(st.floats(0.01, 0.06), st.sampled_from(SIDES))
def test_steps_stay_within_what_the_parameter_allows(value: float, sign: Literal[-1, 1]) -> None:
    rungs = ladder(HEIGHT, value, sign, 0.005, 0.062)
    assert all(0.005 <= rung <= 0.062 for rung in rungs)
    assert list(rungs) == sorted(set(rungs), reverse=sign < 0)
    assert all((rung - value) * sign > 0 for rung in rungs)


@given(st.integers(2, 10), st.sampled_from(SIDES), st.floats(0.0, 12.0))
def test_whole_numbers_move_in_whole_steps(value: int, sign: Literal[-1, 1], limit: float) -> None:
    item = Numbers(path="gait.deceleration_areas", low=2, high=10, integer=True)
    steps, walked, rungs = limit_of(item, value, sign, value + sign * limit)
    assert all(step == int(step) for step in steps)
    found = reach(item, value, rungs, walked)
    if found.fails is not None and abs(found.fails - found.holds) > 1:
        assert len(steps) >= HALVINGS


def fall_outside(trial_id: str, trial: Mapping[str, Any], store: Path) -> TrialRecord:
    """Commit a trial that falls at step heights we say, on thick grass and with heel strike."""
    values, ground = trial["gait"]["values"], trial["names"]["surface"]
    state = "INFEASIBLE" if values["step_height"] > TOO_HIGH else "DONE"
    up = LOWEST <= values["step_height"] <= HIGHEST and ground != "grass_50mm"
    up = up and values["heel_strike"] == "none"
    speed = values["step_height"] + 0.001 * (trial["seed"] % 7)
    metrics = {"stable": up, "fell": not up, "walking_speed": speed, "walked_time": 2.0}
    record = TrialRecord(
        trial_id=trial_id,
        state="INFEASIBLE" if state == "INFEASIBLE" else "DONE",
        reason="",
        trial=trial,
        metrics={} if state == "INFEASIBLE" else metrics,
        provenance={"gaitlab_version": "0.1.0"},
    )
    Store(store).commit(record, None)
    return record


@pytest.fixture(autouse=True, scope="module")
def pretended() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(gaitlab.running.processes, "simulated", fall_outside)
        yield


def history_of(values: Mapping[str, Value] | None = None) -> History:
    """A finished search with one candidate."""
    experiment = searches.study("surfaces=[carpet_4mm]")
    assert experiment.study is not None
    search = (HEIGHT, SWAY, HEEL)
    study = replace(experiment.study, search=search)
    experiment = replace(experiment, study=study)
    winner: dict[str, Value] = {
        "gait.step_height": 0.03,
        "gait.lateral_sway": 0.03,
        "gait.heel_strike": "none",
    }
    found = Candidate(
        number=3,
        values=values or winner,
        state="done",
        objectives=(0.2,) * len(study.objectives),
        violations=(0.0,),
        feasible=True,
        seeds=4,
        trial_ids=(),
        batch=0,
        simulated=8.0,
    )
    return History(experiment=experiment, candidates=(found,))


def check(folder: Path, history: History | None = None) -> Validation:
    store = Store(folder)
    found = validate(history or history_of(), store, running(store, jobs=0))
    assert found is not None
    return found


@pytest.fixture(scope="module")
def checked(tmp_path_factory: pytest.TempPathFactory) -> tuple[Validation, Path]:
    """The toy's winner checked, and the folder of the store."""
    folder = tmp_path_factory.mktemp("checked")
    return check(folder), folder


def nothing(experiment: Experiment) -> bool:
    raise AssertionError(f"{experiment.name} is walked though the store has it")


def margin(found: Validation, path: str) -> Margin:
    assert found.margins is not None
    return next(item for item in found.margins.numbers if item.path == path)


TOY = history_of()


@given(st.lists(st.integers(0, 2 * FIRST_FRESH), min_size=1, max_size=5, unique=True))
def test_fresh_seeds_are_none_of_the_search(seeds: list[int]) -> None:
    experiment = replace(TOY.experiment, seeds=seeds)
    fresh = fresh_seeds(experiment)
    assert not set(seeds) & set(fresh)
    assert min(fresh) >= FIRST_FRESH
    assert len(fresh) >= len(seeds)


def test_the_winner_walks_again_under_the_ids_that_a_candidate_has() -> None:
    history = history_of()
    again = winner_experiment(history, history.candidates[0])
    cell = candidate(history.experiment, history.candidates[0].values)
    cell = replace(cell, parts=again.parts, seeds=again.seeds)
    assert [item.trial.id for item in plan(again).trials()] == [
        item.trial.id for item in plan(cell).trials()
    ]


def test_winner_and_default_walk_every_ground_with_the_same_fresh_seeds(
    checked: tuple[Validation, Path],
) -> None:
    found, _ = checked
    winner, default = found.reruns
    assert (winner.label, default.label) == (WINNER, DEFAULT)
    places = [{(walk.surface, walk.seed) for walk in rerun.walks} for rerun in found.reruns]
    assert places[0] == places[1]
    assert {ground for ground, _ in places[0]} > {"carpet_4mm", "grass_50mm", "hard_floor"}
    up = {
        ground: all(w.stable for w in winner.on([ground]))
        for ground in ("carpet_4mm", "grass_50mm")
    }
    assert up == {"carpet_4mm": True, "grass_50mm": False}


def test_margins_close_in_on_where_the_robot_falls(checked: tuple[Validation, Path]) -> None:
    found, _ = checked
    height = margin(found, "gait.step_height")
    assert height.below.fails is not None
    assert height.above.fails is not None
    assert height.below.fails < LOWEST <= height.below.holds
    assert height.above.holds <= HIGHEST < height.above.fails
    assert height.above.ending == "fell"
    sway = margin(found, "gait.lateral_sway")
    assert sway.above.fails is None
    assert found.margins is not None
    (heel,) = found.margins.switches
    assert heel.holds == {"add": False}


def test_a_checked_winner_is_checked_again_for_nothing(checked: tuple[Validation, Path]) -> None:
    once, folder = checked
    store = Store(folder)
    assert validate(history_of(), store, nothing) == once
    assert effort(history_of(), store, 1, around=False) is None


def stopping(store: Store, after: int) -> Iterator[Run]:
    """Runs that are stopped after ever more experiments."""
    for allowed in range(after):
        run = running(store, jobs=0)
        begun: list[str] = []

        def limited(
            experiment: Experiment, run: Run = run, begun: list[str] = begun, n: int = allowed
        ) -> bool:
            begun.append(experiment.name)
            return len(begun) <= n and run(experiment)

        yield limited


def test_a_check_that_was_stopped_anywhere_ends_as_an_undisturbed_one(
    checked: tuple[Validation, Path], folder: Path
) -> None:
    store = Store(folder)
    states = [validate(history_of(), store, run) for run in stopping(store, 3)]
    assert all(state is not None and state.stopped for state in states[:2])
    assert check(folder) == checked[0]


def test_what_was_not_walked_is_said_to_be_missing(folder: Path) -> None:
    store = Store(folder)
    found = validate(history_of(), store, lambda experiment: False)
    assert found is not None
    assert found.stopped
    assert {walk.state for rerun in found.reruns for walk in rerun.walks} == {"MISSING"}


def test_a_winner_that_always_falls_has_no_margins(folder: Path) -> None:
    values: dict[str, Value] = {
        "gait.step_height": 0.05,
        "gait.lateral_sway": 0.03,
        "gait.heel_strike": "none",
    }
    found = check(folder, history_of(values))
    assert found.margins is not None
    assert found.margins.seeds == 0
    assert found.margins.numbers == ()


def test_without_a_winner_nothing_is_walked(folder: Path) -> None:
    history = history_of()
    spoilt = replace(history.candidates[0], feasible=False)
    empty = History(experiment=history.experiment, candidates=(spoilt,))
    assert empty.representative is None
    assert validate(empty, Store(folder), nothing) is None


def test_the_random_sibling_differs_in_the_sampler_alone() -> None:
    experiment = history_of().experiment
    sibling = random_sibling(experiment)
    assert experiment.study is not None
    assert sibling.study == replace(experiment.study, sampler="random", sampler_options={})
    assert sibling.name == f"{experiment.name}-random"
    assert fresh_seeds(sibling) == fresh_seeds(experiment)
    ids = [item.trial.id for item in plan(default_experiment(experiment)).trials()]
    assert ids == [item.trial.id for item in plan(default_experiment(sibling)).trials()]
