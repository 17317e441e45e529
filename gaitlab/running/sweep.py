"""One run of one experiment: what is missing is run, what ends is kept, signals stop it cleanly."""

from __future__ import annotations

import shutil
import signal
import time
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import closing, suppress
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TypeVar

from gaitlab.experiment import Experiment
from gaitlab.experiment.plan import Plan, PlannedTrial, plan
from gaitlab.running.basis import Past, basis
from gaitlab.running.executor import Cluster, Considerate, Executor, Job, Outcome, job_of
from gaitlab.running.forecast import Forecast, Kind
from gaitlab.running.outlook import CACHED, FAILED_BEFORE, cost, dealt, standings
from gaitlab.running.pace import Pace
from gaitlab.running.processes import executor
from gaitlab.running.provenance import provenance
from gaitlab.running.signals import stoppable
from gaitlab.running.summary import Ended, Progress, Started, Summary
from gaitlab.simulation.engines import engine_of, require_engine
from gaitlab.simulation.trial import Trial, duration
from gaitlab.store import (
    Held,
    Scalar,
    Shard,
    Store,
    StoreFull,
    TrialList,
    TrialRecord,
    shares,
)
from gaitlab.store.store import TABLE_FROM

T = TypeVar("T")
MANY_CELLS = 5000  # more are not told apart in the time left, which is looked up at every end


def dispatch(
    experiment: Experiment,
    store: Store,
    *,
    jobs: int,
    shard: Shard | None = None,
    others: bool = False,
    retry_failed: bool = False,
    progress: Progress | None = None,
    cluster: Cluster | None = None,
) -> Summary:
    """Run the trials of an experiment, or of a shard of it, that the store does not hold yet.

    The first Ctrl-C, or SIGTERM, lets the running trials end; the second Ctrl-C kills them. A
    terminal that goes away (SIGHUP) stops nothing.

    Args:
        experiment: What to run.
        store: Where results go. Other experiments, and other shards of this one, may be run on it
            meanwhile; what two of them want is simulated once.
        jobs: Worker processes; 0 runs every trial in this process.
        shard: Which share of the experiment to run; None for all of it.
        others: Whether other processes may run the same meanwhile, since they share a search.
        retry_failed: Run trials again that failed before; those that only took too long are in any
            case.
        progress: Is called as the run goes on; a terminal or a reader that has gone stops no run.
        cluster: Has the workers, instead of `jobs`.

    Raises:
        NoEngine: If an engine that it asks for is not installed.
        WrongValue: If a program of the team's own writes no walk.
        StoreError: If another run is at the same, or the store cannot be written or has vanished.
        StoreFull: If there is no room; says how much the rest needs.
        KeyboardInterrupt: At the second Ctrl-C.
    """
    for name in experiment.engines:
        require_engine(name)
    plan(experiment).write_walks()
    with store.writing(experiment.listed_as, shard, others=others) as held:
        sweep = _Sweep(
            experiment=experiment,
            store=store,
            held=held,
            shard=shard,
            retry_failed=retry_failed,
            progress=progress or Progress(),
            forecast=Forecast(workers=cluster.workers if cluster else jobs),
        )
        walks = executor(store.path, jobs, cluster, sweep.message)
        return sweep.run(Considerate(walks, store))


def share_out(experiment: Experiment, store: Store, count: int) -> None:
    """Keep in the store how an experiment is shared out into shards that are run later.

    Raises:
        StoreError: If another run is at the experiment, or the store cannot be written.
    """
    with store.writing(experiment.listed_as):
        planned = plan(experiment)
        store.register(experiment, planned.trials(), basis(experiment))
        store.share_out(experiment.listed_as, dealt(planned, count), count)


