"""The record of a search in a database: candidates under way and those that are finished.

One candidate is one trial of an Optuna study, which optuna-dashboard shows as it is. It appears
whole, in one transaction, when it is proposed, and counts as finished in the one transaction that
gives it its state; whatever is killed between the two is walked again from its own trials.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass
from math import inf, isfinite
from typing import cast

import optuna
from optuna.exceptions import DuplicatedStudyError
from optuna.storages import RDBStorage, get_storage
from optuna.study import StudyDirection
from optuna.trial import FrozenTrial, TrialState, create_trial

from gaitlab.errors import StoreError, UnknownName
from gaitlab.experiment import Experiment, Value, study_of
from gaitlab.experiment.shell import command
from gaitlab.experiment.study import Aggregate, Choices, Constraint, Numbers, Objective, Study
from gaitlab.parameters import canonical_json
from gaitlab.search import heartbeat
from gaitlab.search.candidates import Candidate, CandidateState, History
from gaitlab.search.final import with_final
from gaitlab.search.objectives import violation_names
from gaitlab.search.sampling import Observation, Proposal, quiet
from gaitlab.search.space import distributions, in_order, key
from gaitlab.search.storage import Opened, database_file, shown, storage_at, understood
from gaitlab.store import Store

FINISHED = (TrialState.COMPLETE, TrialState.PRUNED)
BATCH, ASKED_BY, OWNER, RESULT = "batch", "asked by", "owner", "result"  # attributes of a trial
ASKS_FOR = "gaitlab: what the study asks for"  # attribute of the study
SHORT = 16  # hex digits of a digest


@dataclass(frozen=True, kw_only=True)
class Pending:
    """A candidate under way.

    Attributes:
        number: Position in the order of the search.
        values: By dotted path.
        batch: Number of candidates before those proposed together with it.
        asked_by: Process that proposed it.
        owner: Process that walks it.
    """

    number: int
    values: Mapping[str, Value]
    batch: int
    asked_by: str
    owner: str


def history(experiment: Experiment, store: Store, address: str | None = None) -> History:
    """The candidates of a finished or half-finished search, and its final if it was held.

    Nothing is changed.

    Args:
        experiment: What is searched.
        store: Where its trials are, and by default its database.
        address: Of another database.

    Raises:
        UnknownName: If the search was never begun.
        StoreError: If the database cannot be read, or belongs to another study.
    """
    with Database.existing(experiment, store, address) as database:
        if database is None:
            raise UnknownName(
                f"{experiment.name}: nothing was searched yet on {store.path}; "
                f"`{command_line('optimize', experiment, store, address)}` does"
            )
        return with_final(History(experiment=experiment, candidates=database.candidates()), store)


def command_line(verb: str, experiment: Experiment, store: Store, address: str | None) -> str:
    """The line that goes on with a search, `optimize`, or writes its page, `report`."""
    more = ["--storage", shown(address)] if address else []
    return command(verb, [experiment], store.path, *more)


class Database:
    """Candidates of one search.

    Attributes:
        fresh: Whether nothing had been recorded before it was opened.
        place: Where it is, without a password.
        me: What this process is called.
    """

    def __init__(self, opened: Opened, study: Study, study_id: int) -> None:
        self.place, self._file = opened.place, opened.file
        self._storage = get_storage(opened.storage)
        self._study, self._id = study, study_id
        self.me = heartbeat.this_process()
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
        with storage_at(experiment.name, store, address) as opened:
            with understood(opened.place, opened.file):
                study_id = _id_of(opened.storage, experiment.name)
            yield None if study_id is None else cls(opened, study_of(experiment), study_id)

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
        study = study_of(experiment)
        with storage_at(experiment.name, store, address) as opened:
            with understood(opened.place, opened.file):
                study_id = _made(opened.storage, experiment.name, study)
                _require_same(opened, study_id, asks_for, experiment.name)
            database = cls(opened, study, study_id)
            database.beat()
            try:
                yield database
            finally:
                with suppress(StoreError):
                    database.leave()

    def candidates(self) -> tuple[Candidate, ...]:
        """Finished candidates, in their order."""
        return tuple(_candidate(self._study, trial) for trial in self._trials(FINISHED))

    def observations(self, before: int | None = None) -> tuple[Observation, ...]:
        """The same as a sampler knows them, perhaps only those before a number."""
        trials = self._trials(FINISHED)
        return tuple(
            _observation(self._study, trial)
            for trial in trials
            if before is None or trial.number < before
        )

    def pending(self) -> tuple[Pending, ...]:
        """Candidates under way, whoever walks them."""
        return tuple(_pending(self._study, t) for t in self._trials((TrialState.RUNNING,)))

    def batch_of(self, candidate: Pending) -> tuple[Pending, ...]:
        """Everything that was proposed together, finished or not, in the order of the numbers."""
        trials = self._trials((*FINISHED, TrialState.RUNNING))
        wanted = candidate.batch, candidate.asked_by
        every = (_pending(self._study, trial) for trial in trials)
        return tuple(other for other in every if (other.batch, other.asked_by) == wanted)

    def add(
        self, proposals: Sequence[Proposal], batch: int, total: int, asked_by: str = ""
    ) -> tuple[Pending, ...]:
        """Record proposals as under way, as far as the total leaves room for them.

        Of processes that propose at the same time, the one that came later gives way.

        Args:
            proposals: The candidates.
            batch: Number of candidates before those proposed together with them.
            total: Most candidates that there may be.
            asked_by: Process that proposed them, if not this one.
        """
        for proposal in proposals:
            trial = create_trial(
                state=TrialState.RUNNING,
                params=dict(proposal.values),
                distributions=distributions(self._study, proposal.values),
                user_attrs={BATCH: batch, ASKED_BY: asked_by or self.me, OWNER: self.me},
                system_attrs=dict(proposal.notes),
            )
            with self._understood():
                self._storage.create_new_trial(self._id, trial)
        counted = self._trials((*FINISHED, TrialState.RUNNING))
        first: dict[object, int] = {}
        for trial in counted:
            first.setdefault(key(trial.params), trial.number)
        kept = [t for t in counted[:total] if first[key(t.params)] == t.number]
        running = [t for t in counted if t.state == TrialState.RUNNING]
        mine = [t for t in running if t.user_attrs.get(OWNER) == self.me]
        for trial in mine:
            if trial not in kept:
                self._finish(trial.number, TrialState.FAIL)
        wanted = [t for t in mine if t in kept and t.user_attrs[BATCH] == batch]
        return tuple(_pending(self._study, trial) for trial in wanted)

    def take_over(self, orphans: Sequence[Pending]) -> None:
        """Walk what a process that is no more had under way."""
        with self._understood():
            for orphan in orphans:
                self._storage.set_trial_user_attr(self._trial_id(orphan.number), OWNER, self.me)

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
        """Show that this process lives."""
        self._sign(heartbeat.now())

    def leave(self) -> None:
        """Show that this process has ended."""
        self._sign("")

    def living(self) -> tuple[str, ...]:
        """Processes of this search that live, this one among them."""
        if self._file is not None:
            return (self.me,)  # a file of the store has one, the one that holds the store
        with self._understood():
            return heartbeat.living(self._storage.get_study_user_attrs(self._id))

    def _sign(self, text: str) -> None:
        if self._file is None:
            with self._understood():
                name = f"{heartbeat.PREFIX}{self.me}"
                self._storage.set_study_user_attr(self._id, name, text)

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
            trials = self._storage.get_all_trials(
                self._id, deepcopy=False, states=None if states is None else tuple(states)
            )
        return sorted(trials, key=lambda trial: trial.number)

    @contextmanager
    def _understood(self) -> Iterator[None]:
        with understood(self.place, self._file):
            yield


def _id_of(storage: RDBStorage, name: str) -> int | None:
    """Number of the study of this name; None if there is none."""
    try:
        return int(storage.get_study_id_from_name(name))
    except KeyError:
        return None


def _made(storage: RDBStorage, name: str, study: Study) -> int:
    """The study of this name, made if there is none; another process may be making it too."""
    known = _id_of(storage, name)
    if known is not None:
        return known
    ways = {"maximize": StudyDirection.MAXIMIZE, "minimize": StudyDirection.MINIMIZE}
    directions = [ways[objective.direction] for objective in study.objectives]
    with suppress(DuplicatedStudyError):
        made = int(storage.create_new_study(directions, name))
        with quiet():  # names by which a dashboard calls the objectives
            whole = optuna.load_study(study_name=name, storage=storage)
            whole.set_metric_names([objective.metric for objective in study.objectives])
        return made
    return int(storage.get_study_id_from_name(name))


def _require_same(opened: Opened, study_id: int, asks_for: Mapping[str, str], name: str) -> None:
    """Refuse a study that asks for something else."""
    attributes = opened.storage.get_study_user_attrs(study_id)
    if ASKS_FOR not in attributes and not opened.storage.get_n_trials(study_id):
        opened.storage.set_study_user_attr(study_id, ASKS_FOR, dict(asks_for))
        return
    before = attributes.get(ASKS_FOR, {})
    different = [
        f"{what}: {before.get(what, 'nothing')} there, {asks_for.get(what, 'nothing')} here"
        for what in {**before, **asks_for}
        if before.get(what) != asks_for.get(what)
    ]
    if different:
        what = "\n  ".join(different) if before else "it was not written by gaitlab"
        raise StoreError(
            f"{opened.place}: holds another study called {name!r}:\n  {what}\n"
            "Put the file back as it was, or give the new study a name of its own: "
            f"`--set name={name}_2`. Trials that both want are not simulated again."
        )


def asks_for(experiment: Experiment, basis: Mapping[str, str]) -> dict[str, str]:
    """Everything that must be the same whenever a search goes on, each as a text to be shown.

    The number of trials may change, and after how many without an improvement it ends.

    Args:
        experiment: A study.
        basis: Digest of every part that its candidates start from.
    """
    study, seeds = study_of(experiment), list(experiment.seeds)
    options = canonical_json(dict(study.sampler_options)) if study.sampler_options else ""
    racing = study.racing
    rounds = f"{list(racing.rounds)}, confidence {racing.confidence:g}" if racing else "off"
    drawn = hashlib.sha256(canonical_json(seeds).encode()).hexdigest()[:SHORT]
    return {
        "sampler": f"{study.sampler} {options}".strip(),
        "study.seed": str(study.seed),
        "study.batch": str(study.batch),
        **{f"search {item.path}": _space_text(item) for item in study.search},
        "objectives": "; ".join(f"{o.direction} {o.metric}{_how(o)}" for o in study.objectives),
        "constraints": "; ".join(f"{c.text}{_how(c)}" for c in study.constraints) or "none",
        "racing": rounds,
        "seeds": f"{len(seeds)} from {min(seeds)} to {max(seeds)} ({drawn})",
        **{f"digest of {part}": text for part, text in basis.items()},
    }


def _space_text(item: Numbers | Choices) -> str:
    given = {name: value for name, value in asdict(item).items() if value not in (None, False)}
    given.pop("path")
    return ", ".join(f"{name} {value}" for name, value in given.items())


def _how(item: Objective | Constraint) -> str:
    fallen = "" if item.fallen is None else f", a fall counts as {item.fallen:g}"
    seeds, grounds = _aggregate_text(item.over_seeds), _aggregate_text(item.over_surfaces)
    return f" ({seeds} of seeds, {grounds} of grounds{fallen})"


def _aggregate_text(item: Aggregate) -> str:
    return item.kind if item.kind in ("mean", "worst") else f"{item.kind} {item.share:g}"


def _pending(study: Study, trial: FrozenTrial) -> Pending:
    return Pending(
        number=trial.number,
        values=in_order(study, trial.params),
        batch=int(trial.user_attrs[BATCH]),
        asked_by=str(trial.user_attrs[ASKED_BY]),
        owner=str(trial.user_attrs[OWNER]),
    )


def _observation(study: Study, trial: FrozenTrial) -> Observation:
    candidate = _candidate(study, trial)
    return Observation(
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
    state = cast(CandidateState, result["state"])
    pairs = zip(study.objectives, result["objectives"], strict=True)
    bad = {"maximize": -inf, "minimize": inf}  # without a value
    return Candidate(
        number=trial.number,
        values=in_order(study, trial.params),
        state=state,
        objectives=tuple(bad[o.direction] if v is None else float(v) for o, v in pairs),
        violations=violations,
        feasible=state != "infeasible" and all(violation <= 0.0 for violation in violations),
        seeds=int(result["seeds"]),
        trial_ids=tuple(result["trials"]),
        batch=int(trial.user_attrs[BATCH]),
        simulated=float(result["simulated seconds"]),
        reason=str(result["reason"]),
    )
