"""From experiments and a store to the table that a report is computed from."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import pandas as pd

from gaitlab.errors import NothingRun, UsageError, WrongValue
from gaitlab.experiment import NO_BALANCE, Experiment
from gaitlab.experiment.experiment import ENGINE
from gaitlab.experiment.plan import plan
from gaitlab.experiment.reference import ReferenceTable, load_reference
from gaitlab.experiment.shell import command
from gaitlab.model.settings import SETTINGS
from gaitlab.parameters import values
from gaitlab.report.results import ONE_ROW, Results
from gaitlab.report.variants import Value, Variant, find_variants, free_paths
from gaitlab.report.words import plural
from gaitlab.simulation.trial import CODED, Plugin, Trial
from gaitlab.store import Store

MOST_TRIALS = 1_000_000  # planned ones; a table beyond it fits no page
EXPERIMENT = "experiment"  # column of the trials; a variant where nothing else differs
OUTCOMES = (
    *("stable", "stable_strict", "fell", "fell_standing"),
    *("fall_direction", "fall_phase", "time_to_fall"),
)
NEEDED = ("reason", "distance", *OUTCOMES)  # columns that a store without a done trial lacks


def gather(experiments: Sequence[Experiment], store: Store) -> Results:
    """Every planned trial of the experiments with its outcome.

    Raises:
        NothingRun: If none of the trials is in the store.
        UsageError: If the experiments cannot share a table.
        UnknownName: If `report.compare` is no reference table.
    """
    first = experiments[0]
    rows, columns = first.report.rows, first.report.columns
    _require_one_layout(experiments)
    _require_own_names(experiments)
    planned = _planned(experiments, rows, columns)
    trials = _with_outcomes(planned, store, experiments)
    if rows == columns:
        rows, trials[ONE_ROW] = ONE_ROW, "all"
    chosen = [path for e in experiments for path in e.report.variants]
    if chosen and ENGINE in trials.columns:
        chosen.append(ENGINE)  # runs of two engines are no replicates of each other
    paths = free_paths(trials, chosen or list(_candidates(planned)), [rows, columns])
    paths = _told_apart(trials, paths, [rows, columns])
    if EXPERIMENT not in paths:
        trials = trials.drop_duplicates(["trial_id", "surface"], ignore_index=True)
    units = _units(experiments)
    variants, labels = find_variants(trials, paths, units)
    own = _own_labels(experiments, trials.assign(variant=labels))
    variants = [replace(v, label=own.get(v.label, v.label)) for v in variants]
    trials = trials.assign(variant=[own.get(label, label) for label in labels])
    usual = (next(iter(table.readings)) for table in _references(first))
    reading = first.report.distance_reading or next(usual, "")
    return Results(
        title=" and ".join(dict.fromkeys(e.report.title or e.title or e.name for e in experiments)),
        question=" ".join(e.description for e in experiments if e.description) or _question(trials),
        rows=rows,
        columns=columns,
        variants=tuple(_compared(experiments, trials, variants)),
        reading=reading,
        units=units,
        metrics=tuple(dict.fromkeys(name for e in experiments for name in e.report.metrics)),
        maps=tuple(dict.fromkeys(pair for e in experiments for pair in e.report.maps)),
        trials=trials,
        log=store.log,
        trial=lambda trial_id: _trial(store.record(trial_id).trial, experiments),
    )


def _trial(recorded: Mapping[str, Any], experiments: Sequence[Experiment]) -> Trial:
    """The trial of a record, made with the code of its experiment wherever the record found it."""
    walkers = [parts for e in experiments for parts in e.walkers.values() or [e.parts]]
    known = {code.identity: code for parts in walkers for code in parts.codes}
    data = dict(recorded)
    for kind in CODED:
        if kind in data:
            data[kind] = {**data[kind], "code": _known(data[kind]["code"], known)}
    if "metrics" in data:
        data["metrics"] = [_known(code, known) for code in data["metrics"]]
    return Trial.from_dict(data)


def _known(code: Mapping[str, Any], known: Mapping[str, Plugin]) -> Mapping[str, Any]:
    found = Plugin.from_dict(code)
    if found.digest is None:
        return code
    if found.identity not in known:
        raise WrongValue(
            f"a trial of the store names {found.name}, which is not the code of its experiment, so "
            "it is not run; run the experiment into another --store"
        )
    return known[found.identity].to_dict()


def _units(experiments: Sequence[Experiment]) -> dict[str, str]:
    """SI unit of everything that is varied; names, files and ratios have none."""
    varied = {
        path: e.parts
        for e in experiments
        for path in (*e.varied, e.report.rows, e.report.columns)
        if "." in path
    }
    units = {path: parts.parameter(path).unit for path, parts in varied.items()}
    return {path: "-" if unit == "file" else unit for path, unit in units.items()}


def _told_apart(trials: pd.DataFrame, paths: list[str], fixed: Sequence[str]) -> list[str]:
    """The paths, and the experiment where nothing else tells two trials of one place apart.

    Experiments may differ in a servo, a ground or a file of the user's own, which are no paths.
    """
    place = list(dict.fromkeys((*fixed, "surface", "seed", *paths)))
    once = trials.drop_duplicates([*place, EXPERIMENT, "trial_id"])
    between = once.groupby(place, dropna=False, sort=False)
    alike = (between[EXPERIMENT].nunique() > 1) & (between["trial_id"].nunique() > 1)
    return [EXPERIMENT, *paths] if alike.any() else paths


def _own_labels(experiments: Sequence[Experiment], trials: pd.DataFrame) -> dict[str, str]:
    """Labels that experiments give their variants, by those that they have of themselves.

    An experiment with several variants puts its label before theirs. A variant that several
    experiments walk keeps its own, and so do all where two would be called the same.
    """
    given = {e.name: e.report.label for e in experiments if e.report.label}
    walkers = {str(label): set(part["experiment"]) for label, part in trials.groupby("variant")}
    alone = {label: names.pop() for label, names in walkers.items() if len(names) == 1}
    count = Counter(alone.values())
    own = {
        label: given[name] if count[name] == 1 else f"{given[name]}: {label}"
        for label, name in alone.items()
        if name in given
    }
    shown = [own.get(label, label) for label in walkers]
    return own if len(set(shown)) == len(shown) else {}


def _require_own_names(experiments: Sequence[Experiment]) -> None:
    digests: dict[str, str] = {}
    for experiment in experiments:
        if digests.setdefault(experiment.name, experiment.digest) != experiment.digest:
            raise UsageError(
                f"two different experiments are called {experiment.name}; give one of them "
                "another `name:` so that the report can tell them apart"
            )


def _require_one_layout(experiments: Sequence[Experiment]) -> None:
    first = experiments[0].report
    for other in experiments[1:]:
        for key in ("rows", "columns", "distance_reading"):
            here, there = getattr(first, key), getattr(other.report, key)
            if here != there:
                raise UsageError(
                    f"{experiments[0].name} has report.{key} {here!r} and {other.name} {there!r}; "
                    "experiments share a report when these agree, else report them one by one"
                )


def _planned(experiments: Sequence[Experiment], rows: str, columns: str) -> pd.DataFrame:
    """One row a planned trial with every value that the experiments do not share."""
    for experiment in experiments:
        if plan(experiment).size > MOST_TRIALS:
            raise UsageError(
                f"{experiment.name} plans {plan(experiment).size} trials; a report shows at most "
                f"{MOST_TRIALS}; split the grid"
            )
    bases = [_base(experiment) for experiment in experiments]
    asked = [path for path in _walked_in(experiments) if path in bases[0]]
    paths = dict.fromkeys((rows, columns, *asked, *_unshared(experiments, bases)))
    frame = pd.DataFrame(
        row
        for experiment, base in zip(experiments, bases, strict=True)
        for row in _rows(experiment, base, list(paths))
    )
    return frame.drop_duplicates(["trial_id", "surface", EXPERIMENT], ignore_index=True)


def _rows(
    experiment: Experiment, base: Mapping[str, Value], paths: Sequence[str]
) -> Iterator[dict[str, object]]:
    for item in plan(experiment).trials():
        named = {"trial_id": item.trial.id, "experiment": experiment.name, "seed": item.trial.seed}
        known = {**base, **item.values}
        yield {**named, "surface": item.values["surface"], **{p: known.get(p) for p in paths}}


def _question(trials: pd.DataFrame) -> str:
    """What was asked, said from the plan, when the file does not say it."""
    grounds, seeds = trials["surface"].nunique(), trials["seed"].nunique()
    return (
        f"Which of {plural(len(trials), 'planned walk')} on {plural(grounds, 'ground')}, with "
        f"{plural(seeds, 'seed')} each, keep the robot on its feet?"
    )


def base_trial(experiment: Experiment) -> Trial:
    """First trial of the plan, which stands for what is not varied."""
    return next(plan(experiment).trials()).trial


def base_trials(experiment: Experiment) -> list[Trial]:
    """First trial of every walker, in the order of the file."""
    if not experiment.walkers:
        return [base_trial(experiment)]
    first: dict[str, Trial] = {}
    for item in plan(experiment).trials():
        first.setdefault(str(item.values["robot"]), item.trial)
    return list(first.values())


def _base(experiment: Experiment) -> dict[str, Value]:
    """Values that an experiment does not vary, by dotted path."""
    trial = base_trial(experiment)
    parts: dict[str, object] = {
        "robot": trial.robot,
        "gait": trial.gait,
        "surface": trial.surface,
    }
    settings = {name: getattr(trial, name) for name in SETTINGS}
    names = {"robot": trial.names.robot, "gait": trial.names.gait}
    known: dict[str, Value] = {**names, "balance": trial.names.balance or NO_BALANCE}
    if trial.balance is not None:
        parts["balance"] = trial.balance
    for group, owner in {**parts, **settings}.items():
        for path, value in values(owner).items():
            if isinstance(value, (bool, int, float, str)):
                known[f"{group}.{path}"] = value
    return known


def _unshared(
    experiments: Sequence[Experiment], bases: Sequence[Mapping[str, Value]]
) -> Iterator[str]:
    """Paths that any experiment varies, and those in which their bases differ."""
    for experiment in experiments:
        yield from experiment.varied
    for path in dict.fromkeys(path for base in bases for path in base):
        differs = len({repr(base.get(path)) for base in bases}) > 1
        switched = path.startswith("balance.") and not all(path in base for base in bases)
        if differs and not switched and not path.startswith("surface."):
            yield path


def _candidates(planned: pd.DataFrame) -> Iterator[str]:
    fixed = ("trial_id", "experiment", "seed", "surface")
    return (str(name) for name in planned.columns if name not in fixed)


def _with_outcomes(
    planned: pd.DataFrame, store: Store, experiments: Sequence[Experiment]
) -> pd.DataFrame:
    """The plan with state and metrics of every trial in the store, whoever asked for it there."""
    stored = store.outcomes(planned["trial_id"])
    known = [name for name in stored.columns if name == "trial_id" or name not in planned.columns]
    trials = planned.merge(stored[known], on="trial_id", how="left", validate="many_to_one")
    if trials["state"].isna().all():
        raise NothingRun(
            f"the store {store.path} holds no trial of {' and '.join(e.name for e in experiments)} "
            "as it stands; run "
            f"`{command('run', experiments[:1], store.path)}` first"
        )
    trials["state"] = trials["state"].fillna("MISSING")
    missing = [name for name in NEEDED if name not in trials.columns]
    return trials.assign(**dict.fromkeys(missing))


def _references(experiment: Experiment) -> list[ReferenceTable]:
    """The reference table that an experiment names, and those of other variants beside it."""
    name, folder = experiment.report.compare, experiment.path.parent
    if name is None:
        return []
    first = load_reference(name, folder)
    return [first, *(load_reference(other, folder) for other in first.content.others)]


def _walked_in(experiments: Sequence[Experiment]) -> dict[str, None]:
    """Paths by which a variant is told to stand beside one of its tables."""
    tables = [table for experiment in experiments for table in _references(experiment)]
    return {path: None for table in tables for path in table.content.variant or {}}


def _compared(
    experiments: Sequence[Experiment], trials: pd.DataFrame, variants: Sequence[Variant]
) -> Iterator[Variant]:
    """The variants with the reference table that their experiment sets them beside."""
    tables: dict[str, ReferenceTable | None] = {}
    for experiment in experiments:
        tables |= _tables(experiment, trials[trials["experiment"] == experiment.name])
    return (replace(variant, compare=tables.get(variant.label)) for variant in variants)


def _tables(experiment: Experiment, trials: pd.DataFrame) -> dict[str, ReferenceTable | None]:
    """Reference table by label of the variants of an experiment.

    A single variant stands beside the table that the file names, each of several beside the one
    whose walks had its values.
    """
    tables = _references(experiment)
    firsts = trials.drop_duplicates("variant").to_dict("records") if tables else []
    if len(firsts) == 1:
        return {str(firsts[0]["variant"]): tables[0]}
    named = ({str(key): value for key, value in first.items()} for first in firsts)
    return {
        str(first["variant"]): next((t for t in tables if t.answers(first)), None)
        for first in named
    }
