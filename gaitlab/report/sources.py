"""Where the results of a report come from: experiments, stored records and parameters."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Sequence
from dataclasses import is_dataclass

import pandas as pd

from gaitlab.documents import Node, parse
from gaitlab.experiment import Experiment, changed
from gaitlab.experiment.shell import command, store_option
from gaitlab.model.balance import Balance
from gaitlab.model.servo import Servo
from gaitlab.model.settings import LATE
from gaitlab.parameters import parameters, values
from gaitlab.report.gather import base_trial, base_trials
from gaitlab.report.markdown import code, escape, table
from gaitlab.report.page import Sources
from gaitlab.report.provenance import (
    DescribedPart,
    common_values,
    ground_notes,
    ground_table,
    seeds_text,
    servo_notes,
)
from gaitlab.report.results import Results
from gaitlab.report.variants import value_text
from gaitlab.report.words import NOTHING, plural, surface_text
from gaitlab.simulation.trial import PHYSICS_VERSION, Trial
from gaitlab.store import Store

PROVENANCE = (
    *("gaitlab_version", "engine", "engine_version"),
    "pybullet_version",  # in results from before there was another engine
    *("numpy_version", "numba_version", "python_version", "platform", "processor"),
)
TELLING = ("name", "title", "description", "report")  # keys of a file that change no trial
MOST_DIFFERENCES = 8  # rows
MACHINE = ("git_commit", "host")


def sources(experiments: Sequence[Experiment], store: Store, results: Results) -> Sources:
    """Digests, versions, seeds and parameters of everything that took part."""
    runs = [command("run", [experiment], store.path) for experiment in experiments]
    grounds = {
        surface_text(name): ground
        for experiment in experiments
        for name, ground in experiment.parts.surfaces.items()
    }
    return Sources(
        facts=_facts(experiments, results),
        parts=list(_parts(experiments, results)),
        grounds=ground_table(grounds),
        command="\n".join([*runs, command("report", experiments, store.path)]),
        runs="\n".join(runs),
        with_seeds=lambda seeds: _with_seeds(experiments, store, seeds),
        differences=differences(experiments),
        options="".join(f" {shlex.quote(word)}" for word in store_option(store.path)),
    )


def differences(experiments: Sequence[Experiment]) -> str:
    """What differs in the files of experiments that share a page, a column each; empty if nothing.

    How results are laid out and described makes no difference.
    """
    files = [dict(_leaves(parse(e.text, e.path))) for e in experiments]
    keys = dict.fromkeys(key for file in files for key in file)
    apart = [key for key in keys if len({file.get(key) for file in files}) > 1]
    rows = [[code(key), *(escape(file.get(key, NOTHING)) for file in files)] for key in apart]
    if len({e.form for e in experiments}) > 1:
        rows.append(["options", *(escape(e.form or NOTHING) for e in experiments)])
    if len(experiments) < 2 or not rows:
        return ""
    head = ["what differs", *(escape(e.report.label or e.name) for e in experiments)]
    rest = len(rows) - MOST_DIFFERENCES
    text = table(head, rows[:MOST_DIFFERENCES], "l" * len(head))
    return text if rest <= 0 else f"{text}\n\n{plural(rest, 'further difference')} not shown."


def _leaves(node: Node, path: str = "") -> Iterator[tuple[str, str]]:
    """Every value of a file by its dotted path, lists as one value."""
    for key, inner in node.mapping.items():
        below = f"{path}{key}"
        if inner.mapping:
            yield from () if below in TELLING else _leaves(inner, f"{below}.")
        elif below not in TELLING:
            yield below, _written(inner)


def _written(node: Node) -> str:
    if node.mapping:
        return ", ".join(f"{key} {_written(inner)}" for key, inner in node.mapping.items())
    return ", ".join(map(_written, node.items)) if node.items else value_text(node.value)


def _with_seeds(experiments: Sequence[Experiment], store: Store, seeds: int) -> str:
    """What simulates and reports the experiments with so many seeds a cell."""
    option = ("--seeds", str(seeds))
    runs = [command("run", [experiment], store.path, *option) for experiment in experiments]
    return "\n".join([*runs, command("report", experiments, store.path, *option)])


def _facts(experiments: Sequence[Experiment], results: Results) -> dict[str, str]:
    digests = {f"experiment {e.name}": f"digest {code(e.digest[:16])}" for e in experiments}
    states = results.trials["state"].value_counts()
    order = ("DONE", "INFEASIBLE", "FAILED", "MISSING")
    counts = [f"{int(states[name])} {name.lower()}" for name in order if name in states.index]
    return {
        **digests,
        **{name: digest for experiment in experiments for name, digest in _files(experiment)},
        "trials": f"{plural(len(results.trials), 'trial')} planned: {', '.join(counts)}",
        "seeds": seeds_text(int(seed) for seed in results.trials["seed"]),
        "physics version": str(PHYSICS_VERSION),
        **{k.replace("_", " "): v for k, v in common_values(records(results)).items()},
    }


def _files(experiment: Experiment) -> Iterator[tuple[str, str]]:
    """Files that are varied, by name, and the digest of what each of them holds."""
    for axis in experiment.axes:
        for path, *column in zip(axis.paths, *axis.rows, strict=True):
            group, _, name = path.partition(".")
            owner = getattr(experiment.parts, group, None)
            if not name or not is_dataclass(owner) or isinstance(owner, type):
                continue  # a group of all joints or of all grounds, which holds no file
            for item in parameters(type(owner)):
                if name in item.contents_of:
                    for value in dict.fromkeys(column):
                        held = getattr(changed(owner, {name: value}), item.name)
                        yield f"file {value_text(value)}", f"digest {code(held[:16])}"


def records(results: Results) -> Iterator[dict[str, object]]:
    """What the store knows of the runs, one mapping a trial that ran."""
    ran = results.trials[results.trials["state"] != "MISSING"]
    names = [name for name in (*PROVENANCE, *MACHINE) if name in ran.columns]
    for row in ran[names].to_dict("records"):
        yield {str(name): value for name, value in row.items() if not pd.isna(value)}


def _parts(experiments: Sequence[Experiment], results: Results) -> Iterator[DescribedPart]:
    """Gait, robot, servos, grounds and settings of the first experiment, each once."""
    varied = frozenset(_varied(experiments, results))
    for trial in base_trials(experiments[0]):
        names = trial.names
        of = f" of {names.robot}" if experiments[0].walkers else ""
        yield DescribedPart(
            title=f"gait {names.gait}{of}", path="gait", value=trial.gait, varied=varied
        )
        yield DescribedPart(
            title=f"robot {names.robot}", path="robot", value=trial.robot, varied=varied
        )
        for name, told, servo in _servos(trial):
            notes = servo_notes(trial.robot, name, experiments[0].path.parent)
            title = f"servo {told}{of}"
            yield DescribedPart(title=title, path="servo", value=servo, varied=varied, notes=notes)
    yield from _balance_parts(experiments, varied)
    yield from _ground_parts(experiments, varied)
    trial = base_trial(experiments[0])
    for path in ("horizon", "spread", "engine", *LATE):
        value = getattr(trial, path)
        if path not in LATE or values(value) or any(p.startswith(f"{path}.") for p in varied):
            yield DescribedPart(title=path, path=path, value=value, varied=varied)


def _balance_parts(
    experiments: Sequence[Experiment], varied: frozenset[str]
) -> Iterator[DescribedPart]:
    """Every balance controller, once; the first trial of a page may well have none."""
    found: dict[tuple[str, Balance], str] = {}
    for experiment in experiments:
        for parts in experiment.walkers.values() or [experiment.parts]:
            if parts.balance is not None:
                found.setdefault((parts.balance_name, parts.balance), experiment.name)
    for (name, balance), first in found.items():
        title = f"balance {name} of {first}" if len(found) > 1 else f"balance {name}"
        yield DescribedPart(title=title, path="balance", value=balance, varied=varied)


def _ground_parts(
    experiments: Sequence[Experiment], varied: frozenset[str]
) -> Iterator[DescribedPart]:
    """Every ground, once, with the notes of its file."""
    seen: set[str] = set()
    for experiment in experiments:
        notes = ground_notes(experiment)
        for name, ground in experiment.parts.surfaces.items():
            title = f"ground {surface_text(name)}"
            if title not in seen:
                yield DescribedPart(
                    title=title, path="surface", value=ground, varied=varied, notes=notes[name]
                )
            seen.add(title)


def _varied(experiments: Sequence[Experiment], results: Results) -> Iterator[str]:
    """Paths that differ among the trials of the page."""
    for experiment in experiments:
        yield from experiment.varied
    for variant in results.variants:
        yield from variant.values


def _servos(trial: Trial) -> Iterator[tuple[str, str, Servo]]:
    """Name, title and numbers of every servo type, once; by joints where a gait set gains."""
    where: dict[str, dict[Servo, list[str]]] = {}
    driven = [joint for joint in trial.robot.tree.joints if joint.servo is not None]
    for joint, servo in zip(driven, trial.servos, strict=True):
        where.setdefault(str(joint.servo), {}).setdefault(servo, []).append(joint.name)
    for name, kinds in where.items():
        for servo, joints in kinds.items():
            yield name, name if len(kinds) == 1 else f"{name} of {', '.join(joints)}", servo
