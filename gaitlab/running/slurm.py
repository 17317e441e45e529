"""An experiment as a SLURM array: the batch script as text, and what sbatch says to it.

SLURM shares out, starts again and waits; here is only what it is asked for. The script needs nobody
but sbatch: each task of its array runs one shard, and its task 0, started once the others have
ended, runs what they left and writes the report.
"""

from __future__ import annotations

import re
import shlex
import shutil
import subprocess
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from math import ceil
from operator import mul
from pathlib import Path

from gaitlab.errors import UsageError
from gaitlab.experiment import Experiment
from gaitlab.experiment.plan import plan
from gaitlab.running.outlook import Cost, cost, outlook
from gaitlab.store import ShardStatus, Store
from gaitlab.store.durable import write_durably

SHARD_SECONDS = 1200.0  # a queue is asked seldom, and a shard that is lost costs little
SHORTEST, LONGEST = 600.0, 1800.0  # s of a shard that a queue and its users bear well
MOST_TASKS = 1000  # of an array, as SLURM is set up where nobody has changed it
FOLDER, SCRIPT = "slurm", "submit.sh"  # in the folder of the experiment in the store
LAST = 0  # task that comes after the others
SPARE, SHORTEST_LIMIT, LIMIT_STEP = 3, 1800, 600  # a limit in s, for slower machines than ours
MINUTE, HOUR, DAY = 60, 3600, 86400

_LIMIT = re.compile(r"(?:(\d+)-)?(\d+)(?::(\d+))?(?::(\d+))?", re.ASCII)
_MEMORY = re.compile(r"\d+[KMGT]?", re.ASCII | re.IGNORECASE)
_WORD = re.compile(r"[\w.,:@%+=/-]+", re.ASCII)  # sbatch reads it as it stands
_PREFIX = re.compile(r"sbatch: (error: )?")
_JOB = re.compile(r"(\d+)(;.*)?", re.ASCII)  # a cluster of several adds its name


@dataclass(frozen=True, kw_only=True)
class ArrayJob:
    """What a batch script is written from.

    Attributes:
        name: Of the experiment or reproduction, and of the job.
        summary: What it runs, in a sentence.
        cwd: Folder in which the command was typed.
        program: What starts gaitlab: an absolute path, perhaps with arguments.
        arguments: Of `gaitlab run` and `gaitlab report`, quoted for a shell.
        shards: Into how many the experiment is shared out.
        tasks: Numbers of those that have something left, from 1.
        folder: Where the script and what its tasks print belong.
        output: File that a task prints to, see `output_in`.
        cpus: Cores of a task.
        limit: How long a task may take, as SLURM writes it.
        options: Further options of sbatch, each as it is typed.
    """

    name: str
    summary: str
    cwd: Path
    program: Sequence[str]
    arguments: str
    shards: int
    tasks: Collection[int]
    folder: Path
    output: str
    cpus: int
    limit: str
    options: Sequence[str] = ()

    @property
    def file(self) -> Path:
        """The script."""
        return self.folder / SCRIPT

    def script(self) -> str:
        """What it says."""
        options = [
            f"--job-name={self.name}",
            f"--array={_ranges(self.tasks)}",
            f"--cpus-per-task={self.cpus}",
            f"--time={self.limit}",
            f"--output={self.output}",
            "--open-mode=append",
            "--requeue",
            *self.options,
        ]
        run = f"{shlex.join(self.program)} run {self.arguments}"
        return _SCRIPT.format(
            summary=self.summary,
            folder=shlex.quote(str(self.folder)),
            file=shlex.quote(str(self.file)),
            options="\n".join(f"#SBATCH {option}" for option in options),
            cwd=shlex.quote(str(self.cwd)),
            shards=self.shards,
            run=run,
            report=f"{shlex.join(self.program)} report {self.arguments}",
        )


_SCRIPT = """\
#!/bin/bash
# {summary}
# By hand: the array, and then its task 0, which runs what the others left and writes the report.
#   mkdir -p {folder}
#   array=$(sbatch --parsable {file})
#   sbatch --dependency="afterany:${{array%;*}}" --array=0 {file}
{options}
set -euo pipefail
cd {cwd}

trap : TERM # this shell waits: gaitlab lets the trials that run come to their end

ended() {{ # trials that failed (4) are in the store with their reasons; no retry mends them
  (($1 == 4)) || exit "$1"
}}

echo "$(date) on $HOSTNAME: task $SLURM_ARRAY_TASK_ID, restart ${{SLURM_RESTART_COUNT:-0}}"
if ((SLURM_ARRAY_TASK_ID > 0)); then
  {run} --yes -j "$SLURM_CPUS_PER_TASK" --shard "$SLURM_ARRAY_TASK_ID/{shards}" || ended $?
else
  {run} --yes -j "$SLURM_CPUS_PER_TASK" || ended $?
  {report}
fi
"""


