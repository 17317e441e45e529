"""Everything the page of a study says, gathered from its database and its store."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress

from gaitlab.errors import UnknownName
from gaitlab.experiment import Experiment, Value
from gaitlab.experiment.shell import called
from gaitlab.report.markdown import code, escape
from gaitlab.report.provenance import common_values, seeds_text
from gaitlab.report.sources import PROVENANCE
from gaitlab.report.study.findings import Findings
from gaitlab.search import History
from gaitlab.search.database import command_line, history
from gaitlab.search.fresh import (
    DEFAULT,
    RANDOM,
    Rerun,
    fresh_seeds,
    random_sibling,
    rerun,
    winner_experiment,
)
from gaitlab.search.sampling import importance
from gaitlab.search.validation import Validation, validate, walk_nothing
from gaitlab.simulation.trial import PHYSICS_VERSION
from gaitlab.store import Index, Store

LEAST = 8  # candidates; importance of fewer is noise


def findings_of(experiment: Experiment, store: Store, storage: str | None = None) -> Findings:
    """What a study has found so far, as its database and its store say.

    Raises:
        UnknownName: If it was never searched.
        StoreError: If the database cannot be read.
    """
    past = history(experiment, store, storage)
    checked = validate(past, store, walk_nothing)
    chance, index = _chance(experiment, store, storage), store.index()
    walked = {trial_id for candidate in past.candidates for trial_id in candidate.trial_ids}
    records = (store.record(trial_id) for trial_id in walked if trial_id in index.entries)
    times = (record.provenance.get("wall_time") for record in records)
    wall = sum(float(time) for time in times if isinstance(time, (int, float)))
    return Findings(
        experiment=experiment,
        candidates=past.candidates,
        best=past.best,
        front=past.front,
        finals=past.finals,
        chosen=checked.chosen if checked else None,
        importance=_importance(past),
        used=past.used,
        planned=past.planned,
        wall=wall,
        defaults={item.path: _default(experiment, item.path) for item in past.study.search},
        reruns=tuple(_reruns(checked, chance, store)),
        margins=checked.margins if checked else None,
        drawn=len(chance.candidates) if chance is not None else 0,
        called=called(experiment.path),
        facts=_facts(past, index),
        commands=[
            command_line(verb, experiment, store, storage) for verb in ("optimize", "report")
        ],
    )


def _importance(past: History) -> list[Mapping[str, float]]:
    """Importance for each objective; empty mappings while too few are finished."""
    walked = sum(candidate.state != "infeasible" for candidate in past.candidates)
    if walked < LEAST:
        return []
    return [importance(past, place) for place in range(len(past.study.objectives))]


def _default(experiment: Experiment, path: str) -> Value | None:
    found = experiment.parts.base_values(path)
    return found[0] if len(found) == 1 else None


def _reruns(checked: Validation | None, chance: History | None, store: Store) -> Iterator[Rerun]:
    """What was walked on fresh seeds, so far as any of it was."""
    found = [*(checked.reruns if checked else ())]
    chosen = chance.representative if chance is not None else None
    if chance is not None and chosen is not None:
        found.append(rerun(RANDOM, winner_experiment(chance, chosen), store.index()))
    for one in found:
        if one.label == DEFAULT or any(walk.state != "MISSING" for walk in one.walks):
            yield one


def _chance(experiment: Experiment, store: Store, storage: str | None) -> History | None:
    """The search at random with the same budget, if there was one."""
    with suppress(UnknownName):
        return history(random_sibling(experiment), store, storage)
    return None


def _facts(past: History, index: Index) -> dict[str, str]:
    experiment, study = past.experiment, past.study
    options = ", ".join(f"{name} {value}" for name, value in study.sampler_options.items())
    rounds = ", ".join(map(str, study.racing.rounds)) if study.racing else "off"
    return {
        "study": f"{escape(experiment.name)}, digest {code(experiment.digest[:16])}",
        "sampler": escape(f"{study.sampler} {options}".strip()) + f", seed {study.seed}",
        "candidates": f"{len(past.candidates)} of {study.trials}, in batches of {study.batch}",
        "seeds of the search": seeds_text(experiment.seeds),
        "racing after seeds": rounds,
        "fresh seeds": seeds_text(fresh_seeds(experiment)),
        "physics version": str(PHYSICS_VERSION),
        **{k.replace("_", " "): v for k, v in common_values(_records(past, index)).items()},
    }


def _records(past: History, index: Index) -> Iterator[dict[str, object]]:
    """Provenance of the trials of the search, without what differs from run to run."""
    for candidate in past.candidates:
        for trial_id in candidate.trial_ids:
            entry = index.entries.get(trial_id)
            if entry is not None:
                known = entry.details.provenance
                yield {name: known[name] for name in PROVENANCE if name in known}
