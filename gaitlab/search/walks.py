"""Trials of candidates: taken from the store, or walked by workers that live as long as the search.

Trials are ordinary ones, so what any experiment or search has walked before is not walked again.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

from gaitlab.dispatch.sweep import TIMEOUT, TIMEOUT_RATIO, settle
from gaitlab.errors import WrongValue
from gaitlab.executors import Executor, Job
from gaitlab.executors import Outcome as Ended
from gaitlab.experiment import Experiment, Value, candidate
from gaitlab.plan import PlannedTrial, duration, plan
from gaitlab.search.objectives import Outcome
from gaitlab.store import Held, Index, Store, TrialRecord


class Stopped(Exception):
    """Somebody pressed Ctrl-C, and what was running has ended."""


@dataclass(frozen=True)
class Walk:
    """What a candidate would have to walk.

    Attributes:
        trials: Its trials by seed; empty if the values are refused.
        refusal: Why nothing can be walked; empty if it can.
    """

    trials: Mapping[int, Sequence[PlannedTrial]]
    refusal: str = ""

    def first(self, seeds: Sequence[int]) -> list[PlannedTrial]:
        """Trials of some seeds on every ground, seed by seed."""
        return [item for seed in seeds for item in self.trials.get(seed, ())]


def walk_of(experiment: Experiment, values: Mapping[str, Value]) -> Walk:
    """The trials of a candidate; what robot or gait refuse is a finding and no mistake."""
    trials: dict[int, list[PlannedTrial]] = {}
    try:
        for item in plan(candidate(experiment, values)).trials():
            trials.setdefault(item.trial.seed, []).append(item)
    except (WrongValue, ValueError, ArithmeticError) as error:
        return Walk({}, " ".join(str(error).split()))
    return Walk(trials)


@dataclass
class Walks:
    """Results of trials, and the workers that make those that are missing.

    Attributes:
        store: Where trials are kept.
        held: The store's lock.
        executor: Runs trials.
        workers: How many at a time.
        told: Called after every trial that was walked.
        count: Trials that were walked.
        seconds: Simulated time of those, in [s].
    """

    store: Store
    held: Held
    executor: Executor
    workers: int
    told: Callable[[], None]
    count: int = 0
    seconds: float = 0.0
    _queue: deque[Job] = field(default_factory=deque)
    _under_way: dict[str, PlannedTrial] = field(default_factory=dict)
    _made: dict[str, Outcome] = field(default_factory=dict)
    _times: dict[str, float] = field(default_factory=dict)

    @cached_property
    def _index(self) -> Index:
        return self.store.compact()

    @cached_property
    def _ended(self) -> Generator[Ended, None, None]:
        return self.executor.run(_Queued(self._queue))

    def close(self) -> None:
        """End the workers, whatever they do."""
        self._ended.close()

    def has(self, item: PlannedTrial) -> bool:
        """Whether a trial is in the store."""
        return item.trial.id in self._made or item.trial.id in self._index.entries

    def made(self, trial_id: str) -> bool:
        """Whether a trial was walked by this run."""
        return trial_id in self._made

    def outcome(self, item: PlannedTrial) -> Outcome:
        """What became of a trial that is in the store."""
        return self._made.get(item.trial.id) or self._known(item)

    def time(self, item: PlannedTrial) -> float:
        """Simulated time of a trial that is in the store, in [s]."""
        return simulated_time(item, self.outcome(item))

    def walk(self, wanted: Sequence[PlannedTrial], ahead: Sequence[PlannedTrial] = ()) -> None:
        """See to it that trials are in the store.

        Args:
            wanted: The trials.
            ahead: Those that will probably be wanted next; a worker that would otherwise wait
                for the last of the wanted ones may begin with them.

        Raises:
            Stopped: If the executor takes no more; the trials that ran are kept.
        """
        missing = {item.trial.id: item for item in wanted if not self.has(item)}
        for item in missing.values():
            self._submit(item)
        later = (item for item in ahead if not self.has(item))
        while missing:
            self._fill(later)
            ended = next(self._ended, None)
            if ended is None:
                raise Stopped
            missing.pop(self._keep(ended), None)

    def _fill(self, later: Iterator[PlannedTrial]) -> None:
        while not self._queue and len(self._under_way) < self.workers:
            item = next(later, None)
            if item is None:
                return
            self._submit(item)

    def _submit(self, item: PlannedTrial) -> None:
        trial_id = item.trial.id
        if trial_id in self._under_way:
            return
        self._under_way[trial_id] = item
        seconds = duration(item.trial.gait, item.trial.horizon)
        timeout = TIMEOUT + TIMEOUT_RATIO * seconds
        self._queue.append(Job(trial_id=trial_id, trial=item.trial.to_dict(), timeout=timeout))

    def _keep(self, ended: Ended) -> str:
        self.held.check()
        record = ended.record or settle(self.store, ended)
        self.store.note(record)
        item = self._under_way.pop(record.trial_id)
        self._made[record.trial_id] = _outcome(item, record)
        self.count += 1
        self.seconds += self.time(item)
        self.told()
        return record.trial_id

    def _known(self, item: PlannedTrial) -> Outcome:
        entry = self._index.entries[item.trial.id]
        return Outcome(
            surface=str(item.values["surface"]),
            seed=item.trial.seed,
            state=entry.state,
            metrics=entry.details.metrics,
        )


class _Queued(Iterator[Job]):
    """Jobs as long as there are some; more may come later."""

    def __init__(self, queue: deque[Job]) -> None:
        self._queue = queue

    def __next__(self) -> Job:
        if not self._queue:
            raise StopIteration
        return self._queue.popleft()


def _outcome(item: PlannedTrial, record: TrialRecord) -> Outcome:
    return Outcome(
        surface=str(item.values["surface"]),
        seed=item.trial.seed,
        state=record.state,
        metrics=record.metrics,
    )


def simulated_time(item: PlannedTrial, outcome: Outcome) -> float:
    """How long a trial was simulated, in [s]; 0 if it was not."""
    if not outcome.walked:
        return 0.0
    name = "time_to_fall" if outcome.fell else "walked_time"
    walked = outcome.metrics.get(name)
    return item.trial.gait.startup_time + (
        float(walked) if isinstance(walked, int | float) else 0.0
    )
