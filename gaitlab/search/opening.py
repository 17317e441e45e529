"""Finding or making the record of a search, and refusing one that is about something else."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import cast

import optuna
from optuna.exceptions import DuplicatedStudyError
from optuna.storages import RDBStorage
from optuna.study import StudyDirection

from gaitlab.errors import StoreError
from gaitlab.experiment import Experiment
from gaitlab.experiment.study import Study
from gaitlab.search.addresses import database_file, file_storage, server_storage, shown
from gaitlab.store import Store

ASKS_FOR = "gaitlab: what the study asks for"  # attribute of the study


@contextmanager
def storage_at(
    name: str, store: Store, address: str | None
) -> Iterator[tuple[RDBStorage, str, Path | None]]:
    """The database, where it is for messages, and its file if it is the store's own."""
    before = optuna.logging.get_verbosity()
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    file = database_file(store, name) if address is None else None
    storage = server_storage(address) if address is not None else file_storage(cast(Path, file))
    try:
        yield storage, str(file) if address is None else shown(address), file
    finally:
        storage.remove_session()
        storage.engine.dispose()
        optuna.logging.set_verbosity(before)


def study_asked(experiment: Experiment) -> Study:
    """What an experiment that is a study asks for."""
    if experiment.study is None:
        raise ValueError(f"{experiment.name} is no study")
    return experiment.study


def id_of(storage: RDBStorage, name: str) -> int | None:
    """Number of the study of this name; None if there is none."""
    try:
        return int(storage.get_study_id_from_name(name))
    except KeyError:
        return None


def made(storage: RDBStorage, name: str, study: Study) -> int:
    """The study of this name, made if there is none; another coordinator may be making it too."""
    found = id_of(storage, name)
    if found is not None:
        return found
    ways = {"maximize": StudyDirection.MAXIMIZE, "minimize": StudyDirection.MINIMIZE}
    directions = [ways[objective.direction] for objective in study.objectives]
    with suppress(DuplicatedStudyError):
        made = int(storage.create_new_study(directions, name))
        _name_metrics(storage, name, study)
        return made
    return int(storage.get_study_id_from_name(name))


def _name_metrics(storage: RDBStorage, name: str, study: Study) -> None:
    """Let a dashboard call the objectives by their names."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # Optuna calls it experimental
        whole = optuna.load_study(study_name=name, storage=storage)
        whole.set_metric_names([objective.metric for objective in study.objectives])


def require_same(
    storage: RDBStorage, study_id: int, asks_for: Mapping[str, str], name: str, place: str
) -> None:
    """Refuse a study that asks for something else."""
    attributes = storage.get_study_user_attrs(study_id)
    if ASKS_FOR not in attributes and not storage.get_n_trials(study_id):
        storage.set_study_user_attr(study_id, ASKS_FOR, dict(asks_for))
        return
    before = attributes.get(ASKS_FOR, {})
    different = [
        f"{what}: {before.get(what, 'nothing')} there, {asks_for.get(what, 'nothing')} here"
        for what in {**before, **asks_for}
        if before.get(what) != asks_for.get(what)
    ]
    if different:
        told = "\n  ".join(different) if before else "it was not written by gaitlab"
        raise StoreError(
            f"{place}: holds another study called {name!r}:\n  {told}\n"
            "Put the file back as it was, or give the new study a name of its own: "
            f"`--set name={name}_2`. Trials that both want are not simulated again."
        )
