"""`cluster.yaml`: what `--dask slurm` asks SLURM for.

workers: 32            # trials that run at the same time
cores: 8               # of each job, one worker a core
memory: 16 GB          # of each job
walltime: "02:00:00"   # of each job
partition: lab
account: robots
sbatch: ["--constraint=fast"]
prologue: ["source ~/gaitlab/bin/activate"]
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from math import ceil
from pathlib import Path

from gaitlab.documents import Node, build, load
from gaitlab.errors import FileError, Problem
from gaitlab.parameters import parameter

USUAL = Path("cluster.yaml")  # in the working directory
WALLTIME = re.compile(r"(?:(?:(\d{1,3})-)?(\d{1,3}):)?([0-5]?\d):([0-5]\d)")  # D-HH:MM:SS
MEMORY = re.compile(r"\d+(?:\.\d+)? ?[KMGT]i?B")
ONE_LINE = re.compile(r"[^\n\r]*")
DAY, HOUR, MINUTE = 86400, 3600, 60  # s
SHORTEST = 2 * MINUTE  # s of a walltime; less ends before a worker is of use
MARGIN = 0.1  # of the walltime, in which a worker ends by itself, each at an instant of its own
LONGEST_MARGIN = 600  # s


@dataclass(frozen=True, kw_only=True)
class ClusterFile:
    """Jobs of a batch system, each with some workers."""

    workers: int = parameter(
        unit="-", low=1, high=10_000, doc="trials that run at the same time", source="yours"
    )
    cores: int = parameter(
        1, unit="-", low=1, high=1024, doc="cores of a job, one worker each", source="one"
    )
    memory: str = parameter(unit="-", doc="memory of a job, for instance 16 GB", source="yours")
    walltime: str = parameter(
        unit="-", doc="longest time of a job as HH:MM:SS or D-HH:MM:SS", source="yours"
    )
    partition: str = parameter("", unit="-", doc="queue of the jobs", source="the site's default")
    account: str = parameter("", unit="-", doc="who pays", source="the site's default")
    interface: str = parameter(
        "", unit="-", doc="network over which workers reach this machine, ib0 for instance",
        source="that of this machine's name",
    )  # fmt: skip
    sbatch: tuple[str, ...] = parameter(
        (), unit="-", doc="more options of sbatch, for instance --constraint=fast", source="none"
    )
    prologue: tuple[str, ...] = parameter(
        (), unit="-", doc="lines of the shell before a worker starts", source="none"
    )
    logs: str = parameter(
        "cluster-logs", unit="-", doc="folder for what the jobs print", source="beside the results"
    )

    @property
    def jobs(self) -> int:
        """Jobs that are needed for so many workers."""
        return ceil(self.workers / self.cores)

    @property
    def seconds(self) -> int:
        """The walltime, in [s]."""
        found = WALLTIME.fullmatch(self.walltime)
        assert found is not None, "it was checked"
        days, hours, minutes, seconds = (int(part or 0) for part in found.groups())
        return DAY * days + HOUR * hours + MINUTE * minutes + seconds

    @property
    def margin(self) -> int:
        """Time before the walltime in which workers end by themselves, in [s]."""
        return min(LONGEST_MARGIN, ceil(MARGIN * self.seconds))


def read_cluster_file(path: Path) -> ClusterFile:
    """What a file asks for.

    Raises:
        FileError: Everything that is wrong in it, with line and column.
    """
    root = load(path)
    asked = build(ClusterFile, root, skip=())
    problems = list(_problems(asked, root))
    if problems:
        raise FileError(problems)
    return asked


def _problems(asked: ClusterFile, root: Node) -> list[Problem]:
    problems = []
    if not WALLTIME.fullmatch(asked.walltime) or asked.seconds < SHORTEST:
        problems.append(
            root.mapping["walltime"].problem(
                f"walltime: found {asked.walltime!r}; write hours, minutes and seconds, "
                f'"02:00:00", or days before them, "1-12:00:00"; at least {SHORTEST // MINUTE} '
                "minutes"
            )
        )
    if not MEMORY.fullmatch(asked.memory):
        problems.append(
            root.mapping["memory"].problem(
                f"memory: found {asked.memory!r}; write a number and its unit, 16 GB"
            )
        )
    for key in ("partition", "account", "interface"):
        if re.search(r"\s", getattr(asked, key)):
            found = root.mapping[key]
            problems.append(found.problem(f"{key}: found {found.found()}; expected a single word"))
    for key in ("sbatch", "prologue"):
        for item in root.mapping[key].items if key in root.mapping else ():
            if not ONE_LINE.fullmatch(str(item.value)):
                problems.append(item.problem(f"{key}: more than one line; write an item for each"))
    return problems
