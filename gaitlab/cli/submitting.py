"""`gaitlab submit`: an experiment as an array of SLURM jobs."""

from __future__ import annotations

import os
import shlex
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gaitlab.cli.common import arguments_of, refuse_large, refuse_quick, tell_engine
from gaitlab.cli.options import (
    DEFAULT_STORE,
    Engine,
    ExperimentName,
    Quick,
    Seeds,
    Settings,
    StoreFolder,
    with_engine,
)
from gaitlab.cli.printing import duration, other_output_on_stderr, plural, say, tell
from gaitlab.errors import UsageError

if TYPE_CHECKING:
    from gaitlab.experiment import Experiment
    from gaitlab.running.slurm import Division
    from gaitlab.store import Store

MOST_CPUS = 1000  # of a task; a slip of the finger beyond


def submit(
    experiment: ExperimentName,
    shards: Annotated[
        int | None,
        typer.Option(
            "--shards",
            metavar="N",
            help="Tasks of the array; by default as many as take about 20 minutes each.",
        ),
    ] = None,
    time: Annotated[
        str | None,
        typer.Option(
            "--time",
            metavar="LIMIT",
            help="How long a task may take, as for sbatch; by default three times what is "
            "expected.",
        ),
    ] = None,
    cpus: Annotated[
        int, typer.Option("--cpus", metavar="N", help="Cores, and workers, of a task.")
    ] = 1,
    mem: Annotated[
        str | None, typer.Option("--mem", metavar="SIZE", help="Memory of a task, 4G for instance.")
    ] = None,
    partition: Annotated[
        str | None, typer.Option("--partition", metavar="NAME", help="Where it is queued.")
    ] = None,
    account: Annotated[
        str | None, typer.Option("--account", metavar="NAME", help="Who is charged.")
    ] = None,
    sbatch: Annotated[
        list[str] | None,
        typer.Option(
            "--sbatch",
            metavar="OPTION",
            help="Another option of sbatch, --sbatch=--exclusive for instance; may be repeated.",
        ),
    ] = None,
    dry_run: Annotated[
        bool, typer.Option("-n", "--dry-run", help="Print the script; submit nothing.")
    ] = False,
    seeds: Seeds = None,
    settings: Settings = None,
    engine: Engine = None,
    store: StoreFolder = DEFAULT_STORE,
    quick: Quick = False,
    yes: Annotated[
        bool, typer.Option("--yes", help="Submit even if a task takes more than a day.")
    ] = False,
) -> int:
    """Submit an experiment, or a reproduction, to SLURM: an array of shards, then the report.

    Prints the ids of both jobs. The same command again submits the shards with something left.

    \b
    Example:
      gaitlab submit eros_table7 --seeds 20 --partition short
      gaitlab submit eros_table7 --seeds 20 --dry-run
    """
    from gaitlab.experiment.shell import store_option
    from gaitlab.running import slurm
    from gaitlab.store import Store

    options = _options(partition, account, mem, sbatch or ())
    _require_count("--cpus", cpus, MOST_CPUS)
    if shards is not None:
        _require_count("--shards", shards, slurm.MOST_TASKS)
    limit = None if time is None else slurm.limit_seconds(time)
    if not dry_run:
        slurm.require_sbatch()
    settings = with_engine(settings, engine)
    with other_output_on_stderr():
        name, members = _members(experiment, settings, seeds, quick)
        refuse_large(slurm.whole(members, tasks=shards or slurm.MOST_TASKS, cpus=cpus), yes)
        results = Store(store)
        divided = slurm.division(members, results, wanted=shards, cpus=cpus)
    tell_engine()
    folder = Path(os.path.abspath(results.folder_of(name) / slurm.FOLDER))
    output = slurm.output_in(folder)
    arguments = arguments_of(experiment, settings, seeds, store, quick=quick)
    if not divided.due:
        tell(f"all trials of {name} are in {store} already. Report: gaitlab report {arguments}")
        return 0
    refuse_large(divided.each, yes)
    _tell_fit(divided, shards, limit, time)
    if not dry_run:
        _share_out(members, results, divided.count)
        divided = slurm.division(members, results, wanted=divided.count, cpus=cpus)
    job = slurm.ArrayJob(
        name=name,
        summary=f"{name}: {_division_text(divided, cpus)}. Written by `gaitlab submit`.",
        cwd=Path.cwd(),
        program=_program(),
        arguments=arguments,
        shards=divided.count,
        tasks=divided.tasks,
        folder=folder,
        output=output,
        cpus=cpus,
        limit=(time or "").strip() or slurm.limit_for(divided.each.seconds),
        options=options,
    )
    if dry_run:
        say(job.script().rstrip())
        return 0
    array, last = slurm.submit(job, results)
    known = members[0].listed_as if len(members) == 1 else experiment
    tell(f"{name}: {_division_text(divided, cpus)}, in the array {array}")
    tell(f"then {last}, which runs what the shards left and writes the report; {job.file}")
    tell(f"How far it is: {shlex.join(['gaitlab', 'status', known, *store_option(store)])}")
    tell(f"In the queue: squeue --jobs={array},{last}")
    say(f"{array}\n{last}")
    return 0


