"""`gaitlab run`."""

from __future__ import annotations

import json
from contextlib import nullcontext
from typing import TYPE_CHECKING, Annotated

import typer

from gaitlab.cli.common import (
    INTERRUPTED,
    SOME_FAILED,
    arguments_of,
    cluster_of,
    plan_text,
    progress_of,
    refuse_large,
    refuse_quick,
    share_of,
    summary_text,
    tell_cache,
    tell_compiling,
    tell_engine,
    tell_reasons,
    worker_count,
)
from gaitlab.cli.options import (
    DEFAULT_STORE,
    Dask,
    Engine,
    ExperimentName,
    Jobs,
    Quick,
    Quiet,
    Seeds,
    Settings,
    ShardText,
    SharedStore,
    StoreFolder,
    with_engine,
)
from gaitlab.cli.printing import (
    other_output_on_stderr,
    say,
    tell,
)

if TYPE_CHECKING:
    from gaitlab.running import Summary
    from gaitlab.store import Shard


def run(
    experiment: ExperimentName,
    dry_run: Annotated[
        bool, typer.Option("-n", "--dry-run", help="Say what would run, and why; run nothing.")
    ] = False,
    jobs: Jobs = None,
    dask: Dask = None,
    shared_store: SharedStore = True,
    seeds: Seeds = None,
    settings: Settings = None,
    engine: Engine = None,
    shard: ShardText = None,
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
      gaitlab run eros_quick --shard 1/4
    """
    from gaitlab import load
    from gaitlab.experiment import is_reproduction, refuse_study
    from gaitlab.experiment.plan import plan
    from gaitlab.running import cost, outlook
    from gaitlab.store import Shard, Store

    results = Store(store)
    share = None if shard is None else Shard.of(shard)
    settings = with_engine(settings, engine)
    with cluster_of(dask, jobs, shared_store) or nullcontext() as cluster:
        workers = cluster.workers if cluster else worker_count(jobs)
        if is_reproduction(experiment):
            from gaitlab.cli.reproducing import RunOptions, run_members
            from gaitlab.papers.reproduction import load_reproduction

            with other_output_on_stderr():
                whole = load_reproduction(experiment, quick=quick, settings=settings, seeds=seeds)
            tell_engine()
            again = arguments_of(experiment, settings, seeds, store, quick=quick)
            options = RunOptions(
                workers=workers,
                cluster=cluster,
                shard=share,
                retry_failed=retry_failed,
                as_json=as_json,
                json_lines=json_lines,
                quiet=quiet,
                yes=yes,
                again=again,
            )
            if not dry_run:
                tell_cache()
            return run_members(whole, results, options, dry_run=dry_run)
        refuse_quick(experiment, quick)
        with other_output_on_stderr():
            loaded = load(experiment, settings, seeds)
        wanted = loaded.experiment
        refuse_study(wanted)
        tell_engine()
        planned = plan(wanted, programs=False)
        refuse_large(cost(planned, share_of(planned.size, share), workers), yes)
        if dry_run:
            found = outlook(wanted, results, share)
            due = sum(found.due(retry_failed).values())
            needed = cost(planned, due, workers)
            say(plan_text(found, needed, retry_failed, as_json or json_lines))
            return 0
        tell_compiling(wanted)
        for command in planned.written_by:
            tell(f"walks that are not written yet are now, by {command}")
        progress = progress_of(quiet, json_lines)
        again = arguments_of(experiment, settings, seeds, store)
        try:
            with other_output_on_stderr():
                summary = loaded.run(
                    store,
                    jobs=workers,
                    shard=share,
                    retry_failed=retry_failed,
                    progress=progress,
                    cluster=cluster,
                )
        except KeyboardInterrupt:
            tell(f"stopped at once; what is committed is safe. Go on: gaitlab run {again}")
            return INTERRUPTED
    tell_reasons(results, wanted.listed_as, summary)
    if wanted.form:
        tell(f"the trials of this form of {wanted.name} are listed as {wanted.listed_as}")
    say(_outcome(summary, again, share, as_json, json_lines))
    return INTERRUPTED if summary.interrupted else SOME_FAILED if summary.failed else 0


def _outcome(
    summary: Summary, arguments: str, shard: Shard | None, as_json: bool, json_lines: bool
) -> str:
    """What stdout ends with."""
    from gaitlab.cli.progress import end_line, summary_object

    if json_lines:
        return end_line(summary)
    if as_json:
        return json.dumps(summary_object(summary))
    return summary_text(summary, arguments, shard)
