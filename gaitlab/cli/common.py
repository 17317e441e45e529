"""What `run` shares with the commands that walk trials too: counts, limits and what comes next."""

from __future__ import annotations

import json
import shlex
from collections import Counter
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from gaitlab.cli.printing import DAY, columns, duration, number, plural, size, tell
from gaitlab.errors import UsageError

if TYPE_CHECKING:
    from gaitlab.experiment import Experiment
    from gaitlab.running import Cost, Outlook, Progress, Standing, Summary
    from gaitlab.running.dask_cluster import DaskCluster
    from gaitlab.store import Shard, Store

MANY_TRIALS = 100_000  # more need --yes
LONG = DAY  # s, an estimate beyond this needs --yes
INTERRUPTED, SOME_FAILED = 130, 4  # exit codes
SHOWN_REASONS = 5
MOST_JOBS = 1000  # processes; a slip of the finger beyond


def progress_of(quiet: bool, json_lines: bool) -> Progress:
    """What is called while trials run."""
    from gaitlab.cli.progress import JsonLines, progress

    return JsonLines() if json_lines else progress(quiet=quiet)


@cache
def tell_engine() -> None:
    """Say once what walks in place of the reference engine where that is not installed."""
    from gaitlab.simulation.engines import ENGINES, REFERENCE, default_engine

    if (engine := default_engine()) != REFERENCE:
        tell(
            f"{ENGINES[REFERENCE].package} is not installed here: what names no engine walks in "
            f"{engine}"
        )


def tell_compiling(experiment: Experiment) -> None:
    """Say why nothing seems to happen at first where an engine has to be compiled."""
    tell_cache()
    if "mujoco" not in experiment.engines:
        return
    from gaitlab.kinematics.compiled import is_kept

    if not is_kept("loop.advance"):
        tell("engine mujoco is compiled first, once on this machine, in half a minute or more")


@cache
def tell_cache() -> None:
    """Say once where machine code is kept if not where it should be."""
    from gaitlab.kinematics.caches import NAMED, code_folder

    folder = code_folder()
    if folder.refused:
        where = f"in {folder.path}" if folder.path else "nowhere, so each process compiles anew"
        tell(
            f"what is compiled is kept {where}: {'; '.join(folder.refused)}. {NAMED}=DIR names "
            "another folder"
        )


def worker_count(jobs: int | None) -> int:
    """Worker processes that --jobs asks for, by default one for each processor there is to use.

    Raises:
        UsageError: If the number is negative or absurd.
    """
    if jobs is not None and not 0 <= jobs <= MOST_JOBS:
        raise UsageError(
            f"--jobs {jobs}: allowed is 0 (this process) or a number of processes up to {MOST_JOBS}"
        )
    from gaitlab.running import processors

    return processors() if jobs is None else jobs


def cluster_of(dask: str | None, jobs: int | None, shared: bool) -> DaskCluster | None:
    """The cluster that --dask asks for; nothing is started yet. None without it.

    Raises:
        UsageError: If another option does not go with it, or nothing of its form is there.
        WrongValue: If Dask is not installed.
        FileError: If the file for SLURM is wrong.
    """
    if dask is None:
        if not shared:
            raise UsageError("--no-shared-store: without --dask nothing walks elsewhere")
        return None
    if dask == "local" and jobs == 0:
        raise UsageError("--jobs 0: a cluster of this machine needs a worker; -j 1 or more")
    if dask != "local" and jobs is not None:
        raise UsageError(
            f"--jobs {jobs}: with --dask {dask} as many trials walk at a time as the cluster has "
            "workers; leave -j out"
        )
    from gaitlab.running.dask_cluster import DaskCluster

    return DaskCluster(dask, jobs=max(1, worker_count(jobs)), shared=shared)


def refuse_quick(experiment: str, quick: bool) -> None:
    """Refuse a short form of what has none.

    Raises:
        UsageError: If it is asked for.
    """
    if quick:
        raise UsageError(
            f"--quick: {experiment} is no reproduction and has no short form; give it fewer seeds "
            "with --seeds N"
        )


def refuse_large(needed: Cost, yes: bool) -> None:
    """Refuse what takes more than a day unless the user knows.

    Raises:
        UsageError: If it does.
    """
    if yes or (needed.trials <= MANY_TRIALS and needed.seconds <= LONG):
        return
    raise UsageError(
        f"this plan has {needed.trials:,} trials: up to {duration(needed.seconds)} and "
        f"{size(needed.size)} of logs. Shorten the grid or the seeds, or confirm with --yes."
    )


