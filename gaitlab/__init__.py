"""gaitlab tells a humanoid-robot team which gait parameters keep their robot on its feet.

In a notebook or a script, in the words of the command line:

    import gaitlab

    e = gaitlab.load("eros_quick", set={"gait.step_height": 0.02}, seeds=3)
    e.run(jobs=2)                           # only what the store does not hold yet
    trials = e.trials()                     # a row a trial; units in trials.attrs["units"]
    ticks = e.ticks("eros_quick/grass_50mm/worst")
    trial = e.simulate({"gait.step_length": 0.04, "surface": "grass_50mm"}, seed=0)
    e.report()

    gaitlab.open_store("data").query("SELECT surface, avg(stable::int) FROM trials GROUP BY 1")

Results are kept in `data`, in the `store` that a call is given, or where the variable
GAITLAB_STORE says. What is wrong is told by an exception of `gaitlab.errors`. The rooms of the
package are no part of this and may change; what stands here does not without a word.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

if TYPE_CHECKING:
    import pandas as pd

    from gaitlab.experiment import Experiment
    from gaitlab.experiment.plan import Cell, Plan
    from gaitlab.log import TrialLog
    from gaitlab.running import Progress, Summary
    from gaitlab.running.executor import Cluster
    from gaitlab.search.search import SearchCallback, SearchResult
    from gaitlab.store import Scalar, Shard, Store

__all__ = ["LoadedExperiment", "OpenedStore", "SimulatedTrial", "__version__", "load", "open_store"]
__version__ = "0.1.0"

Settings: TypeAlias = "Mapping[str, Any] | Sequence[str]"
StorePlace: TypeAlias = "str | Path | OpenedStore | None"
MOST_SHOWN = 6  # cells or values that a message lists


def load(
    name_or_file: str | Path,
    set: Settings | None = None,
    seeds: int | None = None,
) -> LoadedExperiment:
    """An experiment or a study, read and checked to the last value; nothing is run.

    Args:
        name_or_file: Name of one in `experiments/`, or a .yaml file.
        set: Value by dotted path, over the file's: `{"gait.step_height": 0.02}`; or a list of
            `path=value`, as `--set` takes them.
        seeds: Number of replicates of each cell, instead of the file's.

    Raises:
        UnknownName: If there is no such experiment.
        FileError: Everything that is wrong in it, with line and column.
        UsageError: If a setting makes no sense, or the file is a reproduction, which only the
            command line takes.
    """
    from gaitlab.documents import inline
    from gaitlab.experiment import load_experiment

    given = set or ()
    if isinstance(given, Mapping):
        given = [f"{path}={inline(_plain(value))}" for path, value in given.items()]
    experiment = load_experiment(name_or_file, given, seeds)
    return LoadedExperiment(experiment=experiment, settings=tuple(given), given_seeds=seeds)


def open_store(path: str | Path | None = None) -> OpenedStore:
    """The results in a folder, by default those that the command line would use."""
    return OpenedStore(path=_folder(path))


@dataclass(frozen=True, kw_only=True, repr=False)
class LoadedExperiment:
    """An experiment as it was loaded, and what can be done with it.

    Attributes:
        experiment: What was read, every part of it.
        settings: `path=value` each, as it was loaded with.
        given_seeds: Number of replicates that it was loaded with; None for the file's.
    """

    experiment: Experiment
    settings: tuple[str, ...] = ()
    given_seeds: int | None = None

    @property
    def name(self) -> str:
        """What its results are called; with settings, the name of this form of it."""
        return self.experiment.listed_as

    @property
    def cells(self) -> pd.DataFrame:
        """Every combination of what is varied, a row each, as `simulate` counts them.

        Of a study, which searches instead, only its grounds.
        """
        import pandas as pd

        cells = list(self._plan.cells())
        frame = pd.DataFrame([cell.values for cell in cells], index=[cell.index for cell in cells])
        frame.attrs["units"] = self._units(frame)
        return frame

    def run(
        self,
        store: StorePlace = None,
        *,
        jobs: int | None = None,
        shard: str | Shard | None = None,
        retry_failed: bool = False,
        progress: Progress | bool | None = None,
        dask: str | None = None,
        cluster: Cluster | None = None,
    ) -> Summary:
        """Simulate the trials that the store does not hold yet; safe to stop at any time.

        Args:
            store: Folder of the results.
            jobs: Worker processes, by default one a core; 0 runs every trial in this process.
            shard: `"1/4"` for the first of four shares of the experiment.
            retry_failed: Run trials again that failed before.
            progress: Is called as trials start and end. By default a terminal has a bar, a
                notebook a line now and then, and nobody else is told; False tells nobody.
            dask: `"local"`, the address of a scheduler, `"slurm"`, or a .yaml file for SLURM: has
                the workers, as `--dask` says.
            cluster: Has the workers, started before; see `gaitlab.running.executor`.

        Returns:
            What was planned, found, done, infeasible and failed. An interrupted run says so.

        Raises:
            UsageError: If this is a study, or there is no such shard or cluster.
            NoEngine: If an engine that it asks for is not installed.
            StoreError: If another run is at the same, or the store cannot be written.
            KeyboardInterrupt: At the second Ctrl-C; at the first, running trials end.
        """
        from gaitlab.experiment import refuse_study
        from gaitlab.running import dispatch
        from gaitlab.store import Shard

        refuse_study(self.experiment)
        with _workers_of(dask, cluster, jobs) as (there, workers):
            return dispatch(
                self.experiment,
                _store(store),
                jobs=workers,
                shard=Shard.of(shard) if isinstance(shard, str) else shard,
                retry_failed=retry_failed,
                progress=_progress(progress),
                cluster=there,
            )

    def optimize(
        self,
        store: StorePlace = None,
        *,
        jobs: int | None = None,
        storage: str | None = None,
        baseline: Literal["random"] | None = None,
        validation: bool = True,
        callback: SearchCallback | None = None,
        dask: str | None = None,
        cluster: Cluster | None = None,
    ) -> SearchResult:
        """Search a study for the parameters that walk best, and check the winner.

        Args:
            store: Folder of the results.
            jobs: Worker processes, by default one a core; 0 walks every trial in this process.
            storage: Address of a database that several machines share.
            baseline: `"random"` draws as many candidates at random instead.
            validation: Whether to hold the final and walk the winner on fresh seeds, on other
                grounds and around its values, as `report` tells.
            callback: Is called as the search goes on.
            dask: Has the workers, as of `run`.
            cluster: Has the workers, started before.

        Returns:
            The finished candidates, `history`, and why the search ended.

        Raises:
            UsageError: If this is no study, or the sampler's library is missing.
            StoreError: If another run is at the study, or store or database cannot be used.
        """
        from gaitlab.search.final import hold_final
        from gaitlab.search.fresh import random_sibling
        from gaitlab.search.search import optimize
        from gaitlab.search.validation import running, validate

        if baseline not in (None, "random"):
            _refuse(f"baseline {baseline!r}: allowed is random, or nothing")
        results = _store(store)
        wanted = random_sibling(self.experiment) if baseline else self.experiment
        with _workers_of(dask, cluster, jobs) as (there, workers):
            result = optimize(
                *(wanted, results),
                jobs=workers,
                storage=storage,
                callback=callback,
                cluster=there,
            )
            if not (validation and result.over):
                return result
            run = running(results, workers, others=storage is not None, cluster=there)
            history, whole = hold_final(result.history, results, run)
            if whole:
                validate(history, results, run, around=not baseline)
            return result.with_history(history)

    def trials(self, store: StorePlace = None) -> pd.DataFrame:
        """What became of its trials, as far as they were run: a row each, in the plan's order.

        Columns are id, experiment, robot, gait, surface, seed, state, reason, every metric and
        every varied value under its dotted path; `attrs["units"]` has the unit of each that is a
        number. A number that is missing is NaN.

        Raises:
            NothingRun: If the store holds none of them.
        """
        from gaitlab.experiment.shell import command
        from gaitlab.store import listed, trial_list

        results, study = _store(store), self.experiment.study
        if study is None:
            wanted = trial_list(self.experiment, map(listed, self._plan.trials()))
        else:
            wanted = results.experiments().get(self.name) or trial_list(self.experiment, ())
        table = results.table(wanted)
        again = command("optimize" if study else "run", [self.experiment], results.path)
        return _measured(table, results, f"of {self.name} yet: `{again}`", self._units(table))

    def ticks(self, trial: str, store: StorePlace = None) -> pd.DataFrame:
        """The log of a trial, a row a tick; see `OpenedStore.ticks`."""
        return OpenedStore(path=_store(store).path).ticks(trial)

    def simulate(self, cell: int | Mapping[str, Any] | pd.Series, seed: int = 0) -> SimulatedTrial:
        """One trial in this process; nothing is stored, and its bits are those of a stored one.

        Args:
            cell: Its number in `cells`, a row of them, or so many of its values that no other cell
                has them too: `{"gait.step_length": 0.04, "surface": "grass_50mm"}`. Of a study, a
                value for each path that is searched, and a ground if it has several.
            seed: Number of the replicate, one of the experiment's or any other.

        Raises:
            WrongValue: If there is no such cell or seed, or its parts refuse the combination.
            NoEngine: If its engine is not installed.
        """
        from gaitlab.running.run_trial import simulate_trial

        planned, chosen = self._cell(cell.to_dict() if hasattr(cell, "to_dict") else cell)
        trial = planned.trial(chosen, seed)
        record, log = simulate_trial(trial.id, trial.to_dict())
        return SimulatedTrial(
            id=trial.id,
            cell=chosen.values,
            seed=seed,
            state=record.state,
            reason=record.reason,
            metrics=record.metrics,
            ticks=_ticks(log),
        )

    def report(
        self,
        *others: LoadedExperiment,
        output: str | Path | None = None,
        format: Literal["md", "html"] = "md",
        tables: bool = False,
        force: bool = False,
        storage: str | None = None,
        store: StorePlace = None,
    ) -> Path:
        """Write the tables and figures of this experiment, or of several on one page.

        Args:
            others: Experiments, or studies, that share the page.
            output: Folder of the page, by default `reports/NAME`.
            format: `"html"` also writes one file that holds its figures.
            tables: Also write every table as LaTeX and CSV.
            force: Also replace files that gaitlab did not write.
            storage: Database of a study, if several machines share it.
            store: Folder of the results.

        Returns:
            The page.

        Raises:
            NothingRun: If none of the trials was run.
            UsageError: If the experiments cannot share a page, or the folder is somebody else's.
        """
        from gaitlab.report import write_report

        if format not in ("md", "html"):
            _refuse(f"format {format!r}: allowed is md or html")
        results, folder = _store(store), None if output is None else Path(output)
        asked = [loaded.experiment for loaded in (self, *others)]
        form: dict[str, Any] = {"html": format == "html", "tables": tables, "force": force}
        if any(experiment.design for experiment in asked):
            from gaitlab.papers.reproduction import sweep_page, write_reproduction

            sweep = sweep_page(asked, self.settings, self.given_seeds)
            if sweep is not None:
                return write_reproduction(sweep, results, folder, **form)
        if any(experiment.study for experiment in asked):
            from gaitlab.report.study.page import write_study_report  # loads all of Optuna

            return write_study_report(asked, results, folder, storage=storage, **form)
        return write_report(asked, results, folder, **form)

    @property
    def _plan(self) -> Plan:
        from gaitlab.experiment.plan import plan

        return plan(self.experiment, programs=False)

    def _units(self, frame: pd.DataFrame) -> dict[str, str]:
        """Units of the parameters that stand in a table, those of a team's own code too."""
        parts = self.experiment.parts
        paths = [path for path in frame.columns if "." in path]
        found = {path: parts.parameter(path).unit for path in paths}
        return {path: "-" if unit == "file" else unit for path, unit in found.items()}

    def _cell(self, asked: int | Mapping[str, Any]) -> tuple[Plan, Cell]:
        """The one cell that is meant, and the plan that it is in."""
        from gaitlab.errors import WrongValue
        from gaitlab.experiment import candidate
        from gaitlab.experiment.plan import plan
        from gaitlab.plugins import suggestion

        experiment = self.experiment
        if isinstance(asked, Mapping):
            asked = {path: _plain(value) for path, value in asked.items()}
            if experiment.study is not None:
                values = {path: value for path, value in asked.items() if path != "surface"}
                experiment = candidate(experiment, values)
        elif experiment.study is not None:
            raise WrongValue(f"{self.name} is a study: give the values of a cell, not its number")
        planned = plan(experiment)
        if not isinstance(asked, Mapping):
            if not 0 <= int(asked) < planned.cell_count:
                raise WrongValue(
                    f"cell {asked}: {self.name} has the cells 0 to {planned.cell_count - 1}"
                )
            return planned, planned.cell(int(asked))
        known = [*experiment.varied, "surface"]
        for path in asked:
            if path not in known:
                raise WrongValue(f"{path!r} is not varied by {self.name}{suggestion(path, known)}")
        fitting = [c for c in planned.cells() if all(c.values[p] == v for p, v in asked.items())]
        if len(fitting) != 1:
            near = fitting or list(planned.cells())
            lines = [f"{cell.index}: {_shown(cell.values)}" for cell in near[:MOST_SHOWN]]
            more = [f"and {len(near) - MOST_SHOWN} more"] if len(near) > MOST_SHOWN else []
            message = f"{len(fitting)} cells of {self.name} have {_shown(asked)}; give one of:"
            raise WrongValue("\n".join([message, *lines, *more]))
        return planned, fitting[0]

    def __repr__(self) -> str:
        from gaitlab.experiment.shell import called
        from gaitlab.plugins import label

        found, parts = self.experiment, self.experiment.parts
        robot, gait = label(parts.robot_code.name), label(parts.gait_code.name)
        walks = ", ".join(found.walkers) or f"{robot} walks {gait}"
        grounds = f"on {', '.join(parts.surfaces)}"
        if found.study is not None:
            searched = ", ".join(item.path for item in found.study.search)
            what = f"study of {found.study.trials} candidates over {searched}"
        else:
            cells, seeds = self._plan.cell_count, len(found.seeds)
            varied = f" over {', '.join(found.varied)}" if found.varied else ""
            what = f"{cells} cells x {seeds} seeds = {cells * seeds} trials{varied}"
        file = called(found.path)
        return (
            f"<{self.name}: {walks}, {what}, {grounds}{'' if file == self.name else f'; {file}'}>"
        )


