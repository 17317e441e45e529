"""What `gaitlab show` says of a name and of a trial."""

from __future__ import annotations

import json
import shlex
from collections.abc import Mapping
from dataclasses import MISSING, asdict
from types import MappingProxyType
from typing import TYPE_CHECKING

from gaitlab.cli.printing import columns, duration, number, plural, wrapped

if TYPE_CHECKING:
    from gaitlab.experiment import Study
    from gaitlab.plugins import Kind
    from gaitlab.store import TrialRecord

EMPTY: Mapping[str, str] = MappingProxyType({})


def described(kind: Kind, name: str) -> str:
    """What a name stands for: its parameters with unit, range and source, or its meaning."""
    head = f"{kind} {name}"
    if kind == "gait" or kind == "robot" or kind == "balance":
        from gaitlab.plugins import load_class

        cls = load_class(kind, name)
        return f"{head}\n{_parameters_text(cls, _unchanged(cls))}"
    if kind == "surface":
        from gaitlab.surfaces.files import load_surface

        surface = load_surface(name)
        table = _parameters_text(type(surface), surface, _sources(kind, name))
        return f"{head} ({surface.type})\n{table}"
    if kind == "servo":
        from gaitlab.servos.files import load_servo

        servo = load_servo(name)
        return f"{head}\n{_parameters_text(type(servo), servo, _sources(kind, name))}"
    if kind == "motion":
        return f"{head}\n{_motion_text(name)}"
    return f"{head}\n{_metric_text(name) if kind == 'metric' else _experiment_text(name)}"


def _unchanged(cls: type) -> object | None:
    """A gait or robot as its file has it, its own nested defaults included; None if it asks."""
    from gaitlab.parameters import parameters

    return None if any(item.default is MISSING for item in parameters(cls)) else cls()


def _motion_text(name: str) -> str:
    """What a motion is, how long it lasts and what it moves."""
    from gaitlab.motions import Track, load_motion

    motion = load_motion(name)
    frames = ", ".join(frame.name for frame in motion.frames)
    length = f"{len(motion.frames)} keyframes in {Track(motion=motion).duration:g} s: {frames}"
    return "\n".join([motion.description, length, f"joints: {', '.join(motion.joints)}"])


def _sources(kind: Kind, name: str) -> dict[str, str]:
    """Where the numbers of a surface or servo file come from, as the file says."""
    from gaitlab.documents import load
    from gaitlab.plugins import locate

    nodes = load(locate(kind, name)).mapping
    described = {
        key: node.mapping["source"] for key, node in nodes.items() if "source" in node.mapping
    }
    return {key: str(source.value) for key, source in described.items()}


def _parameters_text(
    cls: type, owner: object | None = None, sources: Mapping[str, str] = EMPTY
) -> str:
    """Every parameter of a class, with the values of an object or the defaults."""
    from gaitlab.documents import allowed
    from gaitlab.parameters import get_path, parameters

    rows = []
    for item in parameters(cls):
        value = item.default if owner is None else get_path(owner, item.name)
        shown = "required" if value is MISSING else number(value)
        source = sources.get(item.name, item.source)
        rows.append([item.name, shown, item.unit, allowed(item), item.doc, source])
    return wrapped(("parameter", "value", "unit", "allowed", "meaning", "source"), rows, texts=3)


def _metric_text(name: str) -> str:
    from gaitlab.metrics import lookup

    return f"unit: {lookup(name).unit}\n{lookup(name).doc}"


def _experiment_text(name: str) -> str:
    from gaitlab.experiment import is_reproduction, load_experiment
    from gaitlab.experiment.plan import plan

    if is_reproduction(name):
        return _reproduction_text(name)
    experiment = load_experiment(name)
    planned = plan(experiment)
    lines = [
        experiment.title,
        experiment.description,
        f"file: {experiment.path}",
        f"surfaces: {', '.join(experiment.parts.surfaces)}",
        f"seeds: {len(experiment.seeds)}",
    ]
    if experiment.study is not None:
        lines += _study_lines(name, experiment.study, planned.size, planned.seconds)
    else:
        lines += [
            f"varied: {', '.join(experiment.varied) or 'nothing'}",
            f"{plural(planned.cell_count, 'cell')}, {plural(planned.size, 'trial')} of up to "
            f"{duration(planned.seconds)}",
            f"`gaitlab run {shlex.quote(name)} --dry-run` says what would run",
        ]
    return "\n".join(line for line in lines if line)


def _reproduction_text(name: str) -> str:
    """Which experiments share a page, how much there is to walk, and the page's sections."""
    from gaitlab.experiment.plan import plan
    from gaitlab.papers.reproduction import load_reproduction

    whole = load_reproduction(name)
    members = [[one.name, str(plan(one).size), one.title] for one in whole.members]
    sections = [[one.kind, one.title, ", ".join(one.experiments)] for one in whole.sections]
    lines = [
        whole.title,
        whole.description,
        f"file: {whole.path}",
        columns(["experiment", "trials", "what it is"], members),
        columns(["section", "title", "made from"], sections),
        f"`gaitlab run {shlex.quote(name)}` walks all of it, `gaitlab report {shlex.quote(name)}` "
        "writes its page; both take --quick",
    ]
    return "\n".join(line for line in lines if line)


def _study_lines(name: str, study: Study, trials: int, seconds: float) -> list[str]:
    """What is searched, for what, and how much there is to walk."""
    space = [[item.path, item.text, item.when.text if item.when else ""] for item in study.search]
    return [
        f"sampler: {study.sampler}, {plural(study.trials, 'candidate')} in batches of "
        f"{study.batch}",
        f"each candidate: up to {plural(trials, 'trial')} of up to {duration(seconds)}",
        *(f"objective: {objective.text}" for objective in study.objectives),
        *(f"constraint: {constraint.text}" for constraint in study.constraints),
        columns(["searched", "values", "only when"], space),
        f"`gaitlab optimize {shlex.quote(name)} --dry-run` says what would run",
    ]


def trial_text(record: TrialRecord) -> str:
    """How a trial ended, its metrics, and what it was made from."""
    content = asdict(record)
    rows = [[key, number(value)] for key, value in record.metrics.items()]
    head = f"trial {record.trial_id}: {record.state}"
    parts = [f"{head}\n{record.reason}".rstrip(), columns(("metric", "value"), rows)]
    rest = {key: content[key] for key in ("trial", "provenance")}
    return "\n\n".join([*parts, json.dumps(rest, indent=2)])
