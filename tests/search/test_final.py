"""The final of a search: all seeds together decide, and it is held once."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

import gaitlab.running.processes
from gaitlab.experiment import Experiment
from gaitlab.experiment.plan import plan
from gaitlab.search import History
from gaitlab.search.database import history
from gaitlab.search.final import (
    FINALISTS,
    due_finals,
    final_experiment,
    final_seeds,
    finalists,
    hold_final,
    with_final,
)
from gaitlab.search.fresh import fresh_seeds
from gaitlab.search.objectives import TrialOutcome, evaluate
from gaitlab.search.search import SearchResult
from gaitlab.search.validation import running
from gaitlab.store import Store
from tests.search import searches

SETTINGS = ("study.trials=16", "surfaces=[carpet_4mm]")


@pytest.fixture(autouse=True)
def pretended(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(gaitlab.running.processes, "simulated", searches.pretend)


@pytest.fixture(scope="module")
def searched() -> Iterator[tuple[SearchResult, Path]]:
    """A search and the folder of its store, for copies."""
    with searches.folder() as place:
        yield searches.search(Store(place), *SETTINGS), place


@pytest.fixture
def found(searched: tuple[SearchResult, Path], folder: Path) -> SearchResult:
    shutil.copytree(searched[1], folder, dirs_exist_ok=True)
    return searched[0]


def nothing(experiment: Experiment) -> bool:
    raise AssertionError(f"{experiment.name} is walked though the store has it")


def held(found: SearchResult, folder: Path) -> History:
    store = Store(folder)
    after, going = hold_final(found.history, store, running(store, jobs=0))
    assert going
    return after


def test_the_seeds_of_a_final_are_those_of_the_search_and_as_many_that_nobody_else_uses() -> None:
    experiment = searches.study(*SETTINGS)
    seeds = final_seeds(experiment)
    assert set(experiment.seeds) < set(seeds)
    assert len(set(seeds)) == 2 * len(experiment.seeds)
    assert not set(seeds) & set(fresh_seeds(experiment))


def test_the_finalists_are_the_best_that_walked_with_every_seed(found: SearchResult) -> None:
    past = found.history
    chosen = finalists(past)
    assert 1 < len(chosen) <= FINALISTS
    worst = min(one.objectives[0] for one in chosen)
    others = [one for one in past.candidates if one not in chosen]
    standing = [one for one in others if one.state == "done" and one.feasible]
    assert all(one.objectives[0] <= worst for one in standing)


def test_until_it_was_held_the_search_names_the_best(found: SearchResult, folder: Path) -> None:
    past = found.history
    assert with_final(past, Store(folder)).finals == ()
    assert past.best == finalists(past)[0]


def test_the_winner_of_the_final_is_the_best_over_all_its_seeds(
    found: SearchResult, folder: Path
) -> None:
    after, store = held(found, folder), Store(folder)
    scores = {}
    for one in finalists(found.history):
        walks = list(plan(final_experiment(after.experiment, one)).trials())
        records = [store.record(item.trial.id) for item in walks]
        outcomes = [
            TrialOutcome(
                surface="carpet_4mm",
                seed=item.trial.seed,
                state=record.state,
                metrics=record.metrics,
            )
            for item, record in zip(walks, records, strict=True)
        ]
        judged = evaluate(after.study, outcomes)
        if judged.feasible:
            scores[one.number] = judged.objectives[0]
    assert after.best is not None
    assert after.best.number == max(scores, key=lambda number: scores[number])
    assert after.best.objectives[0] == scores[after.best.number]
    assert after.best.seeds == 2 * len(after.experiment.seeds)


def test_a_final_is_held_once_and_read_back_from_the_store(
    found: SearchResult, folder: Path
) -> None:
    after, store = held(found, folder), Store(folder)
    assert due_finals(after, store) == []
    assert hold_final(found.history, store, nothing)[0] == after
    assert history(searches.study(*SETTINGS), store) == after


def test_a_stopped_final_decides_nothing(found: SearchResult, folder: Path) -> None:
    after, going = hold_final(found.history, Store(folder), lambda experiment: False)
    assert not going
    assert after == found.history


def test_several_objectives_have_a_front_and_no_final(folder: Path) -> None:
    both = "study.objectives=[{maximize: walking_speed}, {maximize: stable}]"
    found = searches.search(Store(folder), *SETTINGS, "study.sampler=random", both)
    assert found.history.front
    assert finalists(found.history) == ()
