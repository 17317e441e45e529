"""A final among the best of a search: the luckiest of many candidates is not always the best.

The three best walk with as many seeds again, and all seeds together decide. Nothing of it is kept
apart: the trials are ordinary ones, and a final has been held when the store has them all.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from gaitlab.experiment import Experiment, candidate
from gaitlab.plan import PlannedTrial, plan
from gaitlab.search.candidates import Candidate, History, costs
from gaitlab.search.objectives import Outcome, evaluate
from gaitlab.store import Index, Store

FINALISTS = 3


def finalists(history: History) -> tuple[Candidate, ...]:
    """The best of the finished candidates, the best first; none when there is nothing to decide.

    A search for several objectives has no final: its front is the answer.
    """
    if len(history.study.objectives) > 1:
        return ()
    finished = [c for c in history.candidates if c.state == "done" and c.feasible]
    ranked = sorted(finished, key=lambda c: (costs(history.study, c), c.number))
    return tuple(ranked[:FINALISTS]) if len(ranked) > 1 else ()


def final_seeds(experiment: Experiment) -> tuple[int, ...]:
    """Seeds of the search and as many again, those that follow its largest."""
    first = max(experiment.seeds) + 1
    return (*experiment.seeds, *range(first, first + len(experiment.seeds)))


def final_experiment(experiment: Experiment, finalist: Candidate) -> Experiment:
    """A finalist with all seeds of the final, on the grounds of the study."""
    name = f"{experiment.name}-final-{finalist.number}"
    every = replace(experiment, name=name, seeds=final_seeds(experiment))
    return candidate(every, finalist.values)


def with_final(history: History, store: Store) -> History:
    """The search with the outcome of its final, as far as the store has all of it."""
    chosen = finalists(history)
    if not chosen:
        return history
    index = store.index()
    walks = [list(plan(final_experiment(history.experiment, one)).trials()) for one in chosen]
    if any(item.trial.id not in index.entries for each in walks for item in each):
        return history
    return History(
        experiment=history.experiment,
        candidates=history.candidates,
        finals=tuple(_judged(history, *pair, index) for pair in zip(chosen, walks, strict=True)),
    )


def _judged(
    history: History, finalist: Candidate, walks: list[PlannedTrial], index: Index
) -> Candidate:
    found = evaluate(history.study, _outcomes(walks, index))
    return replace(
        finalist,
        objectives=found.objectives,
        violations=found.violations,
        feasible=found.feasible,
        seeds=len(final_seeds(history.experiment)),
        trial_ids=tuple(item.trial.id for item in walks),
    )


def _outcomes(walks: list[PlannedTrial], index: Index) -> Iterator[Outcome]:
    for item in walks:
        entry = index.entries[item.trial.id]
        yield Outcome(
            surface=str(item.values["surface"]),
            seed=item.trial.seed,
            state=entry.state,
            metrics=entry.details.metrics,
        )
