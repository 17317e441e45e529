"""The final of a search: its best walk on, as ordinary experiments, before a winner is named."""

from __future__ import annotations

from dataclasses import replace

from gaitlab.experiment import Experiment
from gaitlab.search import History
from gaitlab.search.finals import final_experiment, finalists, with_final
from gaitlab.search.tally import Searched
from gaitlab.search.validation_around import Run
from gaitlab.search.validation_experiments import missing
from gaitlab.store import Store


def due(history: History, store: Store) -> list[Experiment]:
    """What the final of a search still has to walk."""
    index = store.index()
    wanted = [final_experiment(history.experiment, one) for one in finalists(history)]
    return [one for one in wanted if missing(one, index)]


def decided(found: Searched, store: Store, run: Run) -> tuple[Searched, bool]:
    """The search after its final, and whether all of that was walked.

    Args:
        found: The search.
        store: Where its trials are; not held by this process.
        run: Carries out an experiment; says whether it came to its end.
    """
    going = all(run(one) for one in due(found.tally.history, store))
    history = with_final(found.tally.history, store)
    return replace(found, tally=replace(found.tally, history=history)), going
