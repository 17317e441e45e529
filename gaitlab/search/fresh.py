"""The experiments that check a study's winner: ordinary ones, beside the study's own trials.

`<study>-winner` and `<study>-default` walk with fresh seeds on every ground, `<study>-margins`
around the winner, all in the engine that confirms the study; where that is not the one it searched
in, the winner walks in both. Fresh seeds are those from 1,000,000 on, which no search uses: a
search's seeds count from 0, and one that lists larger ones moves the fresh ones beyond its own.
What is in the store is never walked again, so a check goes on where it was stopped.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

from gaitlab.experiment import Axis, Experiment, Value, study_of
from gaitlab.experiment.plan import plan
from gaitlab.parameters import canonical_json
from gaitlab.plugins import names
from gaitlab.search.candidates import Candidate, History
from gaitlab.search.final import confirming, final_seeds
from gaitlab.search.objectives import TrialOutcome, stored_outcome
from gaitlab.store import Index
from gaitlab.surfaces import Surface
from gaitlab.surfaces.files import load_surface

Run: TypeAlias = Callable[[Experiment], bool]  # runs what is missing; False when it was stopped
WINNER, DEFAULT, RANDOM = "winner", "hand-set default", "best of random search"
SEARCHED = "winner in the engine of the search"
FIRST_FRESH = 1_000_000  # seeds from here on are kept for checking
FRESH_SEEDS = 10  # of a check, or as many as the study itself uses
MARGIN_WALKS = 4  # at every step around the winner, on all grounds together
LEAST_MARGIN_SEEDS = 2  # on each ground


def fresh_seeds(experiment: Experiment, count: int | None = None) -> range:
    """Seeds that the search and its final never saw."""
    first = max(FIRST_FRESH, max(final_seeds(experiment)) + 1)
    return range(first, first + (count or max(FRESH_SEEDS, len(experiment.seeds))))


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
    values = [list(paths), list(rows)]
    content = [experiment.digest, role, values, list(seeds), list(parts.surfaces)]
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
    """The same study with values drawn at random, to tell whether its sampler beats chance."""
    content = ["random", experiment.digest]
    return replace(
        experiment,
        name=f"{experiment.name}-random",
        digest=hashlib.sha256(canonical_json(content).encode()).hexdigest(),
        study=replace(study_of(experiment), sampler="random", sampler_options={}),
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
    return walked_again(history.experiment, chosen)


def walked_again(experiment: Experiment, chosen: Candidate) -> Experiment:
    """The winner of a study with fresh seeds on every ground."""
    return _winner(confirming(experiment), chosen, "winner")


def searched_experiment(history: History, chosen: Candidate) -> Experiment | None:
    """The same in the engine of the search; None where that is the one that confirms."""
    experiment = history.experiment
    engine = experiment.parts.engine.name
    if engine == confirming(experiment).parts.engine.name:
        return None
    return _winner(experiment, chosen, f"winner-{engine}")


def _winner(experiment: Experiment, chosen: Candidate, role: str) -> Experiment:
    rows, seeds = [tuple(chosen.values.values())], fresh_seeds(experiment)
    return derived(experiment, role, tuple(chosen.values), rows, seeds, grounds(experiment))


def default_experiment(experiment: Experiment) -> Experiment:
    """The experiment's own values with fresh seeds on every ground."""
    wanted = confirming(experiment)
    return derived(wanted, "default", (), (), fresh_seeds(experiment), grounds(experiment))


def margin_seeds(experiment: Experiment) -> range:
    """The first of the fresh seeds, so that the winner's own walks are there already."""
    count = max(LEAST_MARGIN_SEEDS, MARGIN_WALKS // len(experiment.parts.surfaces))
    return fresh_seeds(experiment, count)


@dataclass(frozen=True, kw_only=True)
class Rerun:
    """A combination of values on seeds that the search never saw.

    Attributes:
        label: What the combination is.
        values: Value by dotted path.
        walks: Its trials on every ground.
    """

    label: str
    values: Mapping[str, Value]
    walks: tuple[TrialOutcome, ...]

    def on(self, surfaces: Sequence[str]) -> tuple[TrialOutcome, ...]:
        """Trials on some grounds that have ended with a result."""
        there = (walk for walk in self.walks if walk.state in ("DONE", "INFEASIBLE"))
        return tuple(walk for walk in there if walk.surface in surfaces)


def rerun(label: str, experiment: Experiment, index: Index) -> Rerun:
    """An experiment of one combination as the store has it."""
    trials = list(plan(experiment).trials())
    values = {path: value for path, value in trials[0].values.items() if path != "surface"}
    walks = tuple(stored_outcome(item, index) for item in trials)
    return Rerun(label=label, values=values, walks=walks)
