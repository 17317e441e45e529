"""A final among the best of a search: the luckiest of many candidates is not always the best.

The three best walk with as many seeds again, and all seeds together decide. Where a study names
an engine to confirm in, that is where they walk, the search's own seeds too. Nothing of it is kept
apart: the trials are ordinary ones, and a final has been held when the store has them all.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from gaitlab.experiment import Experiment, candidate, study_of
from gaitlab.experiment.plan import PlannedTrial, plan
from gaitlab.search.candidates import Candidate, History, ranked
from gaitlab.search.objectives import evaluate, missing, stored_outcome
from gaitlab.store import Index, Store

FINALISTS = 3


def finalists(history: History) -> tuple[Candidate, ...]:
    """The best of the finished candidates, the best first; none when there is nothing to decide.

    A search for several objectives has no final: its front is the answer.
    """
    if len(history.study.objectives) > 1:
        return ()
    best = ranked(history.study, history.candidates)
    return tuple(best[:FINALISTS]) if len(best) > 1 else ()


def final_seeds(experiment: Experiment) -> tuple[int, ...]:
    """Seeds of the search and as many again, those that follow its largest."""
    first = max(experiment.seeds) + 1
    return (*experiment.seeds, *range(first, first + len(experiment.seeds)))


def confirming(experiment: Experiment) -> Experiment:
    """A study in the engine that confirms it; itself where it names none."""
    name = study_of(experiment).confirm
    if name is None:
        return experiment
    parts = experiment.parts
    return replace(experiment, parts=replace(parts, engine=replace(parts.engine, name=name)))


def final_experiment(experiment: Experiment, finalist: Candidate) -> Experiment:
    """A finalist with all seeds of the final, on the grounds of the study."""
    name = f"{experiment.name}-final-{finalist.number}"
    every = replace(confirming(experiment), name=name, seeds=final_seeds(experiment))
    return candidate(every, finalist.values)


def due_finals(history: History, store: Store) -> list[Experiment]:
    """What the final of a search still has to walk."""
    index = store.index()
    wanted = [final_experiment(history.experiment, finalist) for finalist in finalists(history)]
    return [experiment for experiment in wanted if missing(experiment, index)]


def with_final(history: History, store: Store) -> History:
    """The search with the outcome of its final, as far as the store has all of it."""
    chosen = finalists(history)
    if not chosen or due_finals(history, store):
        return history
    index = store.index()
    plans = [plan(final_experiment(history.experiment, finalist)) for finalist in chosen]
    judged = [
        _judged(history, finalist, list(planned.trials()), index)
        for finalist, planned in zip(chosen, plans, strict=True)
    ]
    return replace(history, finals=tuple(judged))


def _judged(
    history: History, finalist: Candidate, trials: list[PlannedTrial], index: Index
) -> Candidate:
    found = evaluate(history.study, (stored_outcome(item, index) for item in trials))
    return replace(
        finalist,
        objectives=found.objectives,
        violations=found.violations,
        feasible=found.feasible,
        seeds=len(final_seeds(history.experiment)),
        trial_ids=tuple(item.trial.id for item in trials),
    )


def hold_final(
    history: History, store: Store, run: Callable[[Experiment], bool]
) -> tuple[History, bool]:
    """The search after its final, and whether all of that was walked.

    Args:
        history: The search.
        store: Where its trials are; not held by this process.
        run: Carries out an experiment; says whether it came to its end.
    """
    completed = all(run(experiment) for experiment in due_finals(history, store))
    return with_final(history, store), completed
