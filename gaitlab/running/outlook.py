"""How the trials of an experiment stand, and what those that are missing would cost."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

from gaitlab.errors import StoreError
from gaitlab.experiment import Experiment
from gaitlab.experiment.plan import Plan, plan
from gaitlab.running.basis import Past, basis
from gaitlab.running.executor import TIMED_OUT
from gaitlab.running.pace import Pace
from gaitlab.simulation.trial import duration
from gaitlab.store import Index, Listed, Shard, Store, listed, shares

BYTES_PER_TICK = 350  # of a committed log of 20 joints, see benchmarks
LOAD_TIME = 1.5  # s, in which workers load what they need

# One of the five below, or what changed since the same cell was asked for: `surface changed`.
Standing: TypeAlias = str
CACHED, NEW, DAMAGED, FAILED_BEFORE = "cached", "new", "file damaged", "failed before"
TIMED_OUT_BEFORE = "timed out before"  # as may be the machine's fault, so it is run again
KEPT_OUT = ("newer", "unreachable")  # files that no run may replace


@dataclass(frozen=True, kw_only=True)
class Cost:
    """What a number of trials takes if no robot falls.

    Attributes:
        trials: How many.
        seconds: Wall time, in [s].
        size: Room on disk, in [byte].
    """

    trials: int
    seconds: float
    size: float


@dataclass(frozen=True, kw_only=True)
class Outlook:
    """What `run` would do.

    Attributes:
        standings: For each cell of the plan, how many of its trials stand how.
        values: Varied parameters of each cell by dotted path.
        trial_seconds: Simulated time of one trial at most, in [s].
        own_code: Files of the user's own that the experiment names, and that run as code.
        swept: How a design spreads a path over its range, in words, by dotted path.
    """

    standings: Sequence[Mapping[Standing, int]]
    values: Sequence[Mapping[str, object]]
    trial_seconds: float
    own_code: Sequence[str] = ()
    swept: Mapping[str, str] = field(default_factory=dict)

    @property
    def planned(self) -> int:
        """Trials of the plan."""
        return sum(sum(cell.values()) for cell in self.standings)

    def count(self, standing: Standing) -> int:
        """Trials that stand so, over all cells."""
        return sum(cell.get(standing, 0) for cell in self.standings)

    def due(self, retry_failed: bool) -> dict[Standing, int]:
        """How many trials `run` would run, by the reason why."""
        total: Counter[Standing] = Counter()
        for cell in self.standings:
            total.update(cell)
        idle = {CACHED} if retry_failed else {CACHED, FAILED_BEFORE}
        return {standing: count for standing, count in total.items() if standing not in idle}


def cost(planned: Plan, trials: int, jobs: int) -> Cost:
    """What this many trials of a plan take with this many workers, counted without expanding.

    Time goes by how fast this machine has simulated such trials so far.
    """
    sample = [(trial, duration(trial.gait, trial.horizon)) for trial in planned.sample]
    ticks = sum(seconds / trial.engine.dt for trial, seconds in sample) / len(sample)
    return Cost(
        trials=trials,
        seconds=trials * Pace.here().mean(sample) / max(1, jobs) + (LOAD_TIME if trials else 0.0),
        size=trials * ticks * BYTES_PER_TICK,
    )


def outlook(experiment: Experiment, store: Store, shard: Shard | None = None) -> Outlook:
    """How every cell of an experiment, or of a shard of it, stands; nothing is run or written."""
    planned = plan(experiment, programs=False)
    past = Past(basis(experiment), store.earlier(experiment.listed_as))
    standing = standings(store.index(), past)
    cells: dict[int, Counter[Standing]] = {}
    values: dict[int, Mapping[str, object]] = {}
    numbers = dealt(planned, shard.count) if shard else {}
    for item in planned.trials():
        if shard and numbers[item.trial.id] != shard.number:
            continue
        cells.setdefault(item.cell_index, Counter())[standing(listed(item))] += 1
        values.setdefault(item.cell_index, item.values)
    walkers = experiment.walkers.values() or [experiment.parts]
    codes = [code for parts in walkers for code in parts.codes]
    return Outlook(
        standings=[cells[index] for index in sorted(cells)],
        values=[values[index] for index in sorted(values)],
        trial_seconds=planned.seconds,
        own_code=(
            *(code.told for code in codes if code.is_code),
            *planned.written_by,
        ),
        swept=experiment.design.texts if experiment.design else {},
    )


def dealt(planned: Plan, count: int) -> dict[str, int]:
    """Number of the shard of each trial of a plan, of so many shards; see `shares`."""
    return shares(
        {item.trial.id: duration(item.trial.gait, item.trial.horizon) for item in planned.trials()},
        count,
    )


def standings(index: Index, past: Past) -> Callable[[Listed], Standing]:
    """How a wanted trial stands in a store.

    Raises:
        StoreError: By the function that is returned, for a trial whose file a newer gaitlab wrote.
    """
    unreadable = {error.path.stem: error for error in index.unreadable}

    def standing(wanted: Listed) -> Standing:
        entry = index.entries.get(wanted.trial_id)
        if entry is not None and entry.state == "FAILED":
            return TIMED_OUT_BEFORE if entry.reason.startswith(TIMED_OUT) else FAILED_BEFORE
        if entry is not None:
            return CACHED
        error = unreadable.get(wanted.trial_id)
        if error is not None and error.kind in KEPT_OUT:
            raise StoreError(str(error)) from error
        if error is not None:
            return DAMAGED
        return past.reason(wanted) or NEW

    return standing
