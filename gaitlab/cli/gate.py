"""`gaitlab check` and `baseline`: the nightly gate."""

from __future__ import annotations

import json
from dataclasses import asdict
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gaitlab.cli.options import DEFAULT_STORE, ExperimentName, Jobs, Seeds, Settings, StoreFolder
from gaitlab.cli.printing import other_output_on_stderr, plural, say, tell
from gaitlab.cli.running import INTERRUPTED, worker_count
from gaitlab.errors import StoreError, Undecided, UsageError, WorseBaseline

if TYPE_CHECKING:
    from gaitlab.experiment import Experiment
    from gaitlab.regression import Baseline, Outcome
    from gaitlab.store import Store


class _Stopped(Exception):
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
    store: StoreFolder = DEFAULT_STORE,
    summary: Annotated[
        Path | None,
        typer.Option("--summary", metavar="FILE.md", help="Also append the page to this file."),
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
    from gaitlab.regression import read_baseline, require_comparable, summary_page, undecided_page
    from gaitlab.store import Store

    _refuse_folder(summary, "--summary")
    with other_output_on_stderr():
        wanted = load_experiment(experiment, settings or (), seeds)
    try:
        before = read_baseline(baseline)
        require_comparable(wanted, before)
        tonight, outcome = _walked(wanted, Store(store), before, worker_count(jobs))
    except _Stopped:
        tell("stopped; what is committed is safe, and the same command goes on from there")
        return INTERRUPTED
    except Undecided as error:
        _publish(undecided_page(wanted.name, str(error)), summary)
        say(_undecided_json(error) if as_json else undecided_page(wanted.name, str(error)))
        return error.exit_code
    page = summary_page(before, tonight, outcome)
    _publish(page, summary)
    say(_json(outcome) if as_json else page)
    return outcome.exit_code


def baseline(
    experiment: ExperimentName,
    output: Annotated[Path, typer.Option("--output", metavar="FILE", help="JSON file to write.")],
    force: Annotated[
        bool, typer.Option("--force", help="Replace a baseline even by a worse one.")
    ] = False,
    seeds: Seeds = None,
    settings: Settings = None,
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
        wanted = load_experiment(experiment, settings or (), seeds)
    found = record(wanted, Store(store))
    _tell_of_other_code(found)
    if output.exists() and not force:
        _refuse_worse(found, output)
    write_baseline(found, output)
    stable = sum(walk.stable for walk in found.walks)
    say(f"{output}: {plural(len(found.walks), 'trial')} of {found.experiment}, {stable} stable")
    return 0


def _walked(
    wanted: Experiment, results: Store, before: Baseline, workers: int
) -> tuple[Baseline, Outcome]:
    """Tonight's walks and what the gate says of them.

    Raises:
        Undecided: If trials failed or nothing can be said.
        _Stopped: If somebody stopped it.
    """
    from gaitlab.cli.progress import progress
    from gaitlab.dispatch import dispatch
    from gaitlab.regression import compared, discard_stale, record

    with other_output_on_stderr():
        stale = discard_stale(wanted, results)
        if stale:
            tell(f"{plural(stale, 'trial')} in {results.path} came from other code: walked again")
        done = dispatch(wanted, results, jobs=workers, retry_failed=True, progress=progress())
    if done.interrupted:
        raise _Stopped
    tonight = record(wanted, results)
    return tonight, compared(before, tonight)


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
    from gaitlab.provenance import code_digest

    codes = found.provenance.get("code", ())
    if codes != (code_digest(),):
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


def _json(outcome: Outcome) -> str:
    tests = [
        {k: v if not isinstance(v, float) or isfinite(v) else None for k, v in asdict(q).items()}
        for q in outcome.quantities
    ]
    return json.dumps(
        {
            "verdict": "worse" if outcome.worse else "as good",
            "exit_code": outcome.exit_code,
            "mode": outcome.mode,
            "compared": outcome.runs.n,
            "worse": [_told(quantity.name, quantity.surface) for quantity in outcome.worse],
            "better": [_told(quantity.name, quantity.surface) for quantity in outcome.improved],
            "declared": list(outcome.declared),
            "other_bits": list(outcome.differing),
            "tests": tests,
        }
    )


def _told(name: str, surface: str) -> dict[str, str]:
    return {"quantity": name, "surface": surface or "all"}


def _undecided_json(error: Undecided) -> str:
    return json.dumps({"verdict": "undecided", "exit_code": error.exit_code, "reason": str(error)})
