"""`gaitlab run`."""

from __future__ import annotations

import json
import os
import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gaitlab.cli.options import (
    DEFAULT_STORE,
    ExperimentName,
    Jobs,
    Quick,
    Quiet,
    Seeds,
    Settings,
    StoreFolder,
)
from gaitlab.cli.plan_text import plan_text
from gaitlab.cli.printing import (
    DAY,
    duration,
    other_output_on_stderr,
    plural,
    say,
    size,
    tell,
)
from gaitlab.errors import UsageError

if TYPE_CHECKING:
    from gaitlab.dispatch import Cost, Progress, Summary
    from gaitlab.store import Store

MANY_TRIALS = 100_000  # more need --yes
LONG = DAY  # s, an estimate beyond this needs --yes
INTERRUPTED, SOME_FAILED = 130, 4  # exit codes
SHOWN_REASONS = 5
MOST_JOBS = 1000  # processes; a slip of the finger beyond


def run(
    experiment: ExperimentName,
    dry_run: Annotated[
        bool, typer.Option("-n", "--dry-run", help="Say what would run, and why; run nothing.")
    ] = False,
    jobs: Jobs = None,
    seeds: Seeds = None,
    settings: Settings = None,
    store: StoreFolder = DEFAULT_STORE,
    retry_failed: Annotated[
        bool, typer.Option("--retry-failed", help="Run trials again that failed before.")
    ] = False,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print the counts as one JSON object.")
    ] = False,
    json_lines: Annotated[
        bool,
        typer.Option("--json-lines", help="Print every event as a JSON object, one a line."),
    ] = False,
    quick: Quick = False,
    quiet: Quiet = False,
    yes: Annotated[
        bool, typer.Option("--yes", help="Run even if it takes more than a day.")
    ] = False,
) -> int:
    """Simulate the trials of an experiment, or of a reproduction, that are not in the store yet.

    Killing it is safe at any time: the same command goes on from there.

    \b
    Example:
      gaitlab run eros_quick -j 2 --set gait.step_height=0.02
    """
    from gaitlab.dispatch import cost, dispatch, outlook
    from gaitlab.experiment import is_reproduction, load_experiment, refuse_study
    from gaitlab.plan import plan
    from gaitlab.store import Store

    results, workers = Store(store), worker_count(jobs)
    if is_reproduction(experiment):
        from gaitlab.cli.reproducing import Asked, run_members
        from gaitlab.reproduction import load_reproduction

        with other_output_on_stderr():
            whole = load_reproduction(experiment, quick=quick, settings=settings or (), seeds=seeds)
        again = arguments_of(experiment, settings, seeds, store, quick=quick)
        asked = Asked(
            workers=workers,
            retry_failed=retry_failed,
            as_json=as_json,
            json_lines=json_lines,
            quiet=quiet,
            yes=yes,
            again=again,
        )
        return run_members(whole, results, asked, dry_run=dry_run)
    refuse_quick(experiment, quick)
    with other_output_on_stderr():
        wanted = load_experiment(experiment, settings or (), seeds)
    refuse_study(wanted)
    planned = plan(wanted)
    refuse_large(cost(planned, planned.size, workers), yes)
    if dry_run:
        found = outlook(wanted, results)
        due = sum(found.due(retry_failed).values())
        needed = cost(planned, due, workers)
        say(plan_text(found, needed, retry_failed, as_json or json_lines))
        return 0
    told = told_of(quiet, json_lines)
    again = arguments_of(experiment, settings, seeds, store)
    try:
        with other_output_on_stderr():
            summary = dispatch(
                wanted, results, jobs=workers, retry_failed=retry_failed, progress=told
            )
    except KeyboardInterrupt:
        tell(f"stopped at once; what is committed is safe. Go on: gaitlab run {again}")
        return INTERRUPTED
    tell_reasons(results, wanted.listed_as, summary)
    if wanted.form:
        tell(f"the trials of this form of {wanted.name} are listed as {wanted.listed_as}")
    say(_outcome(summary, again, as_json, json_lines))
    return INTERRUPTED if summary.interrupted else SOME_FAILED if summary.failed else 0


def told_of(quiet: bool, json_lines: bool) -> Progress:
    """Who is told of what happens meanwhile."""
    from gaitlab.cli.events import JsonLines
    from gaitlab.cli.progress import progress

    return JsonLines() if json_lines else progress(quiet=quiet)


def _outcome(summary: Summary, arguments: str, as_json: bool, json_lines: bool) -> str:
    """What stdout ends with."""
    from gaitlab.cli.events import end_line, summary_object

    if json_lines:
        return end_line(summary)
    return json.dumps(summary_object(summary)) if as_json else summary_text(summary, arguments)


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
    from gaitlab.shell import store_option

    return shlex.join([*parts, *store_option(store)])


def tell_reasons(results: Store, name: str, summary: Summary) -> None:
    """Why trials have no result, each reason once, with a trial to look at."""
    from gaitlab.shell import store_option

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
