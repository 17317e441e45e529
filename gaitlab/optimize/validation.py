"""After the search: is the winner real, does it walk elsewhere, and how far may it drift?

Everything here is ordinary experiments beside the study's own trials: `<study>-winner` and
`<study>-default` on fresh seeds and every ground, `<study>-margins` around the winner. What is in
the store is never walked again, so all of it resumes where it was stopped.

Fresh seeds are those from 1,000,000 on, which no search uses: a search's seeds count from 0, and
one that lists larger ones moves the fresh ones beyond its own.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from gaitlab.dispatch import Progress, dispatch
from gaitlab.dispatch.outlook import WALL_RATIO
from gaitlab.errors import GaitlabError
from gaitlab.experiment import Axis, Experiment, Value
from gaitlab.experiment.study import Choices, Numbers
from gaitlab.optimize.validation_margins import (
    MOST_STEPS,
    Verdict,
    ladder,
    next_step,
    reach,
)
from gaitlab.plan import plan
from gaitlab.plugins import names
from gaitlab.report.study.findings import DEFAULT, WINNER, Margin, Margins, Rerun, Switch, Walk
from gaitlab.store import Index, Store
from gaitlab.study import Candidate, History
from gaitlab.surfaces import Surface
from gaitlab.surfaces.files import load_surface
from gaitlab.trial import canonical_json

FIRST_FRESH = 1_000_000  # seeds from here on are kept for checking
FRESH_SEEDS = 10  # of a check, or as many as the study itself uses
MARGIN_WALKS = 4  # at every step around the winner, on all grounds together
LEAST_MARGIN_SEEDS = 2  # on each ground

Run = Callable[[Experiment], bool]  # runs what is missing; False when it was stopped


@dataclass(frozen=True, kw_only=True)
class Validation:
    """What was walked after a search.

    Attributes:
        chosen: Candidate that was walked again.
        reruns: The winner and the default on fresh seeds.
        margins: Around the winner; None if that was not begun.
        stopped: Whether a Ctrl-C ended it before everything was walked.
    """

    chosen: Candidate
    reruns: tuple[Rerun, ...]
    margins: Margins | None
    stopped: bool = False


@dataclass(frozen=True, kw_only=True)
class Effort:
    """What a validation takes at most.

    Attributes:
        walks: Trials.
        seconds: Wall time, in [s].
    """

    walks: int
    seconds: float


def fresh_seeds(experiment: Experiment, count: int | None = None) -> range:
    """Seeds that the search never saw."""
    first = max(FIRST_FRESH, max(experiment.seeds) + 1)
    return range(first, first + (count or max(FRESH_SEEDS, len(experiment.seeds))))


def chosen_of(history: History) -> Candidate | None:
    """The candidate to walk again: the best, or the middle one of a Pareto front."""
    if history.best is not None or not history.front:
        return history.best
    return history.front[len(history.front) // 2]


def derived(
    experiment: Experiment,
    role: str,
    paths: Sequence[str],
    rows: Sequence[Sequence[Value]],
    seeds: Sequence[int],
    surfaces: Mapping[str, Surface] | None = None,
) -> Experiment:
    """An ordinary experiment beside a study, its values as the only axis; no rows for the base."""
    parts = experiment.parts
    parts = replace(parts, surfaces=parts.surfaces if surfaces is None else surfaces)
    axes = (Axis(paths=tuple(paths), rows=tuple(map(tuple, rows))),) if paths else ()
    content = [
        experiment.digest,
        role,
        [list(paths), list(rows)],
        list(seeds),
        list(parts.surfaces),
    ]
    return replace(
        experiment,
        name=f"{experiment.name}-{role}",
        digest=hashlib.sha256(canonical_json(content).encode()).hexdigest(),
        text=f"# {role} of the study below, made by `gaitlab optimize`\n{experiment.text}",
        parts=parts,
        axes=axes,
        seeds=seeds,
        study=None,
    )


def random_sibling(experiment: Experiment) -> Experiment:
    """The same study with values drawn at random, to tell whether its sampler beats chance.

    Raises:
        ValueError: If the experiment is no study.
    """
    if experiment.study is None:
        raise ValueError(f"{experiment.name} is no study")
    content = ["random", experiment.digest]
    return replace(
        experiment,
        name=f"{experiment.name}-random",
        digest=hashlib.sha256(canonical_json(content).encode()).hexdigest(),
        study=replace(experiment.study, sampler="random", sampler_options={}),
    )


def grounds(experiment: Experiment) -> dict[str, Surface]:
    """The study's own grounds first, then every other one that is found by name."""
    own = dict(experiment.parts.surfaces)
    study = experiment.study
    if study is not None and any(item.path.startswith("surface.") for item in study.search):
        return own  # another type of ground may lack the searched parameter
    return own | {name: load_surface(name) for name in names("surface") if name not in own}