def share_of(trials: int, shard: Shard | None) -> int:
    """Trials of a shard, of an experiment of so many."""
    return trials if shard is None else -(-trials // shard.count)


def summary_text(summary: Summary, arguments: str, shard: Shard | None = None) -> str:
    """The counts of a run in words, and the command that comes next."""
    whole = arguments
    arguments += f" --shard {shard}" if shard else ""
    counts = f"{plural(summary.planned, 'trial')}: {summary.cached} cached, {summary.done} done, "
    counts += f"{summary.infeasible} infeasible, {summary.failed} failed"
    counts += f", {summary.left} left" if summary.left else ""
    early = f", in {summary.fell_standing} before its first step" if summary.fell_standing else ""
    falls = f"The robot fell in {summary.falls} of them{early}. {duration(summary.seconds)}"
    if summary.left:
        return f"{counts}. {falls}\nGo on: gaitlab run {arguments}"
    if summary.planned and summary.failed == summary.planned:
        return f"{counts}. {falls}\nTry again: gaitlab run {arguments} --retry-failed"
    if shard:
        return f"{counts}. {falls}\nWhen all shards have ended: gaitlab run {whole}"
    return f"{counts}. {falls}\nReport: gaitlab report {arguments}"


def arguments_of(
    experiment: str,
    settings: Sequence[str] | None,
    seeds: int | None,
    store: Path,
    *,
    quick: bool = False,
) -> str:
    """What makes another command mean the same trials."""
    parts = [experiment, *(["--quick"] if quick else [])]
    parts += [*(part for setting in settings or () for part in ("--set", setting))]
    parts += ["--seeds", str(seeds)] if seeds is not None else []
    from gaitlab.experiment.shell import store_option

    return shlex.join([*parts, *store_option(store)])


def tell_reasons(results: Store, name: str, summary: Summary) -> None:
    """Why trials have no result, each reason once, with a trial to look at."""
    from gaitlab.experiment.shell import store_option
    from gaitlab.running.executor import TIMED_OUT

    if not summary.failed and not summary.infeasible:
        return
    entries = results.index().entries
    wanted = [
        entries[t.trial_id] for t in results.experiments()[name].trials if t.trial_id in entries
    ]
    for state in ("INFEASIBLE", "FAILED"):
        groups: dict[str, list[str]] = {}
        for entry in wanted:
            if entry.state == state:
                reason = entry.reason.partition("\n")[0]
                groups.setdefault(reason, []).append(entry.trial_id)
        for reason, ids in list(groups.items())[:SHOWN_REASONS]:
            found = f"{state.lower()}, {plural(len(ids), 'trial')}: {reason}"
            look = shlex.join(["gaitlab", "show", ids[0][:8], *store_option(results.path)])
            tell(f"{found} ({look})")
        if len(groups) > SHOWN_REASONS:
            tell(f"{state.lower()}: {len(groups) - SHOWN_REASONS} more reasons")
    late = sum(e.state == "FAILED" and e.reason.startswith(TIMED_OUT) for e in wanted)
    if late:
        tell("Trials that timed out are run again by the same command; -j N takes fewer workers.")
    if summary.failed > late:
        tell("`--retry-failed` runs failed trials again.")


LONGEST_TABLE = 30  # cells of a plan that are listed; more are summed up
SHOWN_VALUES = 12  # of a path in such a sum


def plan_text(found: Outlook, needed: Cost, retry_failed: bool, as_json: bool) -> str:
    """The plan as a table, a row a cell and a reason for everything that would run."""
    if as_json:
        return json.dumps(plan_object(found, needed))
    short = len(found.standings) <= LONGEST_TABLE
    table = _every_cell(found, retry_failed) if short else _cells_by_reason(found, retry_failed)
    total = f"{plural(found.planned, 'trial')} in {plural(len(found.standings), 'cell')}: "
    total += f"{found.count('cached')} cached, {needed.trials} to run, "
    total += f"up to {duration(needed.seconds)} and {size(needed.size)}"
    code = [f"this experiment runs code of your own: {file}" for file in found.own_code]
    return "\n".join([f"{table}\n\n{total}", *code])


def plan_object(found: Outlook, needed: Cost) -> dict[str, object]:
    """What a plan is for machines."""
    before = ("new", "file damaged", "failed before", "timed out before")
    counts = {**dict.fromkeys(before, 0), **found.due(True)}
    return {
        "planned": found.planned,
        "cached": found.count("cached"),
        "to_run": {stand.replace(" ", "_"): count for stand, count in counts.items()},
        "seconds": round(needed.seconds),
        "bytes": round(needed.size),
    }


def _every_cell(found: Outlook, retry_failed: bool) -> str:
    paths = list(found.values[0]) if found.values else []
    rows = [
        [*(number(values[path]) for path in paths), *_standing_cells(standing, retry_failed)]
        for values, standing in zip(found.values, found.standings, strict=True)
    ]
    return columns([*paths, "cached", "to run", "why"], rows)


def _cells_by_reason(found: Outlook, retry_failed: bool) -> str:
    """What is varied, and how many cells stand how: a long plan in a few lines."""
    varied = [[path, _values(found, path)] for path in found.values[0]]
    stands = [tuple(_standing_cells(standing, retry_failed)) for standing in found.standings]
    rows = [[str(count), *stand] for stand, count in Counter(stands).items()]
    head = ("cells", "cached in each", "to run in each", "why")
    return f"{columns(('varied', 'values'), varied)}\n\n{columns(head, rows)}"


def _values(found: Outlook, path: str) -> str:
    """The values of a path, those in the middle left out when they are many."""
    if path in found.swept:
        return found.swept[path]
    values = list(dict.fromkeys(number(cell[path]) for cell in found.values))
    if len(values) > SHOWN_VALUES:
        half = SHOWN_VALUES // 2
        values = [*values[:half], f"... {len(values) - 2 * half} more ...", *values[-half:]]
    return ", ".join(values)


def _standing_cells(standing: Mapping[Standing, int], retry_failed: bool) -> list[str]:
    due = {
        stand: count
        for stand, count in standing.items()
        if stand != "cached" and (retry_failed or stand != "failed before")
    }
    reasons = [stand if len(due) == 1 else f"{count} {stand}" for stand, count in due.items()]
    if standing.get("failed before") and not retry_failed:
        reasons.append(f"{standing['failed before']} failed before, left (--retry-failed)")
    return [str(standing.get("cached", 0)), str(sum(due.values())), ", ".join(reasons)]
