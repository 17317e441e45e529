"""A search is the same however it is carried out: the law behind resuming, sharing and repeating.

Trials are pretended, see `searches`.
"""

from __future__ import annotations

import os
import random
import signal
import time
from collections.abc import Iterator
from multiprocessing import get_context
from pathlib import Path

import optuna
import pytest

from gaitlab.errors import StoreError, UsageError
from gaitlab.running.worker import simulated
from gaitlab.search.search import SearchCallback, SearchStatus
from gaitlab.search.storage import database_file
from gaitlab.store import Store, fingerprint
from tests.reliability.drivers import until
from tests.reliability.sweeps import committed
from tests.search import searches
from tests.search.searches import search, told

TOTAL = 18
KILLS = 10


@pytest.fixture
def store(folder: Path) -> Store:
    return Store(folder / "data")


@pytest.fixture(scope="module")
def whole() -> Iterator[Store]:
    """A search that nobody has disturbed."""
    with searches.folder() as place:
        store = Store(place / "data")
        search(store)
        yield store


def states(store: Store) -> list[optuna.trial.TrialState]:
    storage = f"sqlite:///{database_file(store, 'pretended_study')}"
    study = optuna.load_study(study_name="pretended_study", storage=storage)
    found = [trial.state for trial in study.get_trials(deepcopy=False)]
    study._storage._backend.engine.dispose()  # type: ignore[attr-defined]
    return found


def assert_finished(store: Store, total: int = TOTAL) -> None:
    """Exactly the asked number of told candidates, no leftovers, none twice."""
    found = told(store)
    assert len(found) == total
    assert len({tuple(sorted(c.values.items())) for c in found}) == total
    finished = {optuna.trial.TrialState.COMPLETE, optuna.trial.TrialState.PRUNED}
    assert len(states(store)) == total
    assert set(states(store)) <= finished


def test_a_search_tells_every_candidate_once(whole: Store) -> None:
    assert_finished(whole)
    found = told(whole)
    assert {candidate.state for candidate in found} == {"done", "pruned", "infeasible"}
    assert found[0].values == {
        "gait.step_height": 0.03,
        "gait.lateral_sway": 0.015,
        "gait.heel_strike": "none",
    }, "the hand-set values come first"


def test_a_finished_search_does_nothing_more(whole: Store) -> None:
    before = told(whole)
    again = search(whole)
    assert (again.ending, again.status.walked) == ("complete", 0)
    assert told(whole) == before


@pytest.mark.long
def test_two_workers_find_what_this_process_finds(whole: Store, store: Store) -> None:
    search(store, jobs=2)
    assert told(store) == told(whole)


@pytest.mark.long
def test_a_search_whose_database_is_lost_is_rebuilt_from_its_trials(
    whole: Store, store: Store
) -> None:
    search(store)
    database_file(store, "pretended_study").unlink()
    again = search(store)
    assert again.status.walked == 0
    assert again.cached == sum(len(c.trial_ids) for c in told(store))
    assert told(store) == told(whole)


def test_more_candidates_go_on_from_the_end(store: Store) -> None:
    search(store, "study.trials=8")
    before = told(store, "study.trials=8")
    search(store, "study.trials=14")
    assert told(store)[:8] == before
    assert_finished(store, 14)


def test_trials_of_a_search_are_listed_under_its_name(whole: Store) -> None:
    table = whole.table("pretended_study")
    ids = [trial_id for candidate in told(whole) for trial_id in candidate.trial_ids]
    assert sorted(table["trial_id"]) == sorted(ids)
    heights = {c.values["gait.step_height"] for c in told(whole)}
    assert set(table["gait.step_height"]) == heights
    seeds = table.groupby(["gait.step_height", "surface"])["seed"].nunique()
    assert set(seeds) == {2, 4}


class Stopper(SearchCallback):
    """Presses Ctrl-C after some trials."""

    def __init__(self, after: int) -> None:
        self.after, self.messages = after, list[str]()

    def update(self, status: SearchStatus) -> None:
        if status.walked == self.after:
            self.after = -1
            signal.raise_signal(signal.SIGINT)

    def message(self, text: str) -> None:
        self.messages.append(text)


