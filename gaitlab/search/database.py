"""The record of a search in a database: candidates under way and those that were told.

One candidate is one trial of an Optuna study, which optuna-dashboard shows as it is. It appears
whole, in one transaction, when it is proposed, and counts as told in the one transaction that
gives it its state; whatever is killed between the two is walked again from its own trials.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from math import isfinite
from pathlib import Path

from optuna.storages import RDBStorage, get_storage
from optuna.trial import FrozenTrial, TrialState, create_trial

from gaitlab.errors import StoreError
from gaitlab.experiment import Experiment
from gaitlab.experiment.study import Study
from gaitlab.search import coordinators
from gaitlab.search.addresses import database_file, understood
from gaitlab.search.asking import Proposal, Told
from gaitlab.search.candidates import Candidate
from gaitlab.search.entries import (
    ASKED_BY,
    BATCH,
    OWNER,
    RESULT,
    Pending,
    candidate_of,
    pending_of,
    result_of,
    told_of,
)
from gaitlab.search.objectives import violation_names
from gaitlab.search.opening import id_of, made, require_same, storage_at, study_asked
from gaitlab.search.space import distributions, key
from gaitlab.store import Store

FINISHED = (TrialState.COMPLETE, TrialState.PRUNED)


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
        with storage_at(experiment.name, store, address) as (storage, place, file):
            with understood(place, file):
                study_id = id_of(storage, experiment.name)
            yield (
                None
                if study_id is None
                else cls(storage, study_asked(experiment), study_id, place, file)
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
        study = study_asked(experiment)
        with storage_at(experiment.name, store, address) as (storage, place, file):
            with understood(place, file):
                study_id = made(storage, experiment.name, study)
                require_same(storage, study_id, asks_for, experiment.name, place)
            database = cls(storage, study, study_id, place, file)
            database.beat()
            try:
                yield database
            finally:
                with suppress(StoreError):
                    database.leave()

    def told(self) -> tuple[Candidate, ...]:
        """Candidates that were told, in their order."""
        return tuple(candidate_of(self._study, trial) for trial in self._trials(FINISHED))

    def remembered(self, before: int | None = None) -> tuple[Told, ...]:
        """The same as a sampler is told, perhaps only those before a number."""
        trials = self._trials(FINISHED)
        return tuple(told_of(self._study, t) for t in trials if before is None or t.number < before)

    def pending(self) -> tuple[Pending, ...]:
        """Candidates under way, whoever walks them."""
        return tuple(pending_of(self._study, t) for t in self._trials((TrialState.RUNNING,)))

    def batch_of(self, one: Pending) -> tuple[Pending, ...]:
        """Everything that was proposed together, told or not, in the order of the numbers."""
        trials = self._trials((*FINISHED, TrialState.RUNNING))
        every = (pending_of(self._study, trial) for trial in trials)
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
        return tuple(pending_of(self._study, t) for t in wanted if t.user_attrs[BATCH] == batch)

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
            self._storage.set_trial_user_attr(trial_id, RESULT, result_of(candidate))
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
