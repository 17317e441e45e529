"""A search as it was recorded, read without changing anything."""

from __future__ import annotations

from gaitlab.errors import UnknownName
from gaitlab.experiment import Experiment
from gaitlab.search.candidates import Candidate, History, State
from gaitlab.search.finals import with_final
from gaitlab.shell import command
from gaitlab.store import Store

__all__ = ["Candidate", "History", "State", "history"]


def history(experiment: Experiment, store: Store, storage: str | None = None) -> History:
    """The candidates of a finished or half-finished search, and its final if it was held.

    Args:
        experiment: What is searched.
        store: Where its trials are, and by default its database.
        storage: Address of another database.

    Raises:
        UnknownName: If the search was never begun.
        StoreError: If the database cannot be read, or belongs to another study.
    """
    from gaitlab.search.addresses import shown
    from gaitlab.search.database import Database  # loads Optuna, which takes a second

    more = ["--storage", shown(storage)] if storage else []
    with Database.existing(experiment, store, storage) as database:
        if database is None:
            raise UnknownName(
                f"{experiment.name}: nothing was searched yet on {store.path}; "
                f"`{command('optimize', [experiment], store.path, *more)}` does"
            )
        return with_final(History(experiment=experiment, candidates=database.told()), store)