@dataclass(frozen=True, kw_only=True)
class Division:
    """How an experiment, or several that belong together, is divided among the tasks of an array.

    Attributes:
        planned: Trials in all.
        due: Those that are not in the store yet.
        count: Shards.
        tasks: Numbers of those that have something left, from 1.
        each: What one of these takes, on its own cores.
        fitting: How many shards would take about 20 minutes each.
    """

    planned: int
    due: int
    count: int
    tasks: tuple[int, ...]
    each: Cost
    fitting: int


def whole(experiments: Sequence[Experiment], *, tasks: int, cpus: int) -> Cost:
    """What all trials of experiments take each of so many tasks; counted without expanding."""
    plans = [plan(experiment, programs=False) for experiment in experiments]
    costs = [cost(planned, planned.size, tasks * cpus) for planned in plans]
    return Cost(
        trials=sum(needed.trials for needed in costs),
        seconds=sum(needed.seconds for needed in costs),
        size=sum(needed.size for needed in costs),
    )


def division(
    experiments: Sequence[Experiment], store: Store, *, wanted: int | None, cpus: int
) -> Division:
    """How experiments are divided; nothing is run or written.

    An experiment that is divided already keeps its shards, so that those that are done stay so.

    Args:
        experiments: Experiments whose shards are run together.
        store: What is there already.
        wanted: How many shards; None for as many as suit a queue. Never more than trials.
        cpus: Cores of a task.
    """
    plans = [plan(experiment, programs=False) for experiment in experiments]
    dues = [
        sum(outlook(experiment, store).due(retry_failed=False).values())
        for experiment in experiments
    ]
    costs = [cost(planned, due, cpus) for planned, due in zip(plans, dues, strict=True)]
    seconds = sum(needed.seconds for needed in costs)
    planned = sum(each.size for each in plans)
    fitting = max(1, min(planned, MOST_TASKS, round(seconds / SHARD_SECONDS)))
    statuses = _statuses(experiments, store)
    kept = {len(shards) for shards in statuses}
    count = min(planned, wanted or (max(kept) if len(kept) == 1 else 0) or fitting)
    tasks = _unfinished(statuses, count)
    each = Cost(
        trials=ceil(sum(dues) / len(tasks)),
        seconds=seconds / len(tasks),
        size=sum(needed.size for needed in costs) / len(tasks),
    )
    return Division(
        planned=planned, due=sum(dues), count=count, tasks=tasks, each=each, fitting=fitting
    )


def _statuses(experiments: Sequence[Experiment], store: Store) -> list[list[ShardStatus]]:
    """How far the shards are of each experiment that is shared out in the store as it is now."""
    lists, index = store.experiments(), store.index()
    known = (lists.get(experiment.listed_as) for experiment in experiments)
    return [
        store.shards(listed, index) if listed and listed.digest == experiment.digest else []
        for experiment, listed in zip(experiments, known, strict=True)
    ]


def _unfinished(statuses: Sequence[Sequence[ShardStatus]], count: int) -> tuple[int, ...]:
    """Numbers of the shards with something left in any experiment; all of them if none has."""
    every = range(1, count + 1)
    if any(len(shards) != count for shards in statuses):
        return tuple(every)
    left = {status.shard.number for shards in statuses for status in shards if status.left}
    return tuple(sorted(left) or every)


def limit_for(seconds: float) -> str:
    """A limit of time for a task that takes up to this long, in [s], on a machine like ours."""
    limit = max(SHORTEST_LIMIT, ceil(SPARE * seconds / LIMIT_STEP) * LIMIT_STEP)
    days, rest = divmod(limit, DAY)
    clock = f"{rest // HOUR:02}:{rest % HOUR // MINUTE:02}:00"
    return f"{days}-{clock}" if days else clock


def limit_seconds(limit: str) -> int:
    """What a limit of time means, in [s].

    Args:
        limit: In a form of SLURM's: `90` (minutes), `90:00`, `1:30:00`, `1-12`, `1-12:30:00`.

    Raises:
        UsageError: If it is none, or no time at all.
    """
    found, seconds = _LIMIT.fullmatch(limit.strip()), 0
    if found:
        days, clock = int(found[1] or 0), [int(text) for text in found.groups()[1:] if text]
        units = [HOUR, MINUTE, 1]
        first = 0 if found[1] or len(clock) == len(units) else 1
        seconds = days * DAY + sum(map(mul, clock, units[first:]))
    if not seconds:
        raise UsageError(
            f"--time {limit}: allowed is what SLURM takes for a limit of time: minutes (`90`), "
            "`1:30:00`, or days and hours (`1-12`, `1-12:30:00`)"
        )
    return seconds


