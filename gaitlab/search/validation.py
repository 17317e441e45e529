"""After the search: is the winner real, does it walk elsewhere, and how far may it drift?"""

from __future__ import annotations

from dataclasses import dataclass

from gaitlab.experiment import Experiment
from gaitlab.experiment.plan import plan
from gaitlab.experiment.study import Numbers
from gaitlab.running import Progress, cost, dispatch
from gaitlab.running.executor import Cluster
from gaitlab.search.candidates import Candidate, History
from gaitlab.search.fresh import (
    DEFAULT,
    SEARCHED,
    WINNER,
    Rerun,
    Run,
    default_experiment,
    margin_seeds,
    rerun,
    searched_experiment,
    winner_experiment,
)
from gaitlab.search.margins import MOST_STEPS, Around, Margins
from gaitlab.search.objectives import missing
from gaitlab.store import Store


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
class ValidationCost:
    """What a validation takes at most.

    Attributes:
        chosen: Candidate that is walked again.
        walks: Trials.
        seconds: Wall time, in [s].
    """

    chosen: Candidate
    walks: int
    seconds: float


def effort(
    history: History, store: Store, jobs: int, *, around: bool = True
) -> ValidationCost | None:
    """What is missing at most, if no robot falls; None if nothing is, or there is no winner."""
    walked = validate(history, store, walk_nothing, around=around)
    if walked is None or not walked.stopped:
        return None
    index, experiment = store.index(), history.experiment
    winner = winner_experiment(history, walked.chosen)
    walks = len(missing(winner, index)) + len(missing(default_experiment(experiment), index))
    if around:
        numbers = sum(isinstance(item, Numbers) for item in history.study.search)
        seeds, grounds = len(margin_seeds(experiment)), len(experiment.parts.surfaces)
        walks += 2 * MOST_STEPS * numbers * seeds * grounds
    seconds = cost(plan(winner), walks, jobs).seconds
    return ValidationCost(chosen=walked.chosen, walks=walks, seconds=seconds)


def walk_nothing(experiment: Experiment) -> bool:
    """Run nothing: what the store lacks stays missing."""
    del experiment
    return False


def running(
    store: Store,
    jobs: int,
    progress: Progress | None = None,
    *,
    cluster: Cluster | None = None,
    others: bool = False,
) -> Run:
    """What carries out the experiments of a validation with some worker processes.

    Args:
        store: Where trials go.
        jobs: Worker processes; 0 runs every trial in this process.
        progress: Is called as trials run.
        cluster: Has the workers, instead of `jobs`.
        others: Whether other processes share the search, and so its validation.
    """

    def run(experiment: Experiment) -> bool:
        summary = dispatch(
            experiment, store, jobs=jobs, others=others, progress=progress, cluster=cluster
        )
        return not summary.interrupted

    return run


def validate(history: History, store: Store, run: Run, *, around: bool = True) -> Validation | None:
    """Walk the winner again; None if there is no winner.

    Args:
        history: The search.
        store: Where the trials are.
        run: Carries out an experiment. One that does nothing makes this a reading of the store.
        around: Whether to walk around the winner's values too.
    """
    chosen = history.representative
    if chosen is None:
        return None
    experiments = {
        WINNER: winner_experiment(history, chosen),
        DEFAULT: default_experiment(history.experiment),
    }
    if (searched := searched_experiment(history, chosen)) is not None:
        experiments[SEARCHED] = searched
    going = all(run(wanted) for wanted in experiments.values() if missing(wanted, store.index()))
    index = store.index()
    reruns = tuple(rerun(label, wanted, index) for label, wanted in experiments.items())
    if not (going and around):
        return Validation(chosen=chosen, reruns=reruns, margins=None, stopped=not going)
    margins, stopped = Around(history, chosen, store, run).margins()
    return Validation(chosen=chosen, reruns=reruns, margins=margins, stopped=stopped)
