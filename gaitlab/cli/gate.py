"""`gaitlab check` and `baseline`: the nightly gate."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, cast

import typer

from gaitlab.cli.common import INTERRUPTED, tell_cache, tell_engine, worker_count
from gaitlab.cli.options import (
    DEFAULT_STORE,
    Engine,
    ExperimentName,
    Jobs,
    Seeds,
    Settings,
    StoreFolder,
    with_engine,
    written_to,
)
from gaitlab.cli.printing import other_output_on_stderr, plural, say, tell
from gaitlab.errors import StoreError, Undecided, UsageError, WorseBaseline

if TYPE_CHECKING:
    from gaitlab.experiment import Experiment
    from gaitlab.model.settings import EngineName
    from gaitlab.regression import Baseline, GateResult
    from gaitlab.store import Store


class _WalksStopped(Exception):
    """Ctrl-C or SIGTERM ended the walks of tonight early."""


def check(
    experiment: ExperimentName,
    baseline: Annotated[
        Path,
        typer.Option("--baseline", metavar="FILE", help="What `gaitlab baseline` has written."),
    ],
    jobs: Jobs = None,
    seeds: Seeds = None,
    settings: Settings = None,
    engine: Engine = None,
    store: StoreFolder = DEFAULT_STORE,
    summary: Annotated[
        Path | None,
        typer.Option(
            "--summary",
            metavar="FILE.md",
            parser=written_to,
            help="Also append the page to this file.",
        ),
    ] = None,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print one JSON object instead of the page.")
    ] = False,
) -> int:
    """Walk an experiment and compare with a baseline: exit 0 as good, 5 worse, 6 cannot tell.

    Trials that this very code has simulated are not simulated again; those of other code are, and
    replaced.

    \b
    Example:
      gaitlab check nightly --baseline nightly.json --summary summary.md
    """
    from gaitlab.experiment import load_experiment
    from gaitlab.regression import (
        outcome_json,
        outcome_page,
        read_baseline,
        require_comparable,
        undecided,
    )
    from gaitlab.store import Store

    _refuse_folder(summary, "--summary")
    with other_output_on_stderr():
        wanted = load_experiment(experiment, with_engine(settings, engine), seeds)
    tell_engine()
    tell_cache()
    before = None
    try:
        before = read_baseline(baseline)
        require_comparable(wanted, before)
        outcome = _walked(wanted, Store(store), before, worker_count(jobs))
    except _WalksStopped:
        tell("stopped; what is committed is safe, and the same command goes on from there")
        return INTERRUPTED
    except Undecided as error:
        outcome = undecided(str(error), before)
    page = outcome_page(wanted.name, outcome)
    _publish(page, summary)
    say(outcome_json(wanted.name, outcome) if as_json else page)
    return outcome.exit_code


def baseline(
    experiment: ExperimentName,
    output: Annotated[
        Path,
        typer.Option("--output", metavar="FILE", parser=written_to, help="JSON file to write."),
    ],
    force: Annotated[
        bool, typer.Option("--force", help="Replace a baseline even by a worse one.")
    ] = False,
    seeds: Seeds = None,
    settings: Settings = None,
    engine: Engine = None,
    store: StoreFolder = DEFAULT_STORE,
) -> int:
    """Write what the walks of an experiment gave, for `gaitlab check` to compare with.

    The experiment must have run to its end. A baseline that walks significantly better is not
    replaced without --force.

    \b
    Example:
      gaitlab baseline nightly --output nightly.json
    """
    from gaitlab.experiment import load_experiment
    from gaitlab.regression import record, write_baseline
    from gaitlab.store import Store

    _refuse_folder(output, "--output")
    with other_output_on_stderr():
        wanted = load_experiment(experiment, with_engine(settings, engine), seeds)
    found = record(wanted, Store(store))
    _tell_of_other_code(found)
    if output.exists() and not force:
        _refuse_worse(found, output)
    write_baseline(found, output)
    stable = sum(walk.stable for walk in found.walks)
    out = sum(walk.state == "INFEASIBLE" for walk in found.walks)
    counts = f"{stable} stable, {len(found.walks) - stable - out} fell, {out} out of reach"
    say(f"{output}: {plural(len(found.walks), 'trial')} of {found.experiment}, {counts}")
    return 0


def _walked(wanted: Experiment, results: Store, before: Baseline, workers: int) -> GateResult:
    """What the gate says of tonight's walks; if some failed, of those that did not.

    Raises:
        _WalksStopped: If somebody stopped it.
    """
    from gaitlab.cli.progress import progress, steps
    from gaitlab.documents.steps import expect, step
    from gaitlab.regression import compared, discard_stale, finished, record, undecided
    from gaitlab.running import dispatch

    with other_output_on_stderr():
        stale = discard_stale(wanted, results)
        if stale:
            tell(f"{plural(stale, 'trial')} in {results.path} came from other code: walked again")
        done = dispatch(wanted, results, jobs=workers, retry_failed=True, progress=progress())
    if done.interrupted:
        raise _WalksStopped
    try:
        with steps():
            expect(2)
            step(f"reading the walks of {wanted.name}")
            walks = record(wanted, results)
            step("comparing with the baseline")
            return compared(before, walks)
    except Undecided as error:
        return undecided(str(error), before, finished(wanted, results))


def _refuse_folder(path: Path | None, option: str) -> None:
    if path is not None and path.is_dir():
        raise UsageError(f"{option} {path}: this is a folder; give a file")


def _refuse_worse(found: Baseline, output: Path) -> None:
    """Refuse to replace what is no baseline of this experiment, or one that walks better."""
    from gaitlab.regression import checked, read_baseline
    from gaitlab.regression.page import listed

    try:
        before = read_baseline(output)
    except Undecided as error:
        raise Undecided(f"{error}. --force replaces the file") from error
    if before.experiment != found.experiment:
        raise Undecided(
            f"{output} is the baseline of {before.experiment}, not of {found.experiment}; choose "
            "another --output, or --force"
        )
    worse = checked(before, found)
    if worse:
        raise WorseBaseline(
            f"{output} walks better than what would replace it: {listed(worse)}. Find the cause, "
            "or accept it with --force"
        )


def _tell_of_other_code(found: Baseline) -> None:
    from gaitlab.running.provenance import code_digest

    engines = cast("Sequence[EngineName]", found.provenance.get("engine", ("bullet",)))
    if {*found.provenance.get("code", ())} != {code_digest(engine) for engine in engines}:
        tell(
            "note: other code than this has simulated some of these trials; `gaitlab check` will "
            "simulate them again"
        )


def _publish(page: str, summary: Path | None) -> None:
    """Append the page to a file, as the summary of a job is written."""
    if summary is None:
        return
    try:
        with summary.open("a", encoding="utf-8") as file:
            file.write(f"{page}\n")
    except OSError as error:
        raise StoreError(f"--summary {summary}: {error.strerror}; choose another file") from error
