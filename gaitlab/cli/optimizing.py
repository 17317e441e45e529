"""`gaitlab optimize`."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from contextlib import nullcontext
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeAlias

import typer

from gaitlab.cli.common import (
    INTERRUPTED,
    cluster_of,
    tell_compiling,
    tell_engine,
    worker_count,
)
from gaitlab.cli.options import (
    DEFAULT_STORE,
    Dask,
    Engine,
    Jobs,
    Quiet,
    Settings,
    SharedStore,
    StoreFolder,
    completed,
    with_engine,
    written_to,
)
from gaitlab.cli.printing import duration, other_output_on_stderr, plural, say, tell
from gaitlab.errors import UsageError

if TYPE_CHECKING:
    from gaitlab import LoadedExperiment
    from gaitlab.experiment import Experiment
    from gaitlab.running.executor import Cluster
    from gaitlab.search import History
    from gaitlab.search.search import SearchResult
    from gaitlab.store import Store

MOST_CANDIDATES = 10**6


class RandomBaseline(str, Enum):
    """What a sampler is compared with."""

    random = "random"


def _studies() -> list[str]:
    from gaitlab.experiment import studies

    return studies()


StudyName: TypeAlias = Annotated[
    str,
    typer.Argument(
        metavar="STUDY",
        help="A file, or the name of one in experiments/.",
        autocompletion=completed(_studies),
    ),
]
Trials: TypeAlias = Annotated[
    int | None,
    typer.Option(metavar="N", help="Candidates to try in total, instead of the file's."),
]
StorageAddress: TypeAlias = Annotated[
    str | None,
    typer.Option(
        metavar="URL",
        help="Database that several machines share, postgresql://user@host/name for instance; by "
        "default a file in the store.",
    ),
]
Export: TypeAlias = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE",
        parser=written_to,
        help="Write the winner as an experiment for `gaitlab run`.",
    ),
]
DryRun: TypeAlias = Annotated[
    bool, typer.Option("-n", "--dry-run", help="Say what would be searched; run nothing.")
]
AsJson: TypeAlias = Annotated[
    bool, typer.Option("--json", help="Print the result as one JSON object.")
]
Against: TypeAlias = Annotated[
    RandomBaseline | None,
    typer.Option(
        help="Draw as many candidates at random instead, as the study STUDY-random, so that the "
        "report can tell whether the sampler beats chance."
    ),
]
Validate: TypeAlias = Annotated[
    bool,
    typer.Option(
        "--validation/--no-validation",
        help="Walk the winner again afterwards: on fresh seeds, on every ground, and with each "
        "parameter moved until the robot falls.",
    ),
]


def optimize(
    study: StudyName,
    trials: Trials = None,
    jobs: Jobs = None,
    dask: Dask = None,
    shared_store: SharedStore = True,
    storage: StorageAddress = None,
    settings: Settings = None,
    engine: Engine = None,
    store: StoreFolder = DEFAULT_STORE,
    export: Export = None,
    dry_run: DryRun = False,
    as_json: AsJson = False,
    baseline: Against = None,
    validation: Validate = True,
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
    from gaitlab import load
    from gaitlab.cli.search_text import plan_text
    from gaitlab.experiment import study_of
    from gaitlab.search.fresh import random_sibling
    from gaitlab.search.winner import check_target
    from gaitlab.store import Store

    given = [*with_engine(settings, engine), *_trials_setting(trials)]
    if export is not None:
        check_target(export)
    with other_output_on_stderr():
        loaded = load(study, given)
    study_of(loaded.experiment)
    tell_engine()
    experiment = random_sibling(loaded.experiment) if baseline else loaded.experiment
    results = Store(store)
    with cluster_of(dask, jobs, shared_store) or nullcontext() as cluster:
        workers = cluster.workers if cluster else worker_count(jobs)
        if dry_run:
            say(plan_text(experiment, results, storage, workers, as_json))
            return 0
        tell_compiling(experiment)
        search = _OptimizeRun(
            *(loaded, experiment, results, storage, workers, cluster),
            *(quiet, as_json, baseline is not None),
        )
        try:
            return search.run(export, given, validation)
        except KeyboardInterrupt:
            tell(f"stopped at once; what is committed is safe. Go on: {search.again}")
            return INTERRUPTED


def _trials_setting(trials: int | None) -> list[str]:
    if trials is None:
        return []
    if not 1 <= trials <= MOST_CANDIDATES:
        raise UsageError(f"--trials {trials}: allowed is a whole number from 1 to 1,000,000")
    return [f"study.trials={trials}"]


class _OptimizeRun:
    """A search on the command line, with what is said on the way."""

    def __init__(
        self,
        loaded: LoadedExperiment,
        experiment: Experiment,
        store: Store,
        storage: str | None,
        jobs: int,
        cluster: Cluster | None,
        quiet: bool,
        as_json: bool,
        random: bool,
    ) -> None:
        from gaitlab.search.database import command_line

        self.loaded, self.experiment, self.store = loaded, experiment, store
        self.storage, self.jobs = storage, jobs
        self.cluster, self.quiet, self.as_json, self.random = cluster, quiet, as_json, random
        self.shared = storage is not None
        self.again = command_line("optimize", experiment, store, storage)
        self.again += " --baseline random" if random else ""

    def run(self, export: Path | None, settings: Sequence[str], validation: bool) -> int:
        """Search, hold the final, export and check the winner; the exit code."""
        from gaitlab.cli.search_progress import search_progress
        from gaitlab.cli.search_text import result_json, result_text
        from gaitlab.search.database import command_line
        from gaitlab.search.obstacles import obstacles

        with other_output_on_stderr():
            result = self.loaded.optimize(
                self.store.path,
                jobs=self.jobs,
                storage=self.storage,
                baseline="random" if self.random else None,
                validation=False,
                callback=search_progress(quiet=self.quiet),
                cluster=self.cluster,
            )
        going = result.over
        if going and validation:
            result, going = self.hold_final(result)
        if not self.as_json:
            page = command_line("report", self.experiment, self.store, self.storage)
            why = [] if result.history.front else obstacles(result.history, self.store)
            say(result_text(result, self.again, page, why))
        if export is not None:
            _export(result.history, export, settings, self.store)
        if going and validation:
            going = self.check_winner(result.history)
        if self.as_json:
            say(result_json(result))
        elif result.over and not going:
            tell(f"Go on: {self.again}")
        return 0 if going or result.ending == "elsewhere" else INTERRUPTED

    def hold_final(self, result: SearchResult) -> tuple[SearchResult, bool]:
        """Let the best walk with as many seeds again; whether all of it was walked."""
        from gaitlab.cli.progress import progress
        from gaitlab.search.final import due_finals, hold_final
        from gaitlab.search.validation import running

        waiting = due_finals(result.history, self.store)
        if waiting and not self.quiet:
            more = plural(len(self.experiment.seeds), "further seed")
            tell(f"Final: the best {len(waiting)} walk with {more} each; --no-validation skips it")
        with other_output_on_stderr():
            run = running(
                self.store,
                self.jobs,
                progress(quiet=True),
                cluster=self.cluster,
                others=self.shared,
            )
            history, completed = hold_final(result.history, self.store, run)
        return result.with_history(history), completed

    def check_winner(self, history: History) -> bool:
        """Walk the winner again and say what holds; False after a Ctrl-C."""
        from gaitlab.cli.progress import progress
        from gaitlab.report.study.gathering import findings_of
        from gaitlab.report.study.sentences import brief
        from gaitlab.search.validation import running, validate

        if not self.quiet:
            self._say_effort(history)
        with other_output_on_stderr():
            run = running(
                self.store,
                self.jobs,
                progress(quiet=self.quiet),
                cluster=self.cluster,
                others=self.shared,
            )
            checked = validate(history, self.store, run, around=not self.random)
        if checked is None:
            return True
        if not self.as_json and not checked.stopped:
            say("\n" + brief(findings_of(history.experiment, self.store, self.storage)))
        return not checked.stopped

    def _say_effort(self, history: History) -> None:
        from gaitlab.search.validation import effort

        needed = effort(history, self.store, self.jobs, around=not self.random)
        if needed is None:
            return
        walked = "on fresh seeds, on every ground" + (
            "" if self.random else " and around its values"
        )
        tell(
            f"Checking candidate {needed.chosen.number} {walked}: up to "
            f"{plural(needed.walks, 'trial')}, {duration(needed.seconds)}; falls and what the "
            "store holds make it less. --no-validation skips it"
        )


def _export(history: History, export: Path, settings: Sequence[str], store: Store) -> None:
    """Write the winner; of a front, the one in its middle."""
    from gaitlab.experiment.shell import store_option
    from gaitlab.search.winner import export_winner

    winner = history.representative
    if winner is None:
        tell(f"{export} is not written: no candidate is finished and breaks no constraint")
        return
    written = export_winner(history, winner, export, settings)
    tell(f"{export}: candidate {winner.number} with {len(written.seeds)} fresh seeds")
    tell(f"Walk it: {shlex.join(['gaitlab', 'run', str(export), *store_option(store.path)])}")
