"""`gaitlab list` and `show`: what there is and what it means."""

from __future__ import annotations

import ast
import json
import shlex
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import MISSING, asdict
from enum import Enum
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, cast

import typer

from gaitlab.cli.options import DEFAULT_STORE, StoreFolder, completed, names_of
from gaitlab.cli.printing import (
    columns,
    duration,
    number,
    other_output_on_stderr,
    plural,
    say,
    wrapped,
)
from gaitlab.cli.trial_lookup import complete_trials
from gaitlab.errors import FileError, UnknownName

if TYPE_CHECKING:
    from gaitlab.experiment import Study
    from gaitlab.model.foreign.robot import ForeignRobot
    from gaitlab.plugins import Kind
    from gaitlab.store import TrialRecord

CLASSES: Mapping[str, Kind] = MappingProxyType({"Robot": "robot", "Balance": "balance"})


class Plural(str, Enum):
    """What can be listed."""

    robots = "robots"
    gaits = "gaits"
    surfaces = "surfaces"
    servos = "servos"
    balance = "balance"
    metrics = "metrics"
    motions = "motions"
    experiments = "experiments"
    studies = "studies"

    @property
    def singular(self) -> str:
        """One of them, `study` for instance."""
        if self is Plural.studies:
            return "study"
        return self.value.removesuffix("s")


def _kind(text: str) -> Plural:
    """A kind in the plural or the singular."""
    for kind in Plural:
        if text in (kind.value, kind.singular):
            return kind
    raise typer.BadParameter(f"found {text!r}; allowed is one of {', '.join(Plural.__members__)}")


def list_names(
    kind: Annotated[
        Plural | None,
        typer.Argument(
            metavar="KIND",
            parser=_kind,
            help=f"{', '.join(Plural.__members__)}.",
            autocompletion=completed(lambda: Plural.__members__),
        ),
    ] = None,
) -> int:
    """List the names that experiments can use, all kinds or one.

    \b
    Example:
      gaitlab list surfaces
    """
    if kind is Plural.metrics:
        from gaitlab.metrics import lookup

        found = [lookup(name) for name in _names(kind)]
        rows = [[each.name, each.unit, each.doc.partition("\n")[0]] for each in found]
        say(wrapped(["metric", "unit", "what it is"], rows, texts=1))
    elif kind is not None:
        rows = [[name, _summary(_file_kind(kind), name)] for name in _names(kind)]
        say(wrapped([kind.singular, "what it is"], rows, texts=1))
    else:
        for each in Plural:
            say(f"{each.value}: {', '.join(_names(each))}")
    return 0


def _file_kind(kind: Plural) -> Kind:
    return cast("Kind", "experiment" if kind is Plural.studies else kind.singular)


def _names(kind: Plural) -> list[str]:
    if kind is Plural.studies:
        from gaitlab.experiment import studies

        return studies()
    return names_of(_file_kind(kind))


def _summary(kind: Kind, name: str) -> str:
    """What a name stands for in a line, empty when its file does not say."""
    from gaitlab.documents import load
    from gaitlab.plugins import locate

    path = locate(kind, name)
    if path.suffix == ".py":
        return (ast.get_docstring(ast.parse(path.read_bytes())) or "").partition("\n")[0]
    try:
        found = load(path).mapping
    except FileError as error:
        return f"wrong file: {error.problems[0].message}"
    described = found.get("title" if kind == "experiment" else "description")
    text = " ".join(str(described.value).split()) if described else ""
    kinds = (key for key in ("study", "reproduction") if kind == "experiment" and key in found)
    return ": ".join([*kinds, text])


def _all_names() -> list[str]:
    from gaitlab.plugins import KINDS

    return names_of(*KINDS)


def _complete(context: typer.Context, incomplete: str) -> list[str]:
    """Names, and below the experiments of the store their trials."""
    return [*completed(_all_names)(incomplete), *complete_trials(context, incomplete)]