@dataclass(frozen=True, kw_only=True)
class SimulatedTrial:
    """One trial that was simulated and not stored.

    Attributes:
        id: What the store would call it.
        cell: Its varied values by dotted path, and its ground under `surface`.
        seed: Number of the replicate.
        state: `DONE`, a fall included, `INFEASIBLE` or `FAILED`.
        reason: Why it is not `DONE`; empty when it is.
        metrics: Value by name, NaN where one is not defined; empty unless it is `DONE`.
        ticks: Its log as of `OpenedStore.ticks`; empty unless it is `DONE`.
    """

    id: str
    cell: Mapping[str, Any]
    seed: int
    state: str
    reason: str
    metrics: Mapping[str, Scalar]
    ticks: pd.DataFrame = field(repr=False)


@dataclass(frozen=True, kw_only=True)
class OpenedStore:
    """Results in a folder, without the file of their experiment. Opening it touches nothing.

    Attributes:
        path: The folder.
    """

    path: Path

    def trials(self) -> pd.DataFrame:
        """One row for each experiment and trial that is there; see `LoadedExperiment.trials`.

        The parameters of a team's own code stand here without their units.

        Raises:
            NothingRun: If there is none.
        """
        results = _store(self)
        table = results.table()
        return _measured(table, results, "yet: `gaitlab run EXPERIMENT`", {})

    def ticks(self, trial: str) -> pd.DataFrame:
        """The log of a trial, a row a tick, as it is stored; `attrs["units"]` has its units.

        Args:
            trial: Its first digits, `EXPERIMENT/VALUE/.../SEED`, or `EXPERIMENT/.../worst`, as for
                `gaitlab replay`.

        Raises:
            UnknownName: If it means none or several; lists the nearest.
            StoreError: If its file is damaged, or the trial ended without a log.
        """
        from gaitlab.store.addresses import trial_at

        results = _store(self)
        return _ticks(results.log(trial_at(results, trial)))

    def query(
        self,
        sql: str,
        *,
        exact: bool = False,
        left_out: Callable[[Exception], None] | None = None,
    ) -> pd.DataFrame:
        """Answer of one SELECT over the views `trials` and `ticks`.

        Args:
            sql: The query; names with a dot stand in double quotes.
            exact: Give every value as text in JSON with all its digits; None for NULL.
            left_out: Is told of every file that does not count, being damaged; by default a
                warning tells.

        Raises:
            UsageError: If the query is wrong; lists the columns.
        """
        return _store(self).query(sql, left_out or _warn, exact=exact)