@dataclass(kw_only=True)
class _Sweep:
    """One run of one experiment, and its counts so far."""

    experiment: Experiment
    store: Store
    held: Held
    shard: Shard | None
    retry_failed: bool
    progress: Progress
    forecast: Forecast
    summary: Summary = field(default_factory=Summary)
    start: float = field(default_factory=time.monotonic)
    order: list[str] = field(default_factory=list)  # ids of the plan, each made only once
    kinds: dict[str, Kind] = field(default_factory=dict)  # of the trials of the plan, by id
    running: dict[str, Started] = field(default_factory=dict)  # trials that workers have, by id
    trials: dict[str, Trial] = field(default_factory=dict)  # the same
    pace: Pace = field(default_factory=Pace.here)
    cells: dict[str, int] = field(default_factory=dict)  # of the trials of the plan, by id
    standing: Counter[int] = field(default_factory=Counter)  # falls before the first step, by cell
    standing_reported: bool = False

    def run(self, executor: Executor) -> Summary:
        """Run what is missing until it is done or somebody stops it."""
        planned = plan(self.experiment)
        with stoppable(partial(self._stop, executor)):
            try:
                self._run(executor, planned)
                if len(self.store.compact().entries) >= TABLE_FROM:
                    self.store.tabulate()
            except StoreFull as error:
                left = self.summary.left or planned.size
                room = _megabytes(cost(planned, left, 1).size)
                raise StoreFull(f"{error} The {left} trials left need up to {room}.") from error
        return self.summary

    def _run(self, executor: Executor, planned: Plan) -> None:
        todo = self._take_stock(planned)
        self._report(self.progress.start, self.summary)
        self._warn_of_little_room(planned)
        try:
            with closing(executor.run(self._launched(planned, todo))) as outcomes:
                for outcome in outcomes:
                    self.held.check()
                    self._keep(outcome)
        finally:
            self._report(self.progress.finish, self.summary)
            self.pace.save()

    def _take_stock(self, planned: Plan) -> dict[str, float]:
        """Register the plan, count what is there; simulated time of each trial that is due, by id.

        Raises:
            StoreError: If the store cannot be written, or a newer gaitlab wrote a wanted trial.
        """
        index, times = self.store.compact(), dict[str, float]()
        parts = basis(self.experiment)
        past = Past(parts, self.store.earlier(self.experiment.listed_as))
        trials = self._timed(planned, times)
        listed = self.store.register(self.experiment, trials, parts)
        standing, ours = standings(index, past), self._share(listed, times)
        stands = {t.trial_id: standing(t) for t in listed.trials if t.trial_id in ours}
        counts = Counter(stands.values())
        idle = {CACHED} if self.retry_failed else {CACHED, FAILED_BEFORE}
        todo = {i: times[i] for i, stand in stands.items() if stand not in idle}
        self.summary = replace(
            self.summary,
            planned=len(stands),
            cached=counts[CACHED],
            failed=0 if self.retry_failed else counts[FAILED_BEFORE],
            falls=sum(index.entries[i].fell for i in stands if i in index.entries),
            fell_standing=sum(
                self._fell_standing(i, index.entries[i].details.metrics)
                for i in stands
                if i in index.entries and index.entries[i].fell
            ),
        )
        for trial_id, seconds in todo.items():
            self.forecast.expect(self.kinds[trial_id], seconds)
        return todo

    def _share(self, listed: TrialList, times: Mapping[str, float]) -> Collection[str]:
        """Ids of the trials that this run sees to."""
        if self.shard is None:
            return times.keys()
        numbers = shares(times, self.shard.count)
        self.store.share_out(listed.experiment, numbers, self.shard.count)
        return {trial_id for trial_id, number in numbers.items() if number == self.shard.number}

    def _timed(self, planned: Plan, times: dict[str, float]) -> Iterator[PlannedTrial]:
        """The trials of a plan, noting their ids, and their time if the robot stays up in [s]."""
        for item in planned.trials():
            trial = item.trial
            self.order.append(trial.id)
            self.cells[trial.id] = item.cell_index
            self.kinds[trial.id] = _kind(item) if planned.cell_count <= MANY_CELLS else ()
            times[trial.id] = duration(trial.gait, trial.horizon)
            yield item

    def _launched(self, planned: Plan, todo: Mapping[str, float]) -> Iterator[Job]:
        """The jobs, each reported as an executor takes it, for it takes what it starts."""
        for job, item in _jobs(planned, self.order, todo):
            started = Started(trial_id=job.trial_id, cell=item.values, seed=item.trial.seed)
            self.running[job.trial_id], self.trials[job.trial_id] = started, item.trial
            kind, seconds = self.kinds[job.trial_id], todo[job.trial_id]
            self.forecast.start(job.trial_id, kind, seconds, time.monotonic())
            self._report(self.progress.started, started)
            yield job

    def _keep(self, outcome: Outcome) -> None:
        """Note one outcome and report it."""
        record = outcome.record or settle(self.store, outcome)
        self.store.note(record)
        now = time.monotonic()
        walked = outcome.record.provenance.get("wall_time") if outcome.record else None
        self.forecast.end(record.trial_id, now, walked if isinstance(walked, float) else None)
        self.pace.learn(self.trials.pop(record.trial_id), record)
        self.summary = replace(
            _counted(self.summary, record),
            seconds=now - self.start,
            time_left=self.forecast.time_left(now),
        )
        started = self.running.pop(record.trial_id)
        ended = Ended(
            trial_id=started.trial_id,
            cell=started.cell,
            seed=started.seed,
            state=record.state,
            stable=bool(record.metrics.get("stable")) if record.state == "DONE" else None,
            reason=record.reason.partition("\n")[0],
        )
        self._report(self.progress.ended, ended)
        self._report(self.progress.update, self.summary)
        if self._fell_standing(record.trial_id, record.metrics):
            self._report_standing(started)

    def _fell_standing(self, trial_id: str, metrics: Mapping[str, Scalar]) -> bool:
        """Whether a trial fell before its first step; if so, noted of its cell."""
        fell = _flag(metrics, "fell_standing")
        self.standing[self.cells[trial_id]] += fell
        return fell

    def _report_standing(self, trial: Started) -> None:
        """Name the first cell that is sure not to stand; the counts tell of the others."""
        count, seeds = self.standing[self.cells[trial.trial_id]], len(self.experiment.seeds)
        if self.standing_reported or 2 * count <= seeds:
            return
        self.standing_reported = True
        where = ", ".join(
            f"{path.rpartition('.')[2]} {value}" for path, value in trial.cell.items()
        )
        self.message(
            f"{where}: does not stand, {count} of {seeds} seeds fell before their first step; "
            "further such cells are only counted"
        )

    def _report(self, call: Callable[[T], None], value: T) -> None:
        with suppress(OSError):
            call(value)

    def message(self, text: str) -> None:
        """Something the user should know now."""
        self._report(self.progress.message, text)

    def _stop(self, executor: Executor, number: int) -> None:
        """Let the running trials end; at the second Ctrl-C, nothing."""
        if self.summary.interrupted and number == signal.SIGINT:
            raise KeyboardInterrupt
        executor.drain()
        self.summary = replace(self.summary, interrupted=True)
        self.message(f"stopping: {executor.running} running trials are finished first")

    def _warn_of_little_room(self, planned: Plan) -> None:
        needed = cost(planned, self.summary.left, 1).size
        with suppress(OSError):
            free = shutil.disk_usage(self.store.path).free
            if free < needed:
                self.message(
                    f"the disk has {_megabytes(free)} free and this run needs up to "
                    f"{_megabytes(needed)}; if it fills up, nothing committed is lost"
                )


