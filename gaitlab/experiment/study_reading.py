"""The section `study:` of an experiment file, checked to the last value before anything runs.

study:
  sampler: tpe            # or {type: cmaes, sigma0: 0.3}
  trials: 200             # candidates in total
  seed: 0
  batch: 8
  search: {...}           # see `search_reading`
  objectives: [...]       # see `goal_reading`
  constraints: [...]
  racing: {rounds: [2, 4, 8], confidence: 0.9}     # or off; by default twice as many each round
  early_stop: 60          # candidates without an improvement; off by default
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import pairwise

from gaitlab.documents import Node, build, check, collected, in_order
from gaitlab.errors import FileError, GaitlabError, Problem
from gaitlab.experiment.goal_reading import read_constraints, read_objectives
from gaitlab.experiment.parts import Parts
from gaitlab.experiment.samplers import misfits, read_sampler
from gaitlab.experiment.search_reading import first_values, read_search
from gaitlab.experiment.study import Choices, Numbers, Racing, Study
from gaitlab.parameters import Parameter, parameter

MOST_TRIALS = 10**6  # candidates
MOST_BATCH = 1000  # candidates
LARGEST_SEED = 2**32 - 1  # of a random number generator
BESIDE = ("grid", "zip", "one_at_a_time", "design", "walkers")  # keys that a study replaces
SWITCH = {"off": False, "on": True, False: False, True: True}
FIRST_ROUND = 2  # seeds; one seed says little of a candidate


@dataclass(frozen=True, kw_only=True)
class StudySections:
    """Keys of the section."""

    sampler: Node | None = parameter(None, unit="-", doc="name, or `type` and options")
    trials: int = parameter(
        100, unit="-", low=1, high=MOST_TRIALS, doc="candidates to try in total"
    )
    seed: int = parameter(0, unit="-", low=0, high=LARGEST_SEED, doc="of the sampler")
    batch: int = parameter(
        8, unit="-", low=1, high=MOST_BATCH, doc="candidates proposed together, before any is told"
    )
    search: Node | None = parameter(None, unit="-", doc="dotted paths with ranges or choices")
    objectives: Node | None = parameter(None, unit="-", doc="what is better")
    constraints: Node | None = parameter(None, unit="-", doc="what is not allowed")
    racing: Node | None = parameter(None, unit="-", doc="rounds of seeds, or off")
    early_stop: Node | None = parameter(None, unit="-", doc="candidates without an improvement")


@dataclass(frozen=True, kw_only=True)
class RacingSections:
    """Keys of the section `racing`."""

    rounds: Node | None = parameter(None, unit="-", doc="seeds after which candidates are judged")
    confidence: float = parameter(
        0.9, unit="-", low=0.5, high=0.9999, doc="how sure it is that a candidate is hopeless"
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
    given = section.mapping
    problems: list[Problem] = []
    plain = collected(problems, lambda: build(StudySections, section, skip=()))
    sampler = collected(problems, lambda: read_sampler(given.get("sampler")))
    search = collected(problems, lambda: read_search(given.get("search"), section, parts))
    walks = _walks(parts, search or ())
    objectives = collected(
        problems, lambda: read_objectives(given.get("objectives"), section, walks)
    )
    constraints = collected(problems, lambda: read_constraints(given.get("constraints"), walks))
    racing = collected(problems, lambda: (_racing(given.get("racing"), len(seeds)),))
    early_stop = collected(problems, lambda: (_early_stop(given.get("early_stop")),))
    if sampler is not None:
        place = given.get("sampler", section)
        problems += misfits(place, sampler[0], search or (), objectives or ())
    if problems:
        raise FileError(in_order(problems))
    if plain is None or sampler is None or racing is None or early_stop is None:
        raise FileError([section.problem("study: could not be read")])
    return Study(
        sampler=sampler[0],
        sampler_options=sampler[1],
        trials=plain.trials,
        seed=plain.seed,
        batch=plain.batch,
        search=search or (),
        objectives=objectives or (),
        constraints=constraints or (),
        racing=racing[0],
        early_stop=early_stop[0],
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


def _switched(node: Node | None) -> bool | None:
    """Whether a section is switched on or off; None for anything else, be it 0 or 1."""
    value = node.value if node else None
    return SWITCH.get(value) if isinstance(value, str | bool) else None


def _racing(node: Node | None, seeds: int) -> Racing | None:
    switched = _switched(node)
    if node is None or switched is not None:
        return None if switched is False else _usual_racing(seeds)
    if not node.mapping:
        message = f"racing: found {node.found()}; expected {{rounds: [2, 4, 8]}}, on or off"
        raise FileError([node.problem(message)])
    settings = build(RacingSections, node)
    if settings.rounds is None:
        usual = _usual_racing(seeds)
        rounds = usual.rounds if usual else ()
    else:
        rounds = _rounds(settings.rounds, seeds)
    return Racing(rounds=rounds, confidence=settings.confidence) if len(rounds) > 1 else None


def _usual_racing(seeds: int) -> Racing | None:
    """Twice as many seeds each round; None when there is nothing to save."""
    rounds = [seeds]
    while rounds[0] > FIRST_ROUND:
        rounds.insert(0, max(FIRST_ROUND, rounds[0] // 2))
    rounds = [1, *rounds] if rounds == [FIRST_ROUND] else rounds
    return Racing(rounds=tuple(rounds)) if len(rounds) > 1 else None


def _rounds(node: Node, seeds: int) -> tuple[int, ...]:
    """Rounds that rise up to the number of seeds, which is added if it is not the last."""
    if not node.items:
        raise FileError([node.problem(f"racing: rounds: found {node.found()}; expected a list")])
    doc = "seeds walked when a round ends"
    problems: list[Problem] = []
    found: list[int] = []
    for item in node.items:
        limits = Parameter(
            name="racing: rounds", type=int, default=None, unit="-", low=1, high=seeds, doc=doc,
            source="",
        )  # fmt: skip
        try:
            found.append(check(limits, item))
        except FileError as error:
            problems += error.problems
    if not problems and any(later <= earlier for earlier, later in pairwise(found)):
        shown = ", ".join(map(str, found))
        problems.append(node.problem(f"racing: rounds: found {shown}; each has more than the last"))
    if problems:
        raise FileError(problems)
    return tuple(found) if found[-1] == seeds else (*found, seeds)


def _early_stop(node: Node | None) -> int | None:
    if node is None or node.value is None or _switched(node) is False:
        return None
    item = Parameter(
        name="early_stop",
        type=int,
        default=None,
        unit="-",
        low=1,
        high=MOST_TRIALS,
        doc="candidates without an improvement after which the search ends, or off",
        source="",
    )
    found: int = check(item, node)
    return found