def _folder(path: str | Path | None) -> Path:
    from gaitlab.experiment.shell import DEFAULT_STORE, STORE_VARIABLE

    return Path(path or os.environ.get(STORE_VARIABLE, "") or DEFAULT_STORE)


def _store(place: StorePlace) -> Store:
    from gaitlab.store import Store

    return Store(place.path if isinstance(place, OpenedStore) else _folder(place))


def _workers(jobs: int | None) -> int:
    """Worker processes, by default one for each processor there is to use.

    Raises:
        UsageError: If their number is negative.
    """
    from gaitlab.running import processors

    if jobs is not None and jobs < 0:
        _refuse(f"jobs {jobs}: allowed is 0, which is this process, or a number of processes")
    return processors() if jobs is None else jobs


@contextmanager
def _workers_of(
    dask: str | None, cluster: Cluster | None, jobs: int | None
) -> Iterator[tuple[Cluster | None, int]]:
    """The cluster that was given or is asked for, ended with the block, and its workers."""
    if dask is None:
        yield cluster, _workers(jobs)
        return
    if cluster is not None:
        _refuse("dask and cluster: both name the workers; give one of them")
    if dask != "local" and jobs is not None:
        _refuse(f"jobs {jobs}: with dask {dask!r} the cluster has as many workers as it has")
    from gaitlab.running.dask_cluster import DaskCluster

    with DaskCluster(dask, jobs=max(1, _workers(jobs)), shared=True) as started:
        yield started, started.workers