def _jobs(
    planned: Plan, order: Sequence[str], todo: Mapping[str, float]
) -> Iterator[tuple[Job, PlannedTrial]]:
    """The trials that are due, each once and only when asked for.

    Seed by seed: a run that is stopped early leaves a whole table of fewer seeds, and the time left
    is known from every cell after the first round.
    """
    left = set(todo)
    for place, item in planned.rounds():
        if not left:
            return
        trial_id = order[place]
        if trial_id in left:
            left.remove(trial_id)
            yield job_of(trial_id, item.trial.to_dict(), todo[trial_id]), item


def _kind(item: PlannedTrial) -> Kind:
    """What tells how soon a robot falls, from the coarse to the fine."""
    names = item.trial.names
    return names.robot, names.surface, str(item.cell_index)


def _megabytes(size: float) -> str:
    return f"{max(size, 1e6) / 1e6:.0f} MB"


def settle(store: Store, outcome: Outcome) -> TrialRecord:
    """The record of a trial whose worker was lost: what it committed, or else `FAILED`."""
    if (committed := store.committed(outcome.job.trial_id)) is not None:
        return committed
    record = TrialRecord(
        trial_id=outcome.job.trial_id,
        state="FAILED",
        reason=outcome.reason,
        trial=outcome.job.trial,
        metrics={},
        provenance=provenance(outcome.seconds, engine_of(outcome.job.trial)),
    )
    store.commit(record, None)
    return record


def _counted(summary: Summary, record: TrialRecord) -> Summary:
    if record.state == "DONE":
        return replace(
            summary,
            done=summary.done + 1,
            falls=summary.falls + _flag(record.metrics, "fell"),
            fell_standing=summary.fell_standing + _flag(record.metrics, "fell_standing"),
        )
    if record.state == "INFEASIBLE":
        return replace(summary, infeasible=summary.infeasible + 1)
    return replace(summary, failed=summary.failed + 1, newly_failed=summary.newly_failed + 1)


def _flag(metrics: Mapping[str, Scalar], name: str) -> bool:
    return bool(metrics.get(name))