def winner_experiment(history: History, chosen: Candidate) -> Experiment:
    """The winner with fresh seeds on every ground."""
    experiment = history.experiment
    values = chosen.values
    seeds = fresh_seeds(experiment)
    row = [tuple(values.values())]
    return derived(experiment, "winner", tuple(values), row, seeds, grounds(experiment))


def default_experiment(experiment: Experiment) -> Experiment:
    """The experiment's own values with fresh seeds on every ground."""
    return derived(experiment, "default", (), (), fresh_seeds(experiment), grounds(experiment))


def effort(
    history: History, chosen: Candidate, store: Store, jobs: int, *, around: bool = True
) -> Effort:
    """What is missing at most, if no robot falls."""
    index = store.index()
    found = [winner_experiment(history, chosen), default_experiment(history.experiment)]
    walks = sum(len(missing(one, index)) for one in found)
    numbers = [item for item in history.study.search if isinstance(item, Numbers)]
    margins = 2 * MOST_STEPS * len(numbers) * len(_margin_seeds(history.experiment))
    walks += margins * len(history.experiment.parts.surfaces) if around else 0
    seconds = walks * plan(found[0]).seconds * WALL_RATIO / max(1, jobs)
    return Effort(walks=walks, seconds=seconds)


def missing(experiment: Experiment, index: Index) -> list[str]:
    """Trials of an experiment that a store does not hold."""
    trials = (item.trial.id for item in plan(experiment).trials())
    return [trial_id for trial_id in trials if trial_id not in index.entries]


def running(store: Store, jobs: int, progress: Progress | None = None) -> Run:
    """What carries out the experiments of a validation with some worker processes."""

    def run(experiment: Experiment) -> bool:
        return not dispatch(experiment, store, jobs=jobs, progress=progress).interrupted

    return run


def validate(history: History, store: Store, run: Run, *, around: bool = True) -> Validation | None:
    """Walk the winner again; None if there is no winner.

    Args:
        history: The search.
        store: Where the trials are.
        run: Carries out an experiment. One that does nothing makes this a reading of the store.
        around: Whether to walk around the winner's values too.
    """
    chosen = chosen_of(history)
    if chosen is None:
        return None
    wanted = {
        WINNER: winner_experiment(history, chosen),
        DEFAULT: default_experiment(history.experiment),
    }
    going = all(run(one) for one in wanted.values() if missing(one, store.index()))
    index = store.index()
    reruns = tuple(rerun(label, one, index) for label, one in wanted.items())
    if not (going and around):
        return Validation(chosen=chosen, reruns=reruns, margins=None, stopped=not going)
    found, stopped = _Around(history, chosen, store, run).margins()
    return Validation(chosen=chosen, reruns=reruns, margins=found, stopped=stopped)


def rerun(label: str, experiment: Experiment, index: Index) -> Rerun:
    """An experiment of one combination as the store has it."""
    trials = list(plan(experiment).trials())
    walks = tuple(_walk(item.trial.id, item.values, item.trial.seed, index) for item in trials)
    values = dict(trials[0].values)
    values.pop("surface", None)
    return Rerun(label=label, values=values, walks=walks)


def _walk(trial_id: str, values: Mapping[str, Value], seed: int, index: Index) -> Walk:
    entry = index.entries.get(trial_id)
    return Walk(
        trial_id=trial_id,
        surface=str(values["surface"]),
        seed=seed,
        state="MISSING" if entry is None else entry.state,
        metrics=entry.details.metrics if entry is not None and entry.state == "DONE" else {},
    )


