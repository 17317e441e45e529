"""The sections `objectives:` and `constraints:` of a study.

objectives:
  - {maximize: walking_speed, seeds: mean, surfaces: worst}
  - {minimize: cost_of_transport, seeds: {cvar: 0.25}, fallen: 5.0}
constraints:
  - "walking_speed >= 0.15"
  - {metric: saturation_share, at_most: 0.05, seeds: {quantile: 0.5}}
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from typing import Literal, NamedTuple, TypeVar, cast, get_args, get_type_hints

from gaitlab.body import gantry_of
from gaitlab.documents import Node, check
from gaitlab.errors import FileError, Problem
from gaitlab.experiment.falling import BACKWARDS, MISLEADING
from gaitlab.experiment.parts import Parts
from gaitlab.experiment.study import Aggregate, Constraint, Direction, Objective
from gaitlab.metrics import REQUISITES, metric, names, needs, unit_of
from gaitlab.parameters import Parameter
from gaitlab.plugins import label, suggestion

T = TypeVar("T", Objective, Constraint)
HAS: dict[str, Callable[[Parts], bool]] = {  # whether a walk has what a metric may need
    "gantry": lambda walk: gantry_of(walk.robot) != "none",
    "couplings": lambda walk: any(joint.servo is None for joint in walk.robot.tree.joints),
    "force sensors": lambda walk: walk.robot.sole.sensors(0) is not None,
    "distance": lambda walk: walk.gait.step_length != 0.0,
    "cycle": lambda walk: walk.walking_time > walk.gait.gait_period - 1.1 * walk.engine.dt,
}
DIRECTIONS = cast(tuple[Direction, ...], get_args(Direction))
BOUNDS = ("at_least", "at_most")
FURTHER = ("seeds", "surfaces", "fallen")  # keys of objectives and constraints alike
PLAIN = ("mean", "worst")  # aggregates without a share
SHARED = ("quantile", "cvar")  # aggregates with one
COMPARED = re.compile(r"\s*(\w+)\s*(<=|>=)\s*([-+]?[\d.]+(?:[eE][-+]?\d+)?)\s*")


class _Further(NamedTuple):
    """What objectives and constraints have in common."""

    over_seeds: Aggregate
    over_surfaces: Aggregate
    fallen: float | None


def read_objectives(
    node: Node | None, section: Node, walks: Sequence[Parts] = ()
) -> tuple[Objective, ...]:
    """What is better.

    Args:
        node: The section; None if there is none.
        section: What it belongs to.
        walks: What is walked at the ends of what is searched; empty if that is not known.

    Raises:
        FileError: All mistakes.
    """
    if node is None or not (node.items or node.mapping):
        found = "nothing" if node is None or node.value in ({}, ()) else node.found()
        message = (
            f"objectives: found {found}; expected a list of "
            "{maximize: METRIC} or {minimize: METRIC}, `gaitlab list metrics` names them"
        )
        raise FileError([(node or section).problem(message)])
    return tuple(_each(node.items or (node,), _objective, "objectives", walks))


def read_constraints(node: Node | None, walks: Sequence[Parts] = ()) -> tuple[Constraint, ...]:
    """What is not allowed; `walks` as of `read_objectives`.

    Raises:
        FileError: All mistakes.
    """
    if node is None or node.value in (None, ()):
        return ()
    found = tuple(_each(node.items or (node,), _constraint, "constraints", walks))
    problems = [node.problem(message) for message in _contradictions(found)]
    if problems:
        raise FileError(problems)
    return found


def _each(
    nodes: tuple[Node, ...], read: Callable[[Node], T], section: str, walks: Sequence[Parts]
) -> Iterator[T]:
    """Everything that is listed, no two alike, each of a metric that these walks can have."""
    problems: list[Problem] = []
    found: list[T] = []
    for node in nodes:
        try:
            item = read(node)
        except FileError as error:
            problems += error.problems
            continue
        if item in found:
            problems.append(node.problem(f"{section}: this is listed twice; keep one of them"))
        found.append(item)
        lacking = _lacking(item.metric, walks)
        if lacking:
            message = f"{section}: {item.metric} has no value in any of these walks, for {lacking}"
            problems.append(node.problem(f"{message}; `gaitlab list metrics` names others"))
    if problems:
        raise FileError(problems)
    yield from found


def _lacking(name: str, walks: Sequence[Parts]) -> str:
    """What a metric needs and none of the walks has; empty if there is nothing."""
    for need in needs(name) if walks else ():
        if not any(HAS[need](walk) for walk in walks):
            robot, gait = label(walks[0].robot_code.name), label(walks[0].gait_code.name)
            return f"it needs {REQUISITES[need]}, and here the robot is {robot}, the gait {gait}"
    return ""


def _objective(node: Node) -> Objective:
    if not node.mapping:
        message = f"objectives: found {node.found()}; expected {{maximize: METRIC}} or"
        raise FileError([node.problem(f"{message} {{minimize: METRIC}}")])
    directions = [key for key in DIRECTIONS if key in node.mapping]
    problems = _unknown_keys("objectives", node, (*DIRECTIONS, *FURTHER))
    if len(directions) != 1:
        found = "both" if directions else "neither"
        message = f"objectives: found {found} of `maximize:` and `minimize:`; write one of them"
        problems.append(node.problem(message))
    name = ""
    for direction in directions[:1]:
        name = _metric("objectives", node.mapping[direction], direction, problems)
    further = _further("objectives", node, name, problems)
    if problems:
        raise FileError(problems)
    return Objective(metric=name, direction=directions[0], **further._asdict())


def _constraint(node: Node) -> Constraint:
    if isinstance(node.value, str):
        return _compared(node)
    if not node.mapping:
        raise FileError([node.problem(f"constraints: found {node.found()}; {_form()}")])
    bounds = [key for key in BOUNDS if key in node.mapping]
    problems = _unknown_keys("constraints", node, ("metric", *BOUNDS, *FURTHER))
    if len(bounds) != 1:
        found = "both" if bounds else "neither"
        message = f"constraints: found {found} of `at_least:` and `at_most:`; write one of them"
        problems.append(node.problem(message))
    direction: Direction = "minimize" if bounds == ["at_most"] else "maximize"
    if "metric" not in node.mapping:
        problems.append(node.problem(f"constraints: `metric:` is missing; {_form()}"))
    name = _metric("constraints", node.mapping.get("metric"), direction, problems)
    bound = _bound(name, node.mapping.get(bounds[0] if bounds else ""), problems)
    further = _further("constraints", node, name, problems)
    if problems:
        raise FileError(problems)
    at_least = direction == "maximize"
    return Constraint(metric=name, bound=bound, at_least=at_least, **further._asdict())


def _compared(node: Node) -> Constraint:
    """`walking_speed >= 0.15`."""
    found = COMPARED.fullmatch(str(node.value))
    try:
        bound = float(found[3]) if found else None
    except ValueError:
        bound = None
    if found is None or bound is None:
        raise FileError([node.problem(f"constraints: found {node.found()}; {_form()}")])
    problems: list[Problem] = []
    at_least = found[2] == ">="
    direction: Direction = "maximize" if at_least else "minimize"
    name = _metric(
        "constraints", node.holding(Node(file=node.file, value=found[1])), direction, problems
    )
    bound = _bound(name, node.holding(Node(file=node.file, value=bound)), problems)
    if problems:
        raise FileError(problems)
    return Constraint(metric=name, bound=bound, at_least=at_least)


def _form() -> str:
    return (
        'expected "walking_speed >= 0.15", with <= or >= and a number in SI units, or '
        "{metric: walking_speed, at_least: 0.15}"
    )


def _unknown_keys(section: str, node: Node, known: tuple[str, ...]) -> list[Problem]:
    return [
        node.keys[key].problem(f"{section}: unknown key {key!r}{suggestion(key, known)}")
        for key in node.mapping
        if key not in known
    ]


def _metric(section: str, node: Node | None, direction: Direction, problems: list[Problem]) -> str:
    """Name of a metric that candidates can be compared by; mistakes go to `problems`."""
    if node is None:
        return ""
    name = str(node.value)
    numbers = [known for known in names() if _is_number(known) and known not in MISLEADING]
    if name in MISLEADING:
        why, instead = MISLEADING[name]
        message = f"{section}: {name} misleads a search, {why}; use {instead}"
        problems.append(node.problem(message))
    elif (name, direction) in BACKWARDS:
        message = f"{section}: this asks for falls; did you mean {BACKWARDS[name, direction]}?"
        problems.append(node.problem(message))
    elif name not in numbers:
        what = f"{name!r}, which is a word" if name in names() else node.found()
        problems.append(node.problem(f"{section}: found {what}{suggestion(name, numbers)}"))
    else:
        return name
    return ""


def _is_number(name: str) -> bool:
    return get_type_hints(metric(name))["return"] in (float, int, bool)


def _bound(name: str, node: Node | None, problems: list[Problem]) -> float:
    return _value("constraints: bound", name, node, problems) or 0.0


def _value(what: str, name: str, node: Node | None, problems: list[Problem]) -> float | None:
    """A number in the unit of a metric."""
    if node is None:
        return None
    unit = unit_of(name) if name else "-"
    doc = f"a value of {name or 'the metric'}"
    item = Parameter(
        name=what, type=float, default=None, unit=unit, low=None, high=None, doc=doc, source=""
    )
    try:
        return float(check(item, node))
    except FileError as error:
        problems += error.problems
        return None


def _further(section: str, node: Node, name: str, problems: list[Problem]) -> _Further:
    return _Further(
        over_seeds=_aggregate(f"{section}: seeds", node.mapping.get("seeds"), problems),
        over_surfaces=_aggregate(f"{section}: surfaces", node.mapping.get("surfaces"), problems),
        fallen=_value(f"{section}: fallen", name, node.mapping.get("fallen"), problems),
    )


def _aggregate(what: str, node: Node | None, problems: list[Problem]) -> Aggregate:
    """`mean`, `worst`, `{quantile: 0.1}` or `{cvar: 0.25}`."""
    if node is None:
        return Aggregate()
    if node.value in PLAIN:
        return Aggregate(kind=cast(Literal["mean", "worst"], node.value))
    kind = next(iter(node.mapping), "")
    if len(node.mapping) != 1 or kind not in SHARED:
        known = "mean, worst, {quantile: SHARE}, {cvar: SHARE}, the share from 0 to 1"
        hint = suggestion(kind or str(node.value), (*PLAIN, *SHARED)).partition(" Known")[0]
        problems.append(node.problem(f"{what}: found {node.found()}; expected {known}{hint}"))
        return Aggregate()
    share = node.mapping[kind]
    item = Parameter(
        name=f"{what}: {kind}",
        type=float,
        default=None,
        unit="-",
        low=0.0,
        high=1.0,
        doc="share of the trials, counted from the worst; above 0",
        source="",
    )
    try:
        value = float(check(item, share))
        if value == 0.0:
            raise FileError([share.problem(f"{what}: {kind}: found 0; it is above 0, or `worst`")])
    except FileError as error:
        problems += error.problems
        return Aggregate()
    return Aggregate(kind=cast(Literal["quantile", "cvar"], kind), share=value)


def _contradictions(found: tuple[Constraint, ...]) -> Iterator[str]:
    """Pairs of constraints that no candidate can fulfil together."""
    mean = Aggregate()
    plain = [item for item in found if item.over_seeds == item.over_surfaces == mean]
    for low in plain:
        for high in plain:
            both = low.at_least and not high.at_least and low.metric == high.metric
            if both and low.bound > high.bound:
                yield f"constraints: {low.text} and {high.text} exclude each other; mend one"
