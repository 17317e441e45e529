"""`gaitlab run`."""

from __future__ import annotations

import dataclasses
import json
import os
import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gaitlab.cli.options import DEFAULT_STORE, ExperimentName, Seeds, Settings, StoreFolder
from gaitlab.cli.printing import DAY, columns, duration, number, say, size, tell
from gaitlab.errors import UsageError

if TYPE_CHECKING:
    from gaitlab.dispatch import Cost, Outlook, Standing, Summary
    from gaitlab.store import Store

MANY_TRIALS = 100_000  # more need --yes
LONG = DAY  # s, an estimate beyond this needs --yes
INTERRUPTED, SOME_FAILED = 130, 4  # exit codes
SHOWN_FAILURES = 5


def run(
    experiment: ExperimentName,
    dry_run: Annotated[
        bool, typer.Option("-n", "--dry-run", help="Say what would run, and why; run nothing.")
    ] = False,
    jobs: Annotated[
        int | None,
        typer.Option(
            "-j",
            "--jobs",
            metavar="N",
            help="Worker processes, one a core by default; 0 runs in this process.",
        ),
    ] = None,
    seeds: Seeds = None,
    settings: Settings = None,
    store: StoreFolder = DEFAULT_STORE,
    retry_failed: Annotated[
        bool, typer.Option("--retry-failed", help="Run trials again that failed before.")
    ] = False,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print the counts as one JSON object.")
    ] = False,
    yes: Annotated[
        bool, typer.Option("--yes", help="Run even if it takes more than a day.")
    ] = False,
) -> int:
    """Simulate the trials of an experiment that are not in the store yet.

    Killing it is safe at any time: the same command goes on from there.

    \b
    Example:
      gaitlab run eros_quick -j 2 --set gait.step_height=0.02
    """
    from gaitlab.dispatch import cost, dispatch, outlook
    from gaitlab.experiment import load_experiment
    from gaitlab.plan import plan
    from gaitlab.store import Store

    wanted = load_experiment(experiment, settings=settings or (), seeds=seeds)
    results, workers = Store(store), _workers(jobs)
    planned = plan(wanted)
    _refuse_large(cost(planned, planned.size, workers), yes)
    if dry_run:
        found = outlook(wanted, results)
        due = sum(found.due(retry_failed).values())
        say(_plan_text(found, cost(planned, due, workers), retry_failed, as_json))
        return 0
    from gaitlab.cli.progress import progress

    summary = dispatch(
        wanted, results, jobs=workers, retry_failed=retry_failed, progress=progress()
    )
    _tell_failures(results, wanted.name, summary)
    again = _arguments(experiment, settings, seeds, store)
    say(_summary_json(summary) if as_json else _summary_text(summary, again))
    return INTERRUPTED if summary.interrupted else SOME_FAILED if summary.failed else 0


def _workers(jobs: int | None) -> int:
    if jobs is not None and jobs < 0:
        raise UsageError(f"--jobs {jobs}: allowed is 0 (this process) or a number of processes")
    return _cores() if jobs is None else jobs


def _cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _refuse_large(needed: Cost, yes: bool) -> None:
    if yes or (needed.trials <= MANY_TRIALS and needed.seconds <= LONG):
        return
    raise UsageError(
        f"this plan has {needed.trials:,} trials: up to {duration(needed.seconds)} and "
        f"{size(needed.size)} of logs. Shorten the grid or the seeds, or confirm with --yes."
    )


def _plan_text(found: Outlook, needed: Cost, retry_failed: bool, as_json: bool) -> str:
    """The plan as a table, a row a cell and a reason for everything that would run."""
    if as_json:
        counts = {"new": 0, "file damaged": 0, "failed before": 0, **found.due(True)}
        return json.dumps(
            {
                "planned": found.planned,
                "cached": found.count("cached"),
                "to_run": {stand.replace(" ", "_"): count for stand, count in counts.items()},
                "seconds": round(needed.seconds),
                "bytes": round(needed.size),
            }
        )
    paths = list(found.values[0]) if found.values else []
    head = [*paths, "cached", "to run", "why"]
    rows = [
        [*(number(values[path]) for path in paths), *_standing_cells(standing, retry_failed)]
        for values, standing in zip(found.values, found.standings, strict=True)
    ]
    total = f"{found.planned} trials in {len(rows)} cells: {found.count('cached')} cached, "
    total += f"{needed.trials} to run, up to {duration(needed.seconds)} and {size(needed.size)}"
    code = [f"this experiment runs code of your own: {file}" for file in found.own_code]
    return "\n".join([f"{columns(head, rows)}\n\n{total}", *code])


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


def _summary_json(summary: Summary) -> str:
    counts = dataclasses.asdict(summary)
    return json.dumps({**counts, "seconds": round(summary.seconds, 3)})


def _summary_text(summary: Summary, arguments: str) -> str:
    counts = f"{summary.planned} trials: {summary.cached} cached, {summary.done} done, "
    counts += f"{summary.infeasible} infeasible, {summary.failed} failed"
    counts += f", {summary.left} left" if summary.left else ""
    falls = f"The robot fell in {summary.falls} of them. {duration(summary.seconds)}"
    if summary.left:
        return f"{counts}. {falls}\nGo on: gaitlab run {arguments}"
    return f"{counts}. {falls}\nReport: gaitlab report {arguments}"


def _arguments(
    experiment: str, settings: Sequence[str] | None, seeds: int | None, store: Path
) -> str:
    """What makes another command mean the same trials."""
    parts = [experiment, *(part for setting in settings or () for part in ("--set", setting))]
    parts += ["--seeds", str(seeds)] if seeds is not None else []
    parts += ["--store", str(store)] if store != DEFAULT_STORE else []
    return shlex.join(parts)


def _tell_failures(results: Store, name: str, summary: Summary) -> None:
    if not summary.failed:
        return
    entries = results.index().entries
    wanted = [listed.trial_id for listed in results.experiments()[name].trials]
    failed = [entries[i] for i in wanted if i in entries and entries[i].state == "FAILED"]
    for entry in failed[:SHOWN_FAILURES]:
        tell(f"failed: {entry.trial_id[:8]}: {entry.reason}")
    tell("`gaitlab show` of a trial tells more; `--retry-failed` runs them again.")