def require_memory(memory: str) -> None:
    """Refuse what is no amount of memory.

    Raises:
        UsageError: Says what is one.
    """
    if not _MEMORY.fullmatch(memory):
        raise UsageError(f"--mem {memory}: allowed is a whole number with K, M, G or T, as in 4G")


def output_in(folder: Path) -> str:
    """What a task prints to in a folder; SLURM fills in its job and number.

    Raises:
        UsageError: If SLURM would take the folder for another.
    """
    text = str(folder)
    if "\\" in text or len(text.splitlines()) != 1:
        raise UsageError(
            f"{text!r}: SLURM cannot write to a folder with a backslash or a line break in its "
            "name; choose another with --store DIR"
        )
    pattern = f"{text.replace('%', '%%')}/%A_%a.out"
    return pattern if _WORD.fullmatch(pattern) else _quoted(pattern)


def line(option: str, text: str) -> str:
    """An option of sbatch for a script, in which it stands on one line.

    Args:
        option: Name of the option; empty if the text holds it, written as it is to stand there.
        text: Its value.

    Raises:
        UsageError: If there is none, or it has several lines.
    """
    told = option or "--sbatch"
    if len(text.splitlines()) != 1 or not text.strip() or not (option or text.startswith("-")):
        example = "a name" if option else "an option of sbatch, `--sbatch=--exclusive` for instance"
        raise UsageError(f"{told} {text!r}: give {example}, on one line")
    return f"{option}={text if _WORD.fullmatch(text) else _quoted(text)}" if option else text


def submit(job: ArrayJob, store: Store) -> tuple[str, str]:
    """Keep the script in the store, and give it to sbatch: the array, and the task that ends it.

    Returns:
        Job ids of both.

    Raises:
        StoreError: If the script cannot be written.
        UsageError: If sbatch is not there or refuses; in its own words.
    """
    sbatch = require_sbatch()
    text = job.script()
    write_durably(store.folder_of(job.name) / FOLDER / SCRIPT, text.encode(), within=store.path)
    array = _submitted([sbatch, "--parsable", str(job.file)])
    dependency = f"--dependency=afterany:{array}"
    try:
        last = _submitted([sbatch, "--parsable", dependency, f"--array={LAST}", str(job.file)])
    except UsageError as error:
        raise UsageError(
            f"the array {array} is submitted; the job that ends it is not: {error}. When the array "
            f"has ended: gaitlab run {job.arguments}"
        ) from error
    return array, last


def require_sbatch() -> str:
    """Path of sbatch.

    Raises:
        UsageError: If there is none.
    """
    if sbatch := shutil.which("sbatch"):
        return sbatch
    raise UsageError(
        "sbatch is not on the PATH: submit where SLURM's commands are, on a cluster's login node "
        "for instance. --dry-run prints the script, for `sbatch` there; without SLURM, "
        "`gaitlab run ... --shard I/N` runs a share by any other means"
    )


def _submitted(command: Sequence[str]) -> str:
    """Id of the job that sbatch accepts.

    Raises:
        UsageError: If it does not.
    """
    done = subprocess.run(command, capture_output=True, text=True, errors="replace", check=False)
    ids = [found[1] for line in done.stdout.splitlines() if (found := _JOB.fullmatch(line.strip()))]
    if done.returncode or not ids:
        lines = [_PREFIX.sub("", line) for line in f"{done.stderr}\n{done.stdout}".splitlines()]
        words = "; ".join(line for line in lines if line.strip())
        raise UsageError(f"sbatch refuses: {words or f'exit code {done.returncode}'}")
    return ids[-1]


def _ranges(numbers: Collection[int]) -> str:
    """Numbers as an array of SLURM's has them, `1-4,7`."""
    runs: list[list[int]] = []
    for number in sorted(numbers):
        if runs and number == runs[-1][-1] + 1:
            runs[-1].append(number)
        else:
            runs.append([number])
    return ",".join(f"{run[0]}-{run[-1]}" if len(run) > 1 else str(run[0]) for run in runs)


def _quoted(text: str) -> str:
    """As sbatch reads it in a script: in double quotes, not as a shell does."""
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'