@pytest.mark.long
@pytest.mark.parametrize("jobs", [0, 2])
def test_a_search_that_was_stopped_goes_on_as_if_it_had_not(
    whole: Store, store: Store, jobs: int
) -> None:
    stopper = Stopper(after=13)
    first = search(store, jobs=jobs, callback=stopper)
    assert first.ending == "stopped"
    assert stopper.messages
    assert first.status.finished < TOTAL
    search(store)
    assert told(store) == told(whole)
    assert_finished(store)


def _search_in_a_process(store: Store, jobs: int) -> None:
    os.setpgid(0, 0)
    nowhere = os.open(os.devnull, os.O_RDWR)
    os.dup2(nowhere, 2)
    search(store, jobs=jobs, task=searches.pretend_slowly)
    os._exit(0)


@pytest.mark.long
def test_ten_kills_at_random_instants_leave_no_trace(whole: Store, store: Store) -> None:
    chance, share = random.Random(7), len(whole.states()) // (KILLS + 1)
    for _ in range(KILLS):
        jobs, before = chance.choice((0, 0, 1)), committed(store)
        process = get_context("fork").Process(target=_search_in_a_process, args=(store, jobs))
        process.start()
        enough = before + chance.randint(0, share)
        assert until(lambda enough=enough: committed(store) >= enough)
        time.sleep(chance.uniform(0.0, 0.05))
        assert process.pid is not None
        os.kill(process.pid, signal.SIGKILL)
        process.join(30.0)
        assert process.exitcode == -signal.SIGKILL, "it was still searching"
    search(store)
    assert told(store) == told(whole)
    assert_finished(store)
    assert list(store.path.rglob("*.tmp")) == []


