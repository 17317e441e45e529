"""Processor time: how much of it there is for this process, and what another process does with it.

A machine shows all its cores to whoever asks, also to a process that may use two of them, or a
fifth of one. A container and a batch system limit by groups (cgroups) and by masks; both are read
here. And where many share little, the time on the clock says nothing of a process: how long it has
worked does, and whether it waits for a processor or for nothing.
"""

from __future__ import annotations

import math
import os
import re
import sys
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

SLURM = "SLURM_CPUS_PER_TASK"  # what `--cpus-per-task` has asked for
LOOK = 5.0  # s, the longest between two looks at a process
NOTHING = 1.0  # s of work by the way in which a process that only waits looks whether it may go on
_LEADER = 2  # clock of a process by its id, linux/posix-timers.h: CPUCLOCK_SCHED
_CLOCK_BITS = 3


def processors(root: Path = Path("/"), environment: Mapping[str, str] | None = None) -> int:
    """How many processes at a time make sense here, at least 1.

    The least of the cores that this process may run on (its affinity), the quota of its control
    groups, a part of a core counted as one, and what SLURM has given to the task.

    Args:
        root: Where `proc` and the control groups are mounted.
        environment: Variables; those of this process by default.
    """
    given = (os.environ if environment is None else environment).get(SLURM, "")
    cores = (
        len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    )
    asked = int(given) if given.isascii() and given.isdigit() else 0
    least = min(cores, quota(root), asked or math.inf)
    return max(1, math.ceil(least))


def quota(root: Path = Path("/")) -> float:
    """Processors that the control groups of this process allow, `inf` where none limits.

    Every group counts from the process' own up to the topmost that can be seen: version 2 and
    version 1, as the host sees them or from inside a container.

    Args:
        root: Where `proc` and the control groups are mounted.
    """
    folders = [group for mount in _mounts(root) for group in mount.groups(root)]
    return min((_allowed(folder) for folder in folders), default=math.inf)


@dataclass(frozen=True, kw_only=True)
class _Mount:
    """A mounted tree of control groups.

    Attributes:
        top: The group that is mounted, as the process' own is named.
        point: Where, absolute.
        own: The process' own group.
    """

    top: str
    point: str
    own: str

    def groups(self, root: Path) -> Iterator[Path]:
        """Folders of the own group and of those above it, as far as they are mounted."""
        top = root / self.point.lstrip("/")
        path = os.path.relpath(self.own, self.top)
        outside = path.split("/")[0] == ".."
        own = top if outside else top / path  # what is outside is seen as the top, or not at all
        yield from (folder for folder in (own, *own.parents) if folder.is_relative_to(top))


def _mounts(root: Path) -> Iterator[_Mount]:
    """Trees that can limit processor time, from `proc/self`; none where there is no such file."""
    own = dict[str, str]()
    for line in _lines(root / "proc/self/cgroup"):
        _, _, rest = line.partition(":")
        controllers, _, path = rest.partition(":")
        own.update(dict.fromkeys(controllers.split(","), path))  # version 2 names no controller
    for line in _lines(root / "proc/self/mountinfo"):
        before, _, after = line.partition(" - ")
        fields, kinds = before.split(), after.split()
        if len(fields) < 5 or not kinds:
            continue
        options = kinds[-1].split(",")
        controller = {"cgroup2": "", "cgroup": "cpu"}.get(kinds[0])
        if controller is None or controller not in own or (controller and "cpu" not in options):
            continue
        yield _Mount(top=_plain(fields[3]), point=_plain(fields[4]), own=own[controller])


def _plain(path: str) -> str:
    """A path of `mountinfo`, in which blanks are written as octal numbers."""
    return re.sub(r"\\([0-7]{3})", lambda found: chr(int(found[1], 8)), path)


def _allowed(group: Path) -> float:
    """Processors that a control group allows, `inf` for as many as there are."""
    both = " ".join(_lines(group / "cpu.max")[:1]).split()
    if not both:
        names = ("cpu.cfs_quota_us", "cpu.cfs_period_us")
        both = [word for name in names for word in _lines(group / name)[:1]]
    try:
        allowed, period = map(float, both)
    except ValueError:  # `max`, or no such files: the topmost group has none
        return math.inf
    return allowed / period if allowed > 0.0 and period > 0.0 else math.inf


def _lines(file: Path) -> list[str]:
    try:
        return file.read_text(errors="replace").splitlines()
    except OSError:
        return []


@dataclass
class WorkClock:
    """How long another process has worked, and how long it has done nothing.

    On Linux work is the processor time of the process, and nothing is what is left of the time on
    the clock when its work and its waiting for a processor are taken away: it sleeps, waits for
    what never comes, or was stopped. A process on a starved machine waits, however little it gets.
    Elsewhere all time on the clock counts as work.

    Time in which nobody looked counts as little as can be: who watches was itself stopped
    (Ctrl-Z) or starved, and so perhaps was the process.

    Attributes:
        pid: The process, a child of this one that was not waited for yet.
        worked: Its work since `restart`, in [s].
        idle: How long it has done nothing at a stretch, in [s].
    """

    pid: int
    worked: float = 0.0
    idle: float = 0.0
    _last: _Reading = field(init=False)
    _busy: float = 0.0  # s worked since the stretch began

    def __post_init__(self) -> None:
        self._last = _reading(self.pid)

    def restart(self) -> None:
        """Count from now on."""
        self._last = _reading(self.pid)
        self.worked = self.idle = self._busy = 0.0

    def look(self) -> None:
        """Bring `worked` and `idle` up to date."""
        now, last = _reading(self.pid), self._last
        self._last = now
        passed = min(now.time - last.time, 2.0 * LOOK)
        if now.work is None or last.work is None:
            self.worked += passed
            return
        work = now.work - last.work
        self.worked += work
        self._busy += work
        if self._busy >= NOTHING:
            self._busy = self.idle = 0.0
            return
        waited = 0.0 if now.waited is None or last.waited is None else now.waited - last.waited
        if now.runnable and (work == 0.0 or now.waited is None):  # told only when it gets on
            waited = passed
        self.idle = max(0.0, self.idle + passed - work - waited)


@dataclass(frozen=True, kw_only=True)
class _Reading:
    """What the system says of a process.

    Attributes:
        time: When, in [s].
        work: Processor time of all its threads so far, in [s]; None where that is not told.
        waited: How long it has waited for a processor so far, in [s]; None where not told.
        runnable: Whether it runs or waits for a processor now.
    """

    time: float
    work: float | None = None
    waited: float | None = None
    runnable: bool = False


def _reading(pid: int) -> _Reading:
    now = time.monotonic()
    if sys.platform != "linux":
        return _Reading(time=now)
    try:
        work = time.clock_gettime(~pid << _CLOCK_BITS | _LEADER)
        state = Path(f"/proc/{pid}/stat").read_text(errors="replace").rpartition(")")[2].split()[0]
    except (OSError, IndexError):  # another kernel's proc, or none
        return _Reading(time=now)
    delays = " ".join(_lines(Path(f"/proc/{pid}/schedstat"))[:1]).split()
    waited = int(delays[1]) / 1e9 if len(delays) == 3 and int(delays[0]) else None
    return _Reading(time=now, work=work, waited=waited, runnable=state == "R")
