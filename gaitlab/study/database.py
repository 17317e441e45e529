"""The record of a search in a database: candidates under way and those that were told.

One candidate is one trial of an Optuna study, which optuna-dashboard shows as it is. It appears
whole, in one transaction, when it is proposed, and counts as told in the one transaction that
gives it its state; whatever is killed between the two is walked again from its own trials.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from math import inf, isfinite
from pathlib import Path
from typing import cast

import optuna
from optuna.exceptions import DuplicatedStudyError
from optuna.storages import RDBStorage, get_storage
from optuna.study import StudyDirection
from optuna.trial import FrozenTrial, TrialState, create_trial

from gaitlab.errors import StoreError
from gaitlab.experiment import Experiment, Value
from gaitlab.experiment.study import Study
from gaitlab.objectives import violation_names
from gaitlab.store import Store
from gaitlab.study import coordinators
from gaitlab.study.addresses import (
    database_file,
    file_storage,
    server_storage,
    shown,
    understood,
)
from gaitlab.study.asking import Proposal, Told
from gaitlab.study.candidates import Candidate, State
from gaitlab.study.space import distributions, in_order, key

ASKS_FOR = "gaitlab: what the study asks for"  # attribute of the study
BATCH, ASKED_BY, OWNER, RESULT = "batch", "asked by", "owner", "result"  # attributes of a trial
FINISHED = (TrialState.COMPLETE, TrialState.PRUNED)


@dataclass(frozen=True, kw_only=True)
class Pending:
    """A candidate under way.

    Attributes:
        number: Position in the order of the search.
        values: By dotted path.
        batch: Number of candidates before those proposed together with it.
        asked_by: Coordinator that proposed it.
        owner: Coordinator that walks it.
    """

    number: int
    values: Mapping[str, Value]
    batch: int
    asked_by: str
    owner: str


class Database:
    """Candidates of one search.

    Attributes:
        fresh: Whether nothing had been recorded before it was opened.
        place: Where it is, without a password.
    """

    def __init__(
        self, storage: RDBStorage, study: Study, study_id: int, place: str, file: Path | None
    ) -> None:
        self._backend, self._storage = storage, get_storage(storage)
        self._study, self._id, self.place, self._file = study, study_id, place, file
        self._me = coordinators.this_one().name
        self.fresh = not self._trials()

    @classmethod
    @contextmanager
    def existing(
        cls, experiment: Experiment, store: Store, address: str | None
    ) -> Iterator[Database | None]:
        """The record of a search for reading; None if the search was never begun."""
        if address is None and not database_file(store, experiment.name).exists():
            yield None
            return
        with _storage(experiment.name, store, address) as (storage, place, file):
            with understood(place, file):
                study_id = _id_of(storage, experiment.name)
            yield (
                None
                if study_id is None
                else cls(storage, _study_of(experiment), study_id, place, file)
            )

    @classmethod
    @contextmanager
    def opened(
        cls,
        experiment: Experiment,
        store: Store,
        address: str | None,
        asks_for: Mapping[str, str],
    ) -> Iterator[Database]:
        """The record of a search for going on with it.

        Args:
            experiment: What is searched.
            store: Whose database it is, unless there is an address.
            address: Of a database server.
            asks_for: Everything that must be the same whenever the search goes on.

        Raises:
            StoreError: If the database cannot be used, or a study of this name asks for something
                else; says what.
        """
        study = _study_of(experiment)
        with _storage(experiment.name, store, address) as (storage, place, file):
            with understood(place, file):
                study_id = _made(storage, experiment.name, study)
                _check(storage, study_id, asks_for, experiment.name, place)
            database = cls(storage, study, study_id, place, file)
            database.beat()
            try:
                yield database
            finally:
                with suppress(StoreError):
                    database.leave()

    def told(self) -> tuple[Candidate, ...]:
        """Candidates that were told, in their order."""
        return tuple(_candidate(self._study, trial) for trial in self._trials(FINISHED))

    def remembered(self, before: int | None = None) -> tuple[Told, ...]:
        """The same as a sampler is told, perhaps only those before a number."""
        trials = self._trials(FINISHED)
        return tuple(_told(self._study, t) for t in trials if before is None or t.number < before)

    def pending(self) -> tuple[Pending, ...]:
        """Candidates under way, whoever walks them."""
        return tuple(_pending(self._study, t) for t in self._trials((TrialState.RUNNING,)))

    def batch_of(self, one: Pending) -> tuple[Pending, ...]:
        """Everything that was proposed together, told or not, in the order of the numbers."""
        trials = self._trials((*FINISHED, TrialState.RUNNING))
        every = (_pending(self._study, trial) for trial in trials)
        return tuple(p for p in every if (p.batch, p.asked_by) == (one.batch, one.asked_by))

    def add(
        self, proposals: Sequence[Proposal], batch: int, total: int, asked_by: str = ""
    ) -> tuple[Pending, ...]:
        """Record proposals as under way, as far as the total leaves room for them.

        Of coordinators that propose at the same time, the one that came later gives way.

        Args:
            proposals: The candidates.
            batch: Number of candidates before those proposed together with them.
            total: Most candidates that there may be.
            asked_by: Coordinator that proposed them, if not this one.
        """
        with self._understood():
            for proposal in proposals:
                trial = self._under_way(proposal, batch, asked_by or self._me)
                self._storage.create_new_trial(self._id, trial)
        counted = self._trials((*FINISHED, TrialState.RUNNING))
        first: dict[object, int] = {}
        for trial in counted:
            first.setdefault(key(trial.params), trial.number)
        kept = [t for t in counted[:total] if first[key(t.params)] == t.number]
        mine = [t for t in counted if t.user_attrs.get(OWNER) == self._me]
        surplus = [t for t in mine if t.state == TrialState.RUNNING and t not in kept]
        for trial in surplus:
            self._finish(trial.number, TrialState.FAIL)
        wanted = [t for t in kept if t in mine and t.state == TrialState.RUNNING]
        return tuple(_pending(self._study, t) for t in wanted if t.user_attrs[BATCH] == batch)

    def take_over(self, orphans: Sequence[Pending]) -> None:
        """Walk what a coordinator that is no more had under way."""
        with self._understood():
            for orphan in orphans:
                self._storage.set_trial_user_attr(self._trial_id(orphan.number), OWNER, self._me)

    def report(self, number: int, seeds: int, objectives: Sequence[float]) -> None:
        """Show what a candidate is worth after some seeds; of several objectives, nothing."""
        if len(objectives) == 1 and isfinite(objectives[0]):
            with self._understood():
                trial_id = self._trial_id(number)
                self._storage.set_trial_intermediate_value(trial_id, seeds, objectives[0])

    def tell(self, candidate: Candidate) -> None:
        """Record what became of a candidate; it counts from the last of these steps on."""
        trial_id = self._trial_id(candidate.number)
        names = violation_names(self._study)
        with self._understood():
            for name, violation in zip(names, candidate.violations, strict=True):
                self._storage.set_trial_system_attr(trial_id, f"constraints:{name}", violation)
            self._storage.set_trial_user_attr(trial_id, RESULT, _result(candidate))
        state = TrialState.COMPLETE if candidate.state == "done" else TrialState.PRUNED
        self._finish(candidate.number, state, candidate.objectives)

    def beat(self) -> None:
        """Show that this coordinator lives."""
        self._sign(coordinators.now())

    def leave(self) -> None:
        """Show that this coordinator has ended."""
        self._sign("")

    def living(self) -> tuple[str, ...]:
        """Coordinators of this search that live, this one among them."""
        with self._understood():
            return coordinators.living(self._storage.get_study_user_attrs(self._id))

    @property
    def me(self) -> str:
        """What this coordinator is called."""
        return self._me

    def _sign(self, text: str) -> None:
        if self._file is not None:
            return  # a file of the store has one coordinator, the one that holds the store
        with self._understood():
            name = f"{coordinators.PREFIX}{self._me}"
            self._storage.set_study_user_attr(self._id, name, text)

    def _under_way(self, proposal: Proposal, batch: int, asked_by: str) -> FrozenTrial:
        return create_trial(
            state=TrialState.RUNNING,
            params=dict(proposal.values),
            distributions=distributions(self._study, proposal.values),
            user_attrs={BATCH: batch, ASKED_BY: asked_by, OWNER: self._me},
            system_attrs=dict(proposal.notes),
        )

    def _finish(self, number: int, state: TrialState, values: Sequence[float] = ()) -> None:
        complete = state == TrialState.COMPLETE
        given = list(values) if values and (complete or all(map(isfinite, values))) else None
        with self._understood():
            self._storage.set_trial_state_values(self._trial_id(number), state, given)

    def _trial_id(self, number: int) -> int:
        with self._understood():
            return self._storage.get_trial_id_from_study_id_trial_number(self._id, number)

    def _trials(self, states: Sequence[TrialState] | None = None) -> list[FrozenTrial]:
        with self._understood():
            found = self._storage.get_all_trials(
                self._id, deepcopy=False, states=None if states is None else tuple(states)
            )
        return sorted(found, key=lambda trial: trial.number)

    @contextmanager
    def _understood(self) -> Iterator[None]:
        with understood(self.place, self._file):
            yield


@contextmanager
def _storage(
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


def _study_of(experiment: Experiment) -> Study:
    if experiment.study is None:
        raise ValueError(f"{experiment.name} is no study")
    return experiment.study


def _id_of(storage: RDBStorage, name: str) -> int | None:
    try:
        return int(storage.get_study_id_from_name(name))
    except KeyError:
        return None


def _made(storage: RDBStorage, name: str, study: Study) -> int:
    """The study of this name, made if there is none; another coordinator may be making it too."""
    found = _id_of(storage, name)
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


def _check(
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


def _pending(study: Study, trial: FrozenTrial) -> Pending:
    return Pending(
        number=trial.number,
        values=in_order(study, trial.params),
        batch=int(trial.user_attrs[BATCH]),
        asked_by=str(trial.user_attrs[ASKED_BY]),
        owner=str(trial.user_attrs[OWNER]),
    )


def _told(study: Study, trial: FrozenTrial) -> Told:
    candidate = _candidate(study, trial)
    return Told(
        values=candidate.values,
        objectives=candidate.objectives,
        violations=candidate.violations,
        notes={k: v for k, v in trial.system_attrs.items() if not k.startswith("constraints")},
    )


def _result(candidate: Candidate) -> dict[str, object]:
    """What there is to know, as JSON that a browser reads too: it knows no infinity."""
    return {
        "state": candidate.state,
        "reason": candidate.reason,
        "seeds": candidate.seeds,
        "simulated seconds": candidate.simulated,
        "objectives": [value if isfinite(value) else None for value in candidate.objectives],
        "violations": list(candidate.violations),
        "trials": list(candidate.trial_ids),
    }


def _candidate(study: Study, trial: FrozenTrial) -> Candidate:
    result = trial.user_attrs[RESULT]
    violations = tuple(float(violation) for violation in result["violations"])
    state = cast(State, result["state"])
    return Candidate(
        number=trial.number,
        values=in_order(study, trial.params),
        state=state,
        objectives=tuple(
            _bad(objective.direction) if value is None else float(value)
            for objective, value in zip(study.objectives, result["objectives"], strict=True)
        ),
        violations=violations,
        feasible=state != "infeasible" and all(violation <= 0.0 for violation in violations),
        seeds=int(result["seeds"]),
        trial_ids=tuple(result["trials"]),
        batch=int(trial.user_attrs[BATCH]),
        simulated=float(result["simulated seconds"]),
        reason=str(result["reason"]),
    )


def _bad(direction: str) -> float:
    return -inf if direction == "maximize" else inf
