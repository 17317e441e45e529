"""`gaitlab optimize`."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gaitlab.cli.checking import check_winner, hold_final
from gaitlab.cli.common import INTERRUPTED, worker_count
from gaitlab.cli.options import (
    DEFAULT_STORE,
    Jobs,
    Quiet,
    Settings,
    StoreFolder,
    completed,
    written_to,
)
from gaitlab.cli.printing import other_output_on_stderr, say, tell
from gaitlab.errors import UsageError

if TYPE_CHECKING:
    from gaitlab.search import History

MOST_CANDIDATES = 10**6


class Baseline(str, Enum):
    """What a sampler is compared with."""

    random = "random"


def _studies() -> list[str]:
    from gaitlab.experiment import studies

    return studies()


def optimize(
    study: Annotated[
        str,
        typer.Argument(
            metavar="STUDY",
            help="A file, or the name of one in experiments/.",
            autocompletion=completed(_studies),
        ),
    ],
    trials: Annotated[
        int | None,
        typer.Option(metavar="N", help="Candidates to try in total, instead of the file's."),
    ] = None,
    jobs: Jobs = None,
    storage: Annotated[
        str | None,
        typer.Option(
            metavar="URL",
            help="Database that several machines share, postgresql://user@host/name for "
            "instance; by default a file in the store.",
        ),
    ] = None,
    settings: Settings = None,
    store: StoreFolder = DEFAULT_STORE,
    export: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            parser=written_to,
            help="Write the winner as an experiment for `gaitlab run`.",
        ),
    ] = None,
    dry_run: Annotated[
        bool, typer.Option("-n", "--dry-run", help="Say what would be searched; run nothing.")
    ] = False,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print the result as one JSON object.")
    ] = False,
    baseline: Annotated[
        Baseline | None,
        typer.Option(
            help="Draw as many candidates at random instead, as the study STUDY-random, so that "
            "the report can tell whether the sampler beats chance."
        ),
    ] = None,
    validation: Annotated[
        bool,
        typer.Option(
            "--validation/--no-validation",
            help="Walk the winner again afterwards: on fresh seeds, on every ground, and with "
            "each parameter moved until the robot falls.",
        ),
    ] = True,
    quiet: Quiet = False,
) -> int:
    """Search a study for the parameters that walk best, and check the winner.

    Killing it is safe at any time: the same command goes on from there, and a larger --trials goes
    on from the end.

    \b
    Example:
      gaitlab optimize eros_small --export best.yaml
      gaitlab run best.yaml
    """
    from gaitlab.cli.search_text import plan_text, result_json, result_text
    from gaitlab.experiment import load_experiment
    from gaitlab.experiment.purposes import study_of
    from gaitlab.search.search import optimize as search
    from gaitlab.search.validation import random_sibling
    from gaitlab.search.winner import check_target
    from gaitlab.store import Store

    given = [*(settings or ()), *_trials_setting(trials)]
    if export is not None:
        check_target(export)
    with other_output_on_stderr():
        wanted = load_experiment(study, given)
    study_of(wanted)
    wanted = random_sibling(wanted) if baseline else wanted
    results, workers = Store(store), worker_count(jobs)
    if dry_run:
        say(plan_text(wanted, results, storage, workers, as_json))
        return 0
    from gaitlab.cli.search_progress import search_progress

    again = _arguments(study, trials, settings, storage, store)
    again += " --baseline random" if baseline else ""
    try:
        with other_output_on_stderr():
            told = search_progress(quiet=quiet)
            found = search(wanted, results, jobs=workers, storage=storage, told=told)
        going = found.ending not in ("stopped", "elsewhere")
        if going and validation:
            found, going = hold_final(found, results, workers, quiet=quiet)
        if not as_json:
            say(result_text(found, again, _arguments(study, None, settings, storage, store)))
        _export(found.tally.history, export, given, store)
        if going and validation:
            going = check_winner(
                found.tally.history,
                results,
                workers,
                storage,
                around=baseline is None,
                quiet=quiet,
                silent=as_json,
            )
    except KeyboardInterrupt:
        tell(f"stopped at once; what is committed is safe. Go on: gaitlab optimize {again}")
        return INTERRUPTED
    if as_json:
        say(result_json(found))
    elif not going and found.ending not in ("stopped", "elsewhere"):
        tell(f"Go on: gaitlab optimize {again}")
    return 0 if going or found.ending == "elsewhere" else INTERRUPTED


def _trials_setting(trials: int | None) -> list[str]:
    if trials is None:
        return []
    if not 1 <= trials <= MOST_CANDIDATES:
        raise UsageError(f"--trials {trials}: allowed is a whole number from 1 to 1,000,000")
    return [f"study.trials={trials}"]


def _arguments(
    study: str,
    trials: int | None,
    settings: Sequence[str] | None,
    storage: str | None,
    store: Path,
) -> str:
    """What makes the same command go on."""
    parts = [study, *(part for setting in settings or () for part in ("--set", setting))]
    parts += ["--trials", str(trials)] if trials is not None else []
    from gaitlab.shell import store_option

    if storage is not None:
        from gaitlab.search.addresses import shown  # loads Optuna, which takes a second

        parts += ["--storage", shown(storage)]
    return shlex.join([*parts, *store_option(store)])


def _export(history: History, export: Path | None, settings: Sequence[str], store: Path) -> None:
    """Write the winner; of a front, the one in its middle."""
    from gaitlab.search.validation import chosen_of
    from gaitlab.search.winner import export_winner
    from gaitlab.shell import store_option

    if export is None:
        return
    winner = chosen_of(history)
    if winner is None:
        tell(f"{export} is not written: no candidate is finished and breaks no constraint")
        return
    written = export_winner(history, winner, export, settings)
    tell(f"{export}: candidate {winner.number} with {len(written.seeds)} fresh seeds")
    tell(f"Walk it: {shlex.join(['gaitlab', 'run', str(export), *store_option(store)])}")