def _progress(asked: Progress | bool | None) -> Progress | None:
    """Who is told of a run; by default whoever looks at a terminal or a notebook."""
    if not isinstance(asked, bool) and asked is not None:
        return asked
    from gaitlab.cli.progress import Lines, moving_terminal, progress

    if asked is None and "ipykernel" in sys.modules:
        return Lines()
    return progress() if asked or (asked is None and moving_terminal()) else None


def _refuse(message: str) -> None:
    from gaitlab.errors import UsageError

    raise UsageError(message)


def _plain(value: Any) -> Any:
    """A number of NumPy or pandas as one of Python, a path as its text."""
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if isinstance(value, Mapping):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return value.item() if hasattr(value, "item") else value


def _measured(
    table: pd.DataFrame, results: Store, where: str, known: Mapping[str, str]
) -> pd.DataFrame:
    """A table of trials with its units.

    Raises:
        NothingRun: If it is empty.
    """
    from gaitlab.errors import NothingRun
    from gaitlab.store.units import units

    if table.empty:
        raise NothingRun(f"{results.path} holds no trial {where}")
    gaps = [name for name, kind in table.dtypes.items() if str(kind) == "Int64"]
    table = table.astype(dict.fromkeys(gaps, "float64"))
    table.attrs["units"] = units(table, known)
    return table


def _ticks(log: TrialLog | None) -> pd.DataFrame:
    import pandas as pd

    from gaitlab.log.columns import columns

    if log is None:
        return pd.DataFrame()
    frame = pd.DataFrame(dict(log.arrays))
    frame.attrs["units"] = {column.name: column.unit for column in columns(log.header.joints)}
    return frame


def _shown(values: Mapping[str, Any]) -> str:
    return ", ".join(f"{path} {value}" for path, value in values.items())


def _warn(problem: Exception) -> None:
    from warnings import warn

    warn(f"not counted: {problem}", stacklevel=4)