def test_a_killed_proposal_of_half_a_batch_is_completed(
    whole: Store, store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    from optuna.storages import RDBStorage

    create, calls = RDBStorage._create_new_trial, 0

    def dies_at_the_seventh(self: RDBStorage, *arguments: object) -> object:
        nonlocal calls
        calls += 1
        if calls == 7:
            raise KeyboardInterrupt
        return create(self, *arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(RDBStorage, "_create_new_trial", dies_at_the_seventh)
    with pytest.raises(KeyboardInterrupt):
        search(store)
    monkeypatch.undo()
    search(store)
    assert told(store) == told(whole)
    assert_finished(store)


def test_another_space_under_the_same_name_is_refused(store: Store) -> None:
    search(store, "study.trials=4")
    with pytest.raises(StoreError, match=r"search gait.step_height: low 0.01, high 0.06 there"):
        search(store, "study.search.gait.step_height={low: 0.02, high: 0.06}")
    with pytest.raises(StoreError, match="digest of gait"):
        search(store, "gait.hip_height=0.2")
    with pytest.raises(StoreError, match=r"maximize walking_speed .* there, maximize distance"):
        search(store, "study.objectives=[{maximize: distance}]")


def test_a_database_that_is_no_database_is_named_and_left(store: Store) -> None:
    file = database_file(store, "pretended_study")
    file.parent.mkdir(parents=True)
    file.write_text("a shopping list " * 100)
    with pytest.raises(StoreError, match=r"study\.db: the database of the search cannot be used"):
        search(store)
    assert file.read_text().startswith("a shopping list")


@pytest.mark.parametrize(
    ("address", "message"),
    [
        ("postgresql://robot:secret@127.0.0.1:1/walks", "cannot be used"),
        ("nonsense", "An address looks like"),
        ("mongodb://here/walks", "An address looks like"),
        ("oracle://robot@127.0.0.1/walks", "its driver is not installed"),
    ],
)
def test_a_database_out_of_reach_is_refused_without_its_password(
    store: Store, address: str, message: str
) -> None:
    with pytest.raises(StoreError, match=message) as caught:
        search(store, storage=address)
    assert "secret" not in str(caught.value)


def test_an_experiment_is_no_study(store: Store) -> None:
    from gaitlab.experiment import load_experiment
    from gaitlab.search.search import optimize

    with pytest.raises(UsageError, match="no study"):
        optimize(load_experiment("eros_quick"), store, jobs=0)


def test_a_space_without_more_to_try_ends_the_search(store: Store) -> None:
    few = ("study.search={gait.step_height: {low: 0.02, high: 0.03, step: 0.005}}",)
    found = search(store, *few)
    assert (found.ending, found.status.finished) == ("exhausted", 3)
    assert search(store, *few).ending == "exhausted"


def test_a_search_without_improvement_ends_early(store: Store) -> None:
    found = search(store, "study.early_stop=4", "study.trials=100", "study.sampler=random")
    assert found.ending == "no improvement"
    best = found.history.best
    assert best is not None
    assert 4 <= found.status.finished - 1 - best.number < 8
    assert search(store, "study.early_stop=4", "study.trials=100", "study.sampler=random").ending


def test_a_search_in_which_all_fall_says_what_came_nearest(store: Store) -> None:
    from gaitlab.cli.search_text import nothing_allowed

    found = search(store, task=searches.fall)
    assert found.ending == "complete"
    assert found.history.best is None
    text = "\n".join(nothing_allowed(found.history))
    assert "No candidate of 18" in text
    assert "Nearest misses" in text
    assert "stable >= 0.5 (1)" in text


def test_racing_walks_less_and_finds_as_much(whole: Store, store: Store) -> None:
    found = search(store, "study.racing=off")
    raced = search(whole)
    assert {c.state for c in told(store, "study.racing=off")} <= {"done", "infeasible"}
    assert raced.history.used < 0.8 * found.history.used
    assert found.history.saving == 0.0


@pytest.mark.long
@pytest.mark.parametrize("sampler", ["random", "qmc", "nsga2", "nsga3"])
def test_every_sampler_goes_on_as_if_it_had_not_been_stopped(folder: Path, sampler: str) -> None:
    settings = (f"study.sampler={sampler}", "study.trials=12", "seeds=2", "study.racing=off")
    one, two = Store(folder / "one"), Store(folder / "two")
    search(one, *settings)
    search(two, *settings, callback=Stopper(after=17))
    search(two, *settings)
    assert told(one, *settings) == told(two, *settings)


@pytest.mark.long
def test_cmaes_goes_on_as_if_it_had_not_been_stopped(folder: Path) -> None:
    space = "gait.step_height: {low: 0.01, high: 0.06}, gait.lateral_sway: {low: 0.0, high: 0.06}"
    settings = (
        f"study.search={{{space}}}",
        "study.sampler=cmaes",
        "study.trials=24",
        "seeds=2",
        "study.racing=off",
    )
    one, two = Store(folder / "one"), Store(folder / "two")
    search(one, *settings)
    search(two, *settings, callback=Stopper(after=70))
    search(two, *settings)
    assert told(one, *settings) == told(two, *settings)
    best = search(one, *settings).history.best
    assert best is not None
    assert best.number > 8, "it learns"


REAL = (  # four candidates of the shortest walk, simulated
    "horizon={cycles: 0.5, time: 0.1}",
    "gait.stand_time=0.1",
    "surfaces=[hard_floor]",
    "seeds=2",
    "study.racing=off",
    "study.trials=4",
    "study.batch=2",
)


def _really_search(store: Store) -> None:
    search(store, *REAL, jobs=1, task=simulated)


@pytest.mark.long
def test_a_killed_search_of_real_walks_is_the_undisturbed_one(folder: Path) -> None:
    killed, whole = Store(folder / "killed"), Store(folder / "whole")
    process = get_context("fork").Process(target=_really_search, args=(killed,))
    process.start()
    end = time.monotonic() + 60.0
    while len(killed.states()) < 3 and process.is_alive() and time.monotonic() < end:
        time.sleep(0.01)
    assert process.pid is not None
    os.kill(process.pid, signal.SIGKILL)
    process.join(30.0)
    for store in (killed, whole):
        search(store, *REAL, task=simulated)
    assert told(killed, *REAL) == told(whole, *REAL)
    assert {key: fingerprint(killed.file(key)) for key in killed.states()} == {
        key: fingerprint(whole.file(key)) for key in whole.states()
    }