def _margin_seeds(experiment: Experiment) -> range:
    """The first of the fresh seeds, so that the winner's own walks are there already."""
    count = max(LEAST_MARGIN_SEEDS, MARGIN_WALKS // len(experiment.parts.surfaces))
    return fresh_seeds(experiment, count)


class _Around:
    """The walks around a winner, one parameter at a time."""

    def __init__(self, history: History, chosen: Candidate, store: Store, run: Run) -> None:
        self._experiment, self._study = history.experiment, history.study
        self._values = dict(chosen.values)
        self._store, self._run = store, run
        self._seeds = _margin_seeds(history.experiment)
        self._verdicts: dict[tuple[str, Value], Verdict] = {}
        self._numbers = [
            item
            for item in self._study.search
            if isinstance(item, Numbers) and item.path in self._values
        ]
        self._choices = [
            item
            for item in self._study.search
            if isinstance(item, Choices) and item.path in self._values
        ]

    def margins(self) -> tuple[Margins, bool]:
        """What is known after walking what `run` walks, and whether that was stopped."""
        upright = self._upright()
        if not upright:
            return Margins(), False
        stopped, complete = False, True
        while steps := list(self._steps()):
            going = self._walk_all(steps)
            self._judge(steps, upright)
            if not all(step in self._verdicts for step in steps):
                stopped, complete = not going, False
                break
        return self._found(len(upright), complete), stopped

    def _upright(self) -> frozenset[tuple[str, int]]:
        """Ground and seed of the walks in which the winner itself stays up."""
        one = self._row_experiment([tuple(self._values.values())])
        if missing(one, self._store.index()):
            self._run(one)
        walks = rerun(WINNER, one, self._store.index()).walks
        return frozenset((walk.surface, walk.seed) for walk in walks if walk.up)

    def _row_experiment(self, rows: Sequence[Sequence[Value]]) -> Experiment:
        return derived(self._experiment, "margins", tuple(self._values), rows, self._seeds)

    def _rungs(self, item: Numbers) -> dict[int, tuple[float, ...]]:
        known = self._experiment.parts.parameter(item.path)
        value = float(self._values[item.path])
        return {
            -1: ladder(item, value, -1, known.low, known.high),
            1: ladder(item, value, 1, known.low, known.high),
        }

    def _steps(self) -> Iterator[tuple[str, Value]]:
        """Every value to walk next, each parameter both ways at once."""
        for item in self._numbers:
            for rungs in self._rungs(item).values():
                walked = self._walked(item.path)
                step = next_step(item, float(self._values[item.path]), rungs, walked)
                if step is not None:
                    yield item.path, self._typed(item, step)
        for choice in self._choices:
            for option in choice.options:
                known = (choice.path, option) in self._verdicts
                if not known and option != self._values[choice.path]:
                    yield choice.path, option

    def _typed(self, item: Numbers, step: float) -> Value:
        return round(step) if item.integer else step

    def _walked(self, path: str) -> dict[float, Verdict]:
        return {float(value): v for (of, value), v in self._verdicts.items() if of == path}

    def _row(self, step: tuple[str, Value]) -> tuple[Value, ...]:
        return tuple({**self._values, step[0]: step[1]}.values())

    def _walk_all(self, steps: Sequence[tuple[str, Value]]) -> bool:
        """Walk every step that the gait does not refuse, listing those before them too."""
        for step in steps:
            if self._refused(step):
                self._verdicts[step] = "out of reach"
        tried = [*self._verdicts, *steps]
        rows = [self._row(s) for s in dict.fromkeys(tried) if not self._refused(s)]
        one = self._row_experiment([tuple(self._values.values()), *rows])
        return self._run(one) if missing(one, self._store.index()) else True

    def _refused(self, step: tuple[str, Value]) -> bool:
        """Whether the gait or robot itself refuses the values, before any trial."""
        try:
            next(plan(self._row_experiment([self._row(step)])).trials())
        except (GaitlabError, ValueError, ArithmeticError):
            return True
        return False

    def _judge(
        self, steps: Sequence[tuple[str, Value]], upright: frozenset[tuple[str, int]]
    ) -> None:
        index = self._store.index()
        for step in steps:
            if step in self._verdicts:
                continue
            walks = rerun("", self._row_experiment([self._row(step)]), index).walks
            verdict = _verdict([w for w in walks if (w.surface, w.seed) in upright])
            if verdict is not None:
                self._verdicts[step] = verdict

    def _found(self, seeds: int, complete: bool) -> Margins:
        return Margins(
            numbers=tuple(self._margin(item) for item in self._numbers),
            switches=tuple(self._switch(item) for item in self._choices),
            seeds=seeds,
            complete=complete,
        )

    def _margin(self, item: Numbers) -> Margin:
        value, rungs = float(self._values[item.path]), self._rungs(item)
        walked = self._walked(item.path)
        return Margin(
            path=item.path,
            value=value,
            below=reach(item, value, rungs[-1], walked),
            above=reach(item, value, rungs[1], walked),
        )

    def _switch(self, item: Choices) -> Switch:
        tried = [option for option in item.options if (item.path, option) in self._verdicts]
        holds = {option: self._verdicts[item.path, option] == "holds" for option in tried}
        return Switch(path=item.path, value=self._values[item.path], holds=holds)


def _verdict(walks: Sequence[Walk]) -> Verdict | None:
    """What a step amounts to; None while walks are missing."""
    states = {walk.state for walk in walks}
    if "MISSING" in states:
        return None
    if "INFEASIBLE" in states:
        return "out of reach"
    if "FAILED" in states:
        return "failed"
    return "holds" if all(walk.up for walk in walks) else "fell"