def _members(
    experiment: str, settings: Sequence[str], seeds: int | None, quick: bool
) -> tuple[str, Sequence[Experiment]]:
    """What is listed under which name: an experiment, or those of a reproduction.

    Raises:
        NoEngine: If an engine that one of them asks for is not installed.
        UsageError: If it is a study.
    """
    from gaitlab.experiment import is_reproduction, load_experiment
    from gaitlab.simulation.engines import require_engine

    if is_reproduction(experiment):
        from gaitlab.papers.reproduction import load_reproduction

        whole = load_reproduction(experiment, quick=quick, settings=settings, seeds=seeds)
        name, members = whole.name, whole.members
    else:
        refuse_quick(experiment, quick)
        wanted = load_experiment(experiment, settings, seeds)
        _refuse_study(wanted)
        name, members = wanted.listed_as, (wanted,)
    for engine in dict.fromkeys(engine for member in members for engine in member.engines):
        require_engine(engine)
    return name, members


def _refuse_study(experiment: Experiment) -> None:
    """Refuse what cannot be shared out beforehand.

    Raises:
        UsageError: If it is a study.
    """
    if experiment.study is not None:
        raise UsageError(
            f"{experiment.name} is a study: what it tries next hangs on what was tried, so it has "
            "no shards. Several jobs search together with `gaitlab optimize --storage URL`, one "
            "database for all of them, or one search has its workers on a cluster with --dask"
        )


def _share_out(members: Sequence[Experiment], results: Store, count: int) -> None:
    """Have the walks written that programs write, and keep whose trial is whose."""
    from gaitlab.experiment.plan import plan
    from gaitlab.running.sweep import share_out

    for member in members:
        for command in plan(member, programs=False).written_by:
            tell(f"walks that are not written yet are now, by {command}")
    with other_output_on_stderr():
        for member in members:
            plan(member).write_walks()
            share_out(member, results, count)


def _tell_fit(divided: Division, shards: int | None, limit: int | None, time: str | None) -> None:
    """Say how many shards there are if nobody asked, or if others would fit better."""
    from gaitlab.running.slurm import LONGEST, SHORTEST

    each, count = divided.each.seconds, divided.count
    if shards is not None and count < shards:
        tell(f"--shards {shards}: there are {plural(divided.planned, 'trial')}, so {count} it is")
    if shards is not None and not SHORTEST <= each <= LONGEST and divided.fitting != count:
        tell(
            f"--shards {count}: a shard takes up to {duration(each)}, and a queue is served best "
            f"with 10 to 30 min; --shards {divided.fitting} would fit"
        )
    if limit is not None and limit < each:
        tell(
            f"--time {time}: a shard may take up to {duration(each)}; what is cut off is left to "
            "the last job, and to the same command again"
        )


def _division_text(divided: Division, cpus: int) -> str:
    tasks, count = len(divided.tasks), divided.count
    some = plural(count, "shard") if tasks == count else f"{tasks} of {count} shards"
    cores = plural(cpus, "core")
    return (
        f"{plural(divided.due, 'trial')} to run in {some}, each up to "
        f"{duration(divided.each.seconds)} on {cores}"
    )


def _options(
    partition: str | None, account: str | None, mem: str | None, others: Sequence[str]
) -> list[str]:
    """Options of sbatch, each as it stands in the script.

    Raises:
        UsageError: If one is empty, has several lines or is no amount of memory.
    """
    from gaitlab.running.slurm import line, require_memory

    if mem is not None:
        require_memory(mem)
    given = {"--partition": partition, "--account": account, "--mem": mem}
    named = [line(option, text) for option, text in given.items() if text is not None]
    return [*named, *(line("", text) for text in others)]


def _require_count(option: str, number: int, most: int) -> None:
    """Refuse a number out of range.

    Raises:
        UsageError: Says the range.
    """
    if not 1 <= number <= most:
        raise UsageError(f"{option} {number}: allowed are 1 to {most:,}")


def _program() -> list[str]:
    """What starts this gaitlab wherever its files are seen: the command itself, or its Python."""
    command = Path(sys.argv[0])
    if command.name == "gaitlab" and os.access(command, os.X_OK):
        return [os.path.abspath(command)]
    return [sys.executable, "-m", "gaitlab"]
