"""The experiments that check a study's winner: ordinary ones, beside the study's own trials.

`<study>-winner` and `<study>-default` walk with fresh seeds on every ground, `<study>-margins`
around the winner. Fresh seeds are those from 1,000,000 on, which no search uses: a search's seeds
count from 0, and one that lists larger ones moves the fresh ones beyond its own.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import replace

from gaitlab.canonical import canonical_json
from gaitlab.experiment import Axis, Experiment, Value
from gaitlab.plan import plan
from gaitlab.plugins import names
from gaitlab.search import Candidate, History
from gaitlab.search.finals import final_seeds
from gaitlab.search.results import Rerun, Walk
from gaitlab.store import Index
from gaitlab.surfaces import Surface
from gaitlab.surfaces.files import load_surface

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


def missing(experiment: Experiment, index: Index) -> list[str]:
    """Trials of an experiment that a store does not hold."""
    trials = (item.trial.id for item in plan(experiment).trials())
    return [trial_id for trial_id in trials if trial_id not in index.entries]


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


def margin_seeds(experiment: Experiment) -> range:
    """The first of the fresh seeds, so that the winner's own walks are there already."""
    count = max(LEAST_MARGIN_SEEDS, MARGIN_WALKS // len(experiment.parts.surfaces))
    return fresh_seeds(experiment, count)
