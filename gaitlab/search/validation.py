"""After the search: is the winner real, does it walk elsewhere, and how far may it drift?

Everything here is ordinary experiments, so what is in the store is never walked again, and a check
goes on where it was stopped.
"""

from __future__ import annotations

from dataclasses import dataclass

from gaitlab.dispatch import Progress, dispatch
from gaitlab.dispatch.outlook import WALL_RATIO
from gaitlab.experiment import Experiment
from gaitlab.experiment.study import Numbers
from gaitlab.plan import plan
from gaitlab.search import Candidate, History
from gaitlab.search.results import DEFAULT, WINNER, Margins, Rerun
from gaitlab.search.validation_around import Around, Run
from gaitlab.search.validation_experiments import (
    FIRST_FRESH,
    default_experiment,
    fresh_seeds,
    margin_seeds,
    missing,
    random_sibling,
    rerun,
    winner_experiment,
)
from gaitlab.search.validation_margins import MOST_STEPS
from gaitlab.store import Store

__all__ = [
    "FIRST_FRESH",
    "Effort",
    "Run",
    "Validation",
    "chosen_of",
    "default_experiment",
    "effort",
    "fresh_seeds",
    "random_sibling",
    "rerun",
    "running",
    "validate",
    "winner_experiment",
]


@dataclass(frozen=True, kw_only=True)
class Validation:
    """What was walked after a search.

    Attributes:
        chosen: Candidate that was walked again.
        reruns: The winner and the default on fresh seeds.
        margins: Around the winner; None if that was not begun.
        stopped: Whether a Ctrl-C ended it before everything was walked.
    """

    chosen: Candidate
    reruns: tuple[Rerun, ...]
    margins: Margins | None
    stopped: bool = False


@dataclass(frozen=True, kw_only=True)
class Effort:
    """What a validation takes at most.

    Attributes:
        walks: Trials.
        seconds: Wall time, in [s].
    """

    walks: int
    seconds: float


def chosen_of(history: History) -> Candidate | None:
    """The candidate to walk again: the best, or the middle one of a Pareto front."""
    if history.best is not None or not history.front:
        return history.best
    return history.front[len(history.front) // 2]


def effort(
    history: History, chosen: Candidate, store: Store, jobs: int, *, around: bool = True
) -> Effort:
    """What is missing at most, if no robot falls."""
    index = store.index()
    found = [winner_experiment(history, chosen), default_experiment(history.experiment)]
    walks = sum(len(missing(one, index)) for one in found)
    numbers = [item for item in history.study.search if isinstance(item, Numbers)]
    margins = 2 * MOST_STEPS * len(numbers) * len(margin_seeds(history.experiment))
    walks += margins * len(history.experiment.parts.surfaces) if around else 0
    seconds = walks * plan(found[0]).seconds * WALL_RATIO / max(1, jobs)
    return Effort(walks=walks, seconds=seconds)


def running(store: Store, jobs: int, progress: Progress | None = None) -> Run:
    """What carries out the experiments of a validation with some worker processes."""

    def run(experiment: Experiment) -> bool:
        return not dispatch(experiment, store, jobs=jobs, progress=progress).interrupted

    return run


def validate(history: History, store: Store, run: Run, *, around: bool = True) -> Validation | None:
    """Walk the winner again; None if there is no winner.

    Args:
        history: The search.
        store: Where the trials are.
        run: Carries out an experiment. One that does nothing makes this a reading of the store.
        around: Whether to walk around the winner's values too.
    """
    chosen = chosen_of(history)
    if chosen is None:
        return None
    wanted = {
        WINNER: winner_experiment(history, chosen),
        DEFAULT: default_experiment(history.experiment),
    }
    going = all(run(one) for one in wanted.values() if missing(one, store.index()))
    index = store.index()
    reruns = tuple(rerun(label, one, index) for label, one in wanted.items())
    if not (going and around):
        return Validation(chosen=chosen, reruns=reruns, margins=None, stopped=not going)
    found, stopped = Around(history, chosen, store, run).margins()
    return Validation(chosen=chosen, reruns=reruns, margins=found, stopped=stopped)
