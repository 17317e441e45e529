"""One run of one experiment: what is missing is run, what ends is kept, signals stop it cleanly."""

from __future__ import annotations

import signal
import threading
import time
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass, field, replace
from functools import partial
from types import FrameType

from gaitlab.dispatch.outlook import Standing, standings
from gaitlab.dispatch.summary import Progress, Silent, Summary
from gaitlab.errors import StoreError, UnknownName
from gaitlab.executors import Executor, Job, Outcome, Processes, Serial, simulated
from gaitlab.experiment import Experiment
from gaitlab.plan import Plan, plan
from gaitlab.provenance import provenance
from gaitlab.store import Scalar, Store, TrialRecord

TIMEOUT = 120.0  # s any trial may take
TIMEOUT_RATIO = 20.0  # s of wall time per simulated second, some fifty times the usual


def dispatch(
    experiment: Experiment,
    store: Store,
    *,
    jobs: int,
    retry_failed: bool = False,
    progress: Progress | None = None,
) -> Summary:
    """Run the trials of an experiment that the store does not hold yet.

    The first Ctrl-C, or SIGTERM, lets the running trials end; the second Ctrl-C kills them.

    Args:
        experiment: What to run.
        store: Where results go; held against other runs meanwhile.
        jobs: Worker processes; 0 runs every trial in this process.
        retry_failed: Run trials again that failed before.
        progress: Who is told.

    Raises:
        StoreError: If the store is held by another run or cannot be written.
        KeyboardInterrupt: At the second Ctrl-C.
    """
    with store.lock():
        sweep = _Sweep(experiment, store, retry_failed, progress or Silent())
        return sweep.run(_executor(store, jobs))


@dataclass
class _Sweep:
    """One run of one experiment, and its counts so far."""

    experiment: Experiment
    store: Store
    retry_failed: bool
    progress: Progress
    summary: Summary = field(default_factory=Summary)
    start: float = field(default_factory=time.monotonic)

    def run(self, executor: Executor) -> Summary:
        """Run what is missing until it is done or somebody stops it."""
        planned = plan(self.experiment)
        todo = self._take_stock(planned)
        self.progress.start(self.summary)
        try:
            with self._stoppable(executor), closing(executor.run(_jobs(planned, todo))) as outcomes:
                for outcome in outcomes:
                    self._keep(outcome)
        finally:
            self.progress.finish(self.summary)
        self.store.compact()
        return self.summary

    def _take_stock(self, planned: Plan) -> set[str]:
        """Register the plan, count what is there, give the ids of the trials that are due."""
        entries = self.store.compact().entries
        wanted = self.store.register(self.experiment, planned.trials()).trials
        standing = standings(self.store)
        stands = {trial.trial_id: standing(trial.trial_id) for trial in wanted}
        counts = Counter(stands.values())
        self.summary = Summary(
            planned=len(stands),
            cached=counts["cached"],
            failed=0 if self.retry_failed else counts["failed before"],
            falls=sum(_fell(entries[i].metrics) for i in stands if i in entries),
        )
        idle: set[Standing] = {"cached"} if self.retry_failed else {"cached", "failed before"}
        return {trial_id for trial_id, stand in stands.items() if stand not in idle}

    def _keep(self, outcome: Outcome) -> None:
        """Note one outcome and tell of it."""
        record = outcome.record or _settle(self.store, outcome)
        self.store.note(record)
        self.summary = replace(
            _counted(self.summary, record), seconds=time.monotonic() - self.start
        )
        self.progress.update(self.summary)

    @contextmanager
    def _stoppable(self, executor: Executor) -> Iterator[None]:
        """Signals drain the executor while the block runs; only the main thread can have them."""
        if threading.current_thread() is not threading.main_thread():
            yield
            return

        def stop(number: int, frame: FrameType | None) -> None:
            if self.summary.interrupted and number == signal.SIGINT:
                raise KeyboardInterrupt
            executor.drain()
            self.summary = replace(self.summary, interrupted=True)
            self.progress.message(f"stopping: {executor.running} running trials are finished first")

        before = {number: signal.signal(number, stop) for number in (signal.SIGINT, signal.SIGTERM)}
        try:
            yield
        finally:
            for number, handler in before.items():
                signal.signal(number, handler)


def _executor(store: Store, jobs: int) -> Executor:
    task = partial(simulated, store=store.path)
    return Processes(task, jobs) if jobs else Serial(task)


def _jobs(planned: Plan, todo: set[str]) -> Iterator[Job]:
    """The trials that are due, in the order of the plan, each once and only when asked for."""
    timeout = TIMEOUT + TIMEOUT_RATIO * planned.seconds
    for item in planned.trials():
        if item.trial.id in todo:
            todo.discard(item.trial.id)
            yield Job(trial_id=item.trial.id, trial=item.trial.to_dict(), timeout=timeout)


def _settle(store: Store, outcome: Outcome) -> TrialRecord:
    """The record of a trial whose worker was lost: what it committed, or else `FAILED`."""
    with suppress(UnknownName, StoreError):
        committed = store.record(outcome.job.trial_id)
        if committed.state != "FAILED":
            return committed
    record = TrialRecord(
        trial_id=outcome.job.trial_id,
        state="FAILED",
        reason=outcome.reason,
        trial=outcome.job.trial,
        metrics={},
        provenance=provenance(outcome.seconds),
    )
    store.commit(record, None)
    return record


def _counted(summary: Summary, record: TrialRecord) -> Summary:
    falls = summary.falls + _fell(record.metrics)
    if record.state == "DONE":
        return replace(summary, done=summary.done + 1, falls=falls)
    if record.state == "INFEASIBLE":
        return replace(summary, infeasible=summary.infeasible + 1)
    return replace(summary, failed=summary.failed + 1, newly_failed=summary.newly_failed + 1)


def _fell(metrics: Mapping[str, Scalar]) -> bool:
    return bool(metrics.get("fell"))
