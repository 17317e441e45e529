"""How the trials of an experiment stand, and what those that are missing would cost."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

from gaitlab.errors import StoreError
from gaitlab.experiment import Experiment
from gaitlab.plan import Plan, plan
from gaitlab.store import Store

WALL_RATIO = 0.35  # s of one core for a simulated second, see benchmarks
BYTES_PER_TICK = 350  # of a committed log of 20 joints, see benchmarks

Standing: TypeAlias = Literal["cached", "failed before", "damaged", "new"]


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
    """

    standings: Sequence[Mapping[Standing, int]]
    values: Sequence[Mapping[str, object]]
    trial_seconds: float

    @property
    def planned(self) -> int:
        """Trials of the plan."""
        return sum(sum(cell.values()) for cell in self.standings)

    def count(self, standing: Standing) -> int:
        """Trials that stand so, over all cells."""
        return sum(cell.get(standing, 0) for cell in self.standings)


def cost(planned: Plan, trials: int, jobs: int) -> Cost:
    """What this many trials of a plan take with this many workers, counted without expanding."""
    first = next(planned.trials())
    ticks = planned.seconds / first.trial.engine.dt
    seconds = trials * planned.seconds * WALL_RATIO / max(1, jobs)
    return Cost(trials=trials, seconds=seconds, size=trials * ticks * BYTES_PER_TICK)


def outlook(experiment: Experiment, store: Store) -> Outlook:
    """How every cell of an experiment stands, without running or writing anything."""
    planned, standing = plan(experiment), standings(store)
    cells: dict[int, Counter[Standing]] = {}
    values: dict[int, Mapping[str, object]] = {}
    for item in planned.trials():
        cells.setdefault(item.cell_index, Counter())[standing(item.trial.id)] += 1
        values.setdefault(item.cell_index, item.values)
    return Outlook(
        standings=[cells[index] for index in sorted(cells)],
        values=[values[index] for index in sorted(values)],
        trial_seconds=planned.seconds,
    )


def standings(store: Store) -> Callable[[str], Standing]:
    """How a trial stands in the store as it is now, by its id."""
    index = store.index()
    unreadable = {error.path.stem: error for error in index.unreadable}

    def standing(trial_id: str) -> Standing:
        entry = index.entries.get(trial_id)
        if entry is not None:
            return "failed before" if entry.state == "FAILED" else "cached"
        error = unreadable.get(trial_id)
        if error is not None and error.kind == "newer":
            raise StoreError(str(error)) from error
        return "new" if error is None else "damaged"

    return standing