def _is_file(name: str) -> bool:
    """Whether a file is meant; the address of a trial has slashes too, and numbers with points."""
    from gaitlab.plugins import SUFFIXES, is_file_name

    known = {suffix for suffixes in SUFFIXES.values() for suffix in suffixes}
    return is_file_name(name) and (Path(name).suffix.lower() in known or Path(name).exists())


def show(
    name: Annotated[
        str,
        typer.Argument(
            metavar="NAME|TRIAL",
            help="A name from `gaitlab list`, a file, or a trial: its first digits, or "
            "EXPERIMENT/VALUE/.../SEED.",
            autocompletion=_complete,
        ),
    ],
    store: StoreFolder = DEFAULT_STORE,
) -> int:
    """Show the parameters behind a name with unit, range and source, or the record of a trial.

    \b
    Example:
      gaitlab show grass_50mm
    """
    from gaitlab.model.settings import SETTINGS
    from gaitlab.plugins import KINDS, names, nearest
    from gaitlab.store import Store
    from gaitlab.store.addresses import is_address, trial_at

    kinds = [kind for kind in KINDS if name in names(kind)]
    if kinds or _is_file(name):
        with other_output_on_stderr():
            texts = [described(kind, name) for kind in kinds or [_kind_of_file(name)]]
        say("\n\n".join(texts))
        return 0
    results = Store(store)
    if name in SETTINGS:
        section = SETTINGS[name]
        say(f"section {name} of an experiment\n{_parameters_text(section, section())}")
        return 0
    if is_address(results, name):
        say(trial_text(results.record(trial_at(results, name))))
        return 0
    near = nearest(name, sorted({known for kind in KINDS for known in names(kind)}))
    raise UnknownName(
        f"nothing is called {name!r}{near}; `gaitlab list` gives every name, and a trial is "
        "named by at least 4 of its first digits or its place, EXPERIMENT/VALUE/.../SEED"
    )


def _kind_of_file(name: str) -> Kind:
    """What a file defines: Python is told by its class, YAML by its keys, a URDF by its ending."""
    from gaitlab.documents import load
    from gaitlab.model.servo import Servo
    from gaitlab.parameters import parameter_table

    path, text = Path(name), ""
    if path.suffix == ".py":
        with suppress(OSError):  # whoever loads it says what is wrong with it
            text = path.read_text(encoding="utf-8", errors="replace")
        return next((kind for name, kind in CLASSES.items() if f"class {name}" in text), "gait")
    if path.suffix.lower() in (".urdf", ".xacro"):
        return "robot"
    keys = set(load(path).mapping)
    if "urdf" in keys:
        return "robot"
    if "type" in keys or "frames" in keys:
        return "surface" if "type" in keys else "motion"
    return "servo" if keys & set(parameter_table(Servo)) else "experiment"


EMPTY: Mapping[str, str] = MappingProxyType({})


def described(kind: Kind, name: str) -> str:
    """What a name stands for: its parameters with unit, range and source, or its meaning."""
    head = f"{kind} {name}"
    if kind == "gait" or kind == "robot" or kind == "balance":
        from gaitlab.plugins import load_class

        cls = load_class(kind, name)
        text = f"{head}\n{_parameters_text(cls, _unchanged(cls))}"
        return f"{text}\n\n{_servos_text(cls())}" if hasattr(cls, "own_servos") else text
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


def _servos_text(robot: ForeignRobot) -> str:
    """Which joints of a robot of a file have which servo, and where its numbers stand."""
    joints: dict[str, list[str]] = {}
    for joint in robot.tree.joints:
        joints.setdefault(str(joint.servo), []).append(joint.name)
    rows = []
    for name, whose in joints.items():
        own = robot.own_servos.get(name)
        source = robot.servo_sources.get(name, {}).get("stall_torque", f"`gaitlab show {name}`")
        numbers = ["", ""] if own is None else [number(own.stall_torque), number(own.no_load_speed)]
        rows.append([name, *numbers, ", ".join(whose), source])
    head = ("servo", "stall_torque [N m]", "no_load_speed [rad/s]", "joints", "source")
    return wrapped(head, rows, texts=2)


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
    planned = plan(experiment, programs=False)
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
