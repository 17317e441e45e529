"""Small searches repeated with other seeds, and their winners judged on seeds none of them saw."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import nan
from pathlib import Path

from gaitlab.experiment import Experiment, candidate, load_experiment
from gaitlab.experiment.plan import plan
from gaitlab.running import dispatch
from gaitlab.search import History
from gaitlab.search.final import hold_final
from gaitlab.search.objectives import score, stored_outcome
from gaitlab.search.search import SearchResult, optimize
from gaitlab.search.validation import running
from gaitlab.statistics import mean_interval
from gaitlab.store import Store

FRESH = range(2_000_000, 2_000_020)  # seeds


@dataclass(frozen=True, kw_only=True)
class Result:
    """One search.

    Attributes:
        used: Simulated time of its candidates, in [s].
        searched: Objective of the winner in the search; NaN without one.
        fresh: The same on fresh seeds.
        final: Objective of the winner of the final on fresh seeds.
        rate: Simulated seconds per second of wall time; 0 if nothing was walked.
    """

    used: float
    searched: float
    fresh: float
    final: float
    rate: float


def searched(study: str, settings: Sequence[str], store: Store, jobs: int) -> Result:
    """A search, gone on with if it was begun, and its winner on fresh seeds."""
    experiment = load_experiment(study, settings)
    found: SearchResult = optimize(experiment, store, jobs=jobs)
    history = found.history
    best = history.best
    after, _ = hold_final(found.history, store, running(store, jobs))
    return Result(
        used=history.used,
        searched=nan if best is None else best.objectives[0],
        fresh=_fresh(history, store, jobs),
        final=_fresh(after, store, jobs),
        rate=found.status.rate,
    )


def _fresh(history: History, store: Store, jobs: int) -> float:
    if history.best is None:
        return nan
    name = f"{history.experiment.name}-fresh"
    again = replace(history.experiment, name=name, seeds=FRESH)
    winner: Experiment = candidate(again, history.best.values)
    dispatch(winner, store, jobs=jobs)
    index = store.index()
    outcomes = [stored_outcome(item, index) for item in plan(winner).trials()]
    return score(history.study.objectives[0], outcomes)


def difference(one: Sequence[float], other: Sequence[float]) -> str:
    """Mean of the differences of the repeats with its 95 % interval."""
    pairs = [a - b for a, b in zip(one, other, strict=True)]
    low, high = mean_interval(pairs)
    return f"{sum(pairs) / len(pairs):+.4f} [{low:+.4f}, {high:+.4f}], n = {len(pairs)}"


def opened(folder: Path) -> Store:
    """The store of a benchmark: what was walked is not walked again."""
    folder.mkdir(parents=True, exist_ok=True)
    return Store(folder)
