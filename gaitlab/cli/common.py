"""What `run` shares with the commands that walk trials too: counts, limits and what comes next."""

from __future__ import annotations

import os
import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from gaitlab.cli.printing import DAY, duration, plural, size, tell
from gaitlab.errors import UsageError

if TYPE_CHECKING:
    from gaitlab.running import Cost, Progress, Summary
    from gaitlab.store import Store

MANY_TRIALS = 100_000  # more need --yes
LONG = DAY  # s, an estimate beyond this needs --yes
INTERRUPTED, SOME_FAILED = 130, 4  # exit codes
SHOWN_REASONS = 5
MOST_JOBS = 1000  # processes; a slip of the finger beyond


def told_of(quiet: bool, json_lines: bool) -> Progress:
    """Who is told of what happens meanwhile."""
    from gaitlab.cli.events import JsonLines
    from gaitlab.cli.progress import progress

    return JsonLines() if json_lines else progress(quiet=quiet)


def worker_count(jobs: int | None) -> int:
    """Worker processes that --jobs asks for, one a core by default.

    Raises:
        UsageError: If the number is negative or absurd.
    """
    if jobs is not None and not 0 <= jobs <= MOST_JOBS:
        raise UsageError(
            f"--jobs {jobs}: allowed is 0 (this process) or a number of processes up to {MOST_JOBS}"
        )
    return _cores() if jobs is None else jobs


def _cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


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


def summary_text(summary: Summary, arguments: str) -> str:
    """The counts of a run in words, and the command that comes next."""
    counts = f"{plural(summary.planned, 'trial')}: {summary.cached} cached, {summary.done} done, "
    counts += f"{summary.infeasible} infeasible, {summary.failed} failed"
    counts += f", {summary.left} left" if summary.left else ""
    early = f", in {summary.fell_standing} before its first step" if summary.fell_standing else ""
    falls = f"The robot fell in {summary.falls} of them{early}. {duration(summary.seconds)}"
    if summary.left:
        return f"{counts}. {falls}\nGo on: gaitlab run {arguments}"
    if summary.failed == summary.planned:
        return f"{counts}. {falls}\nTry again: gaitlab run {arguments} --retry-failed"
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
    if summary.failed:
        tell("`--retry-failed` runs failed trials again.")
