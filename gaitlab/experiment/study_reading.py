"""The section `study:` of an experiment file, checked to the last value before anything runs.

study:
  sampler: tpe            # or {type: cmaes, sigma0: 0.3}
  trials: 200             # candidates in total
  seed: 0
  batch: 8
  search: {...}           # see `search_reading`
  objectives:
    - {maximize: walking_speed, seeds: mean, surfaces: worst}
    - {minimize: cost_of_transport, seeds: {cvar: 0.25}, fallen: 5.0}
  constraints:
    - "walking_speed >= 0.15"
    - {metric: saturation_share, at_most: 0.05, seeds: {quantile: 0.5}}
  racing: {rounds: [2, 4, 8], confidence: 0.9}     # or off; by default twice as many each round
  early_stop: 60          # candidates without an improvement; off by default
  confirm: bullet         # engine of the final and of all that checks the winner, as
                          # `engine: {name: mujoco}` is the one to search in
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import partial
from itertools import pairwise
from typing import Any, Literal, TypeVar, cast, get_args

from gaitlab.documents import (
    Node,
    Reader,
    check,
    collected,
    in_order,
    read_each,
    read_mapping,
)
from gaitlab.errors import FileError, GaitlabError, Problem
from gaitlab.experiment.parts import Parts
from gaitlab.experiment.samplers import DEFAULT, misfits, read_sampler
from gaitlab.experiment.search_reading import first_values, read_search
from gaitlab.experiment.study import (
    BACKWARDS,
    MISLEADING,
    Aggregate,
    Choices,
    Constraint,
    Direction,
    Numbers,
    Objective,
    Racing,
    Study,
)
from gaitlab.metrics import REQUISITES, lookup, names
from gaitlab.model import gantry_of
from gaitlab.model.settings import EngineName
from gaitlab.parameters import Parameter
from gaitlab.plugins import label, suggestion

T = TypeVar("T", Objective, Constraint)
MOST_TRIALS = 10**6  # candidates
BESIDE = ("grid", "zip", "one_at_a_time", "design", "walkers")  # keys that a study replaces
SWITCH = {"off": False, "on": True, False: False, True: True}
FIRST_ROUND = 2  # seeds; one seed says little of a candidate
PLAIN = {  # keys of the section that are a number
    item.name: item
    for item in (
        Parameter(
            name="trials", type=int, default=100, low=1, high=MOST_TRIALS, doc="candidates in total"
        ),
        Parameter(name="seed", type=int, default=0, low=0, high=2**32 - 1, doc="of the sampler"),
        Parameter(
            name="batch", type=int, default=8, low=1, high=1000, doc="candidates asked for together"
        ),
    )
}
CONFIDENCE = Parameter(
    name="confidence", type=float, low=0.5, high=0.9999, doc="how sure it is that one is hopeless"
)
EARLY_STOP = Parameter(
    name="early_stop",
    type=int,
    low=1,
    high=MOST_TRIALS,
    doc="candidates without an improvement after which the search ends, or off",
)
CONFIRM = Parameter(
    name="confirm", type=EngineName, doc="engine of the final and of all that checks the winner"
)
SHARE = Parameter(
    name="", type=float, low=0.0, high=1.0, doc="share of the trials, counted from the worst"
)
HAS: dict[str, Callable[[Parts], bool]] = {  # whether a walk has what a metric may need
    "gantry": lambda walk: gantry_of(walk.robot) != "none",
    "couplings": lambda walk: any(joint.servo is None for joint in walk.robot.tree.joints),
    "force sensors": lambda walk: walk.robot.sole.sensors(0) is not None,
    "distance": lambda walk: bool(walk.gait.step_length or getattr(walk.gait, "side_step", 0.0)),
    "cycle": lambda walk: walk.walking_time > walk.gait.gait_period - 1.1 * walk.engine.dt,
}
DIRECTIONS = cast(tuple[Direction, ...], get_args(Direction))
BOUNDS: dict[str, Direction] = {"at_least": "maximize", "at_most": "minimize"}
WHOLE = ("mean", "worst")  # aggregates without a share
SHARED = ("quantile", "cvar")  # aggregates with one
COMPARED = re.compile(r"\s*(\w+)\s*(<=|>=)\s*([-+]?[\d.]+(?:[eE][-+]?\d+)?)\s*")
CONSTRAINT = (
    'expected "walking_speed >= 0.15", with <= or >= and a number in SI units, or '
    "{metric: walking_speed, at_least: 0.15}"
)


def searched_values(section: Node | None) -> dict[str, Node]:
    """A value of every searched path, for parameters that only the study gives."""
    return first_values(section.mapping.get("search") if section else None)


def refuse_beside_study(tree: Node) -> None:
    """Refuse what a study replaces.

    Raises:
        FileError: If the file varies parameters as well, or walks several robots.
    """
    problems = [
        tree.keys[key].problem(
            f"{key}: a study searches instead of varying, and searches for one robot; "
            f"keep one of `study:` and `{key}:`"
        )
        for key in BESIDE
        if key in tree.mapping and "study" in tree.mapping
    ]
    if problems:
        raise FileError(problems)


def read_study(section: Node | None, parts: Parts | None, seeds: Sequence[int]) -> Study | None:
    """The study of a file; None if it has none.

    Args:
        section: The section `study:`.
        parts: What the search changes; None if that is wrong, and then the paths go unread.
        seeds: Seeds of the replicates.

    Raises:
        FileError: All mistakes.
    """
    if section is None:
        return None
    if section.value is not None and not isinstance(section.value, Mapping):
        raise FileError([section.problem(f"study: found {section.found()}; expected a mapping")])
    problems: list[Problem] = []
    nothing = Node(file=section.file, line=section.line, column=section.column, value=None)
    needed = {key: nothing for key in ("search", "objectives") if key not in section.mapping}
    section = section.replaced(**needed)
    search = collected(problems, lambda: read_search(section.mapping["search"], parts)) or ()
    walks = _walks(parts, search)
    readers: dict[str, Reader] = {
        **PLAIN,
        "sampler": read_sampler,
        "search": lambda node: search,
        "objectives": partial(read_objectives, walks=walks),
        "constraints": partial(read_constraints, walks=walks),
        "racing": partial(_read_racing, seeds=len(seeds)),
        "early_stop": _read_early_stop,
        "confirm": CONFIRM,
    }
    given = read_mapping("", section, readers, expected="", problems=problems)
    sampler, options = given.get("sampler", (DEFAULT, {}))
    place = section.mapping.get("sampler", section)
    problems += misfits(place, sampler, search, given.get("objectives", ()))
    if problems:
        raise FileError(in_order(problems))
    plain = {name: given.get(name, item.default) for name, item in PLAIN.items()}
    return Study(
        **plain,
        sampler=sampler,
        sampler_options=options,
        search=search,
        objectives=given["objectives"],
        constraints=given.get("constraints", ()),
        racing=given["racing"] if "racing" in given else _usual_racing(len(seeds)),
        early_stop=given.get("early_stop"),
        confirm=given.get("confirm"),
    )


def _walks(parts: Parts | None, search: Sequence[Numbers | Choices]) -> list[Parts]:
    """What is walked at the base and at the ends of what is searched, as far as it can be."""
    if parts is None:
        return []
    found = [parts]
    rows = [{item.path: value} for item in search for value in item.ends]
    rows += [{item.path: item.ends[end] for item in search} for end in (0, -1)]
    for row in rows:
        with suppress(GaitlabError, ValueError, ArithmeticError, TypeError):
            found.append(parts.varied(row))
    return found


def _switched(node: Node) -> bool | None:
    """Whether a section is switched on or off; None for anything else, be it 0 or 1."""
    return SWITCH.get(node.value) if isinstance(node.value, str | bool) else None


def _read_racing(node: Node, seeds: int) -> Racing | None:
    switched = _switched(node)
    if switched is not None:
        return _usual_racing(seeds) if switched else None
    expected = "expected {rounds: [2, 4, 8]}, on or off"
    keys: dict[str, Reader] = {
        "rounds": partial(_read_rounds, seeds=seeds),
        "confidence": CONFIDENCE,
    }
    given = read_mapping("racing", node, keys, expected=expected)
    usual = _usual_racing(seeds)
    rounds = given.pop("rounds", usual.rounds if usual else ())
    return Racing(rounds=rounds, **given) if len(rounds) > 1 else None


def _usual_racing(seeds: int) -> Racing | None:
    """Twice as many seeds each round; None when there is nothing to save."""
    rounds = [seeds]
    while rounds[0] > FIRST_ROUND:
        rounds.insert(0, max(FIRST_ROUND, rounds[0] // 2))
    rounds = [1, *rounds] if rounds == [FIRST_ROUND] else rounds
    return Racing(rounds=tuple(rounds)) if len(rounds) > 1 else None


def _read_rounds(node: Node, seeds: int) -> tuple[int, ...]:
    """Rounds that rise up to the number of seeds, which is added if it is not the last."""
    if not node.items:
        raise FileError([node.problem(f"racing: rounds: found {node.found()}; expected a list")])
    doc = "seeds walked when a round ends"
    item = Parameter(name="racing: rounds", type=int, low=1, high=seeds, doc=doc)
    rounds: list[int] = read_each(node.items, partial(check, item))
    if any(later <= earlier for earlier, later in pairwise(rounds)):
        shown = ", ".join(map(str, rounds))
        message = f"racing: rounds: found {shown}; each has more than the last"
        raise FileError([node.problem(message)])
    return tuple(rounds) if rounds[-1] == seeds else (*rounds, seeds)


def _read_early_stop(node: Node) -> int | None:
    if node.value is None or _switched(node) is False:
        return None
    candidates: int = check(EARLY_STOP, node)
    return candidates


def read_objectives(node: Node, walks: Sequence[Parts] = ()) -> tuple[Objective, ...]:
    """What is better.

    Args:
        node: The section.
        walks: What is walked at the ends of what is searched; empty if that is not known.

    Raises:
        FileError: All mistakes.
    """
    if not (node.items or node.mapping):
        message = (
            f"objectives: found {node.found()}; expected a list of "
            "{maximize: METRIC} or {minimize: METRIC}, `gaitlab list metrics` names them"
        )
        raise FileError([node.problem(message)])
    return _read_aims(node.items or (node,), _read_objective, "objectives", walks)


def read_constraints(node: Node, walks: Sequence[Parts] = ()) -> tuple[Constraint, ...]:
    """What is not allowed; `walks` as of `read_objectives`.

    Raises:
        FileError: All mistakes.
    """
    if node.value in (None, ()):
        return ()
    constraints = _read_aims(node.items or (node,), _read_constraint, "constraints", walks)
    problems = [node.problem(message) for message in _contradictions(constraints)]
    if problems:
        raise FileError(problems)
    return constraints


def _read_aims(
    nodes: tuple[Node, ...], read: Callable[[Node], T], section: str, walks: Sequence[Parts]
) -> tuple[T, ...]:
    """Everything that is listed, no two alike, each of a metric that these walks can have."""
    aims: list[T] = []

    def read_one(node: Node) -> None:
        aim = read(node)
        aims.append(aim)
        if aim in aims[:-1]:
            raise FileError([node.problem(f"{section}: this is listed twice; keep one of them")])
        lacking = _lacking(aim.metric, walks)
        if lacking:
            message = f"{section}: {aim.metric} has no value in any of these walks, for {lacking}"
            raise FileError([node.problem(f"{message}; `gaitlab list metrics` names others")])

    read_each(nodes, read_one)
    return tuple(aims)


def _lacking(name: str, walks: Sequence[Parts]) -> str:
    """What a metric needs and none of the walks has; empty if there is nothing."""
    for need in lookup(name).needs if walks else ():
        if not any(HAS[need](walk) for walk in walks):
            robot, gait = label(walks[0].robot_code.name), label(walks[0].gait_code.name)
            return f"it needs {REQUISITES[need]}, and here the robot is {robot}, the gait {gait}"
    return ""


def _read_objective(node: Node) -> Objective:
    expected = "expected {maximize: METRIC} or {minimize: METRIC}"
    directions = [way for way in DIRECTIONS if way in node.mapping]
    keys = _further("objectives", node.mapping[directions[0]] if directions else None)
    keys |= {way: partial(_read_metric, "objectives", way) for way in DIRECTIONS}
    given = read_mapping("objectives", node, keys, expected=expected)
    if len(directions) != 1:
        found = "both" if directions else "neither"
        message = f"objectives: found {found} of `maximize:` and `minimize:`; write one of them"
        raise FileError([node.problem(message)])
    (direction,) = directions
    return Objective(metric=given.pop(direction), direction=direction, **_aggregated(given))


def _read_constraint(node: Node) -> Constraint:
    if isinstance(node.value, str):
        node = _written_out(node)
    bounds = [key for key in BOUNDS if key in node.mapping]
    direction = BOUNDS[bounds[0]] if bounds else "maximize"
    name = node.mapping.get("metric")
    keys = _further("constraints", name)
    keys |= {"metric": partial(_read_metric, "constraints", direction)}
    keys |= {key: _number_of(name) for key in BOUNDS}
    given = read_mapping("constraints", node, keys, required=("metric",), expected=CONSTRAINT)
    if len(bounds) != 1:
        found = "both" if bounds else "neither"
        message = f"constraints: found {found} of `at_least:` and `at_most:`; write one of them"
        raise FileError([node.problem(message)])
    bound = given.pop(bounds[0])
    at_least = direction == "maximize"
    return Constraint(bound=bound, at_least=at_least, **_aggregated(given))


def _written_out(node: Node) -> Node:
    """`walking_speed >= 0.15` as the mapping that it stands for."""
    found = COMPARED.fullmatch(str(node.value))
    with suppress(ValueError):
        if found is not None:
            bound = Node(file=node.file, value=float(found[3]))
            name = node.holding(Node(file=node.file, value=found[1]))
            key = "at_least" if found[2] == ">=" else "at_most"
            empty = node.holding(Node(file=node.file, value={}))
            return empty.replaced(**{"metric": name, key: node.holding(bound)})
    raise FileError([node.problem(f"constraints: found {node.found()}; {CONSTRAINT}")])


def _read_metric(section: str, direction: Direction, node: Node) -> str:
    """Name of a metric that candidates can be compared by."""
    name = str(node.value)
    numbers = [known for known in names() if _is_number(known) and known not in MISLEADING]
    if name in MISLEADING:
        why, instead = MISLEADING[name]
        message = f"{name} misleads a search, {why}; use {instead}"
    elif (name, direction) in BACKWARDS:
        message = f"this asks for falls; did you mean {BACKWARDS[name, direction]}?"
    elif name not in numbers:
        what = f"{name!r}, which is a word" if name in names() else node.found()
        message = f"found {what}{suggestion(name, numbers)}"
    else:
        return name
    raise FileError([node.problem(f"{section}: {message}")])


def _is_number(name: str) -> bool:
    return lookup(name).kind in (float, int, bool)


def _number_of(name: Node | None) -> Parameter:
    """A number in the unit of a metric."""
    known = name is not None and name.value in names()
    what = str(name.value) if name is not None and known else "the metric"
    unit = lookup(what).unit if known else "-"
    return Parameter(name="", type=float, unit=unit, doc=f"a value of {what}")


def _further(section: str, name: Node | None) -> dict[str, Reader]:
    """What reads the keys that objectives and constraints have in common."""
    return {
        "seeds": partial(_read_aggregate, f"{section}: seeds"),
        "surfaces": partial(_read_aggregate, f"{section}: surfaces"),
        "fallen": _number_of(name),
    }


def _aggregated(given: Mapping[str, Any]) -> dict[str, Any]:
    names = {"seeds": "over_seeds", "surfaces": "over_surfaces"}
    return {names.get(key, key): value for key, value in given.items()}


def _read_aggregate(what: str, node: Node) -> Aggregate:
    """`mean`, `worst`, `{quantile: 0.1}` or `{cvar: 0.25}`."""
    if node.value in WHOLE:
        return Aggregate(kind=cast(Literal["mean", "worst"], node.value))
    kind = next(iter(node.mapping), "")
    if len(node.mapping) != 1 or kind not in SHARED:
        known = "mean, worst, {quantile: SHARE}, {cvar: SHARE}, the share from 0 to 1"
        hint = suggestion(kind or str(node.value), (*WHOLE, *SHARED)).partition(" Known")[0]
        raise FileError([node.problem(f"{what}: found {node.found()}; expected {known}{hint}")])
    share = read_mapping(what, node, {kind: SHARE}, expected="")[kind]
    if share == 0.0:
        message = f"{what}: {kind}: found 0; it is above 0, or `worst`"
        raise FileError([node.mapping[kind].problem(message)])
    return Aggregate(kind=cast(Literal["quantile", "cvar"], kind), share=share)


def _contradictions(found: tuple[Constraint, ...]) -> Iterator[str]:
    """Pairs of constraints that no candidate can fulfil together."""
    mean = Aggregate()
    plain = [item for item in found if item.over_seeds == item.over_surfaces == mean]
    for low in plain:
        for high in plain:
            both = low.at_least and not high.at_least and low.metric == high.metric
            if both and low.bound > high.bound:
                yield f"constraints: {low.text} and {high.text} exclude each other; mend one"
