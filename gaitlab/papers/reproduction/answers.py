"""Which simulated cells answer to a paper's printed cells, and which of them constants were fit on.

A cell counts as calibrated when a constant was chosen by looking at it, and as predicted when none
was. A printed verdict agrees when the simulated cell has the same one. The limit of a ground is the
longest printed distance up to which every forward row is stable.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import NamedTuple

from gaitlab.errors import WrongValue
from gaitlab.experiment import Experiment
from gaitlab.experiment.reference import ReferenceCell, ReferenceTable, load_reference
from gaitlab.papers.printed import eros_tables
from gaitlab.papers.reproduction.section import Value
from gaitlab.plugins import suggestion
from gaitlab.report.cells import DIRECTIONS, STEP, compared
from gaitlab.report.results import Results
from gaitlab.report.scores import Score, ScoredCell
from gaitlab.report.variants import Variant
from gaitlab.statistics import Count

Calibrated = Mapping[str, Value]  # by name of the table: {direction: ..., ...}, or a list of them
NOWHERE = -1  # printed distance of a ground on which not even the first row is stable
KEYS = ("direction", "surfaces", "distances")  # of the cells that a constant was chosen on


@dataclass(frozen=True, kw_only=True, eq=False)
class Answer:
    """A variant that answers to a printed table.

    Attributes:
        table: The printed table.
        experiment: Name of the member.
        results: Of the member.
        variant: The one that answers.
        engine: That the member is walked in; empty where that is not said.
    """

    table: ReferenceTable
    experiment: str
    results: Results
    variant: Variant
    engine: str = ""

    @property
    def label(self) -> str:
        """What the page calls it: the variant, or the member whose only variant it is."""
        return self.variant.label if len(self.results.variants) > 1 else self.experiment

    @property
    def columns(self) -> list[list[ScoredCell]]:
        """The planned cells of every ground."""
        return self.results.by_column(self.variant)


class Judged(NamedTuple):
    """One simulated cell beside the printed one."""

    table: ReferenceTable
    place: ReferenceCell
    ours: ScoredCell
    printed: bool
    calibrated: bool

    def agrees(self, score: Score = "stable") -> bool:
        """Whether both have the same verdict."""
        return self.ours.verdict(score) == self.printed


class AnswerColumn(NamedTuple):
    """What is set beside the printed tables in one column: one answer a table."""

    label: str
    answers: tuple[Answer, ...]


def answers(
    results: Mapping[str, Results],
    experiments: Iterable[str],
    members: Mapping[str, Experiment] | None = None,
) -> list[Answer]:
    """Every variant that answers to a printed table, Table 7 before Table 8.

    Args:
        results: Of each member by name.
        experiments: Members that are looked at.
        members: The members themselves, which say in which engine they are walked.
    """
    engines = {name: "/".join(sorted(member.engines)) for name, member in (members or {}).items()}
    found = [
        Answer(table=table, experiment=name, results=each, variant=variant,
               engine=engines.get(name, ""))
        for name, each in ((name, results[name]) for name in experiments)
        for variant in each.variants
        if (table := table_of(variant)) is not None
    ]  # fmt: skip
    return sorted(found, key=lambda answer: answer.table.name)


def sides(found: Sequence[Answer]) -> list[AnswerColumn]:
    """The answers in columns, those of one engine together, and of each no two to one table.

    A column is called by its engine; where two have the same, by its members.
    """
    columns: list[list[Answer]] = []
    for answer in found:
        fitting = (
            column
            for column in columns
            if column[0].engine == answer.engine
            and answer.table not in [other.table for other in column]
        )
        column = next(fitting, None)
        if column is None:
            columns.append([answer])
        else:
            column.append(answer)
    engines = [column[0].engine for column in columns]
    return [
        AnswerColumn(
            column[0].engine
            if column[0].engine and engines.count(column[0].engine) == 1
            else " and ".join(dict.fromkeys(_called(answer, found) for answer in column)),
            tuple(column),
        )
        for column in columns
    ]


def _called(answer: Answer, found: Sequence[Answer]) -> str:
    """A member, with its variant where it has several answers to one table."""
    same = [a for a in found if (a.experiment, a.table) == (answer.experiment, answer.table)]
    return f"{answer.experiment}, {answer.label}" if len(same) > 1 else answer.experiment


def table_of(variant: Variant) -> ReferenceTable | None:
    """Printed table that a variant answers to, None for none.

    That of `report.compare`; without it a variant with both halves of the optimisation answers to
    Table 8 and one that switches both off to Table 7.
    """
    if variant.compare is not None:
        return variant.compare
    return next((t for t in eros_tables() if set(t.content.variant or {}) <= variant.values.keys()
                 and t.answers(variant.values)), None)  # fmt: skip


def forward_only(answer: Answer) -> Answer:
    """The same without the rows that walk backward."""
    results = answer.results
    if results.rows != STEP:
        return answer
    trials = results.trials[results.trials[STEP] >= 0.0]
    return replace(answer, results=replace(results, trials=trials))


def judged(answer: Answer, calibrated: Calibrated) -> list[Judged]:
    """Cells that are scored here and printed there, in the order of the rows."""
    blocks = _blocks(calibrated.get(answer.table.name))
    variant = replace(answer.variant, compare=answer.table)
    return [
        Judged(
            answer.table, pair.place, pair.ours, pair.printed,
            any(_within(pair.place, block) for block in blocks),
        )
        for pair in compared(answer.results, variant)
    ]  # fmt: skip


def _blocks(value: Value) -> list[Mapping[str, Value]]:
    """Blocks of cells of a table that constants were chosen on."""
    found = value if isinstance(value, tuple) else (value,)
    return [block for block in found if isinstance(block, Mapping)]


def _within(place: ReferenceCell, block: Mapping[str, Value]) -> bool:
    """Whether a cell lies in a block; what a block leaves out is all of it."""
    return (
        block.get("direction") in (None, place.direction)
        and _listed(place.surface, block.get("surfaces"))
        and _listed(place.distance, block.get("distances"))
    )


def _listed(value: str | float, wanted: Value) -> bool:
    return wanted is None or value in (wanted if isinstance(wanted, tuple) else (wanted,))


def require_known(calibrated: Calibrated) -> None:
    """Refuse a table, key, direction, ground or distance that nothing is called by.

    Raises:
        WrongValue: At the first of them; names what is known.
    """
    for table, cells in calibrated.items():
        _require("calibrated", table, [known.name for known in eros_tables()])
        for block in _blocks(cells):
            _require_block(f"calibrated: {table}", table, block)


def _require_block(where: str, table: str, block: Mapping[str, Value]) -> None:
    reference = load_reference(table)
    distances = sorted({place.distance for place in reference.cells})
    known: Mapping[str, Sequence[str]] = {
        "direction": DIRECTIONS,
        "surfaces": sorted(reference.stated),
        "distances": [f"{distance:g}" for distance in distances],
    }
    for key, value in block.items():
        _require(where, key, KEYS)
        for item in value if isinstance(value, tuple) else (value,):
            _require(f"{where}: {key}", str(item), known[key])


def _require(where: str, found: str, known: Sequence[str]) -> None:
    if found not in known:
        raise WrongValue(f"{where}: found {found!r}{suggestion(found, known)}")


def agreement(cells: Sequence[Judged], score: Score = "stable") -> Count:
    """Cells with the printed verdict, of how many."""
    return Count(sum(cell.agrees(score) for cell in cells), len(cells))


def always_stable(cells: Sequence[Judged]) -> Count:
    """What saying S of every cell would score."""
    return Count(sum(cell.printed for cell in cells), len(cells))


def best_constant(cells: Sequence[Judged]) -> Count:
    """What the best single verdict for each ground of each table would score.

    It is chosen with the printed verdicts in hand, so no prediction could rely on it.
    """
    groups: dict[tuple[str, str], Counter[bool]] = {}
    for cell in cells:
        groups.setdefault((cell.table.name, cell.place.surface), Counter())[cell.printed] += 1
    return Count(sum(max(group.values()) for group in groups.values()), len(cells))


def untouched_grounds(cells: Sequence[Judged]) -> list[str]:
    """Grounds with no calibrated cell among these, in their order."""
    grounds = dict.fromkeys(cell.place.surface for cell in cells)
    touched = {cell.place.surface for cell in cells if cell.calibrated}
    return [ground for ground in grounds if ground not in touched]


class Limits(NamedTuple):
    """Longest stable printed distance of each ground; `NOWHERE` where none is."""

    paper: Mapping[str, float]
    ours: Mapping[str, float]


class Ordered(NamedTuple):
    """Pairs of grounds that the paper tells apart, and how we order them."""

    right: int
    tied: int
    wrong: int

    @property
    def pairs(self) -> int:
        """All of them."""
        return self.right + self.tied + self.wrong


def limits(cells: Sequence[Judged]) -> Limits:
    """Limit of each ground over the forward rows, in the order of the cells."""
    forward = [cell for cell in cells if cell.place.direction == "forward"]
    grounds = dict.fromkeys(cell.place.surface for cell in forward)
    sides = [
        {g: _limit([c for c in forward if c.place.surface == g], side) for g in grounds}
        for side in ("paper", "ours")
    ]
    return Limits(*sides)


def _limit(cells: Sequence[Judged], side: str) -> float:
    found: float = NOWHERE
    for cell in sorted(cells, key=lambda cell: cell.place.distance):
        if not (cell.printed if side == "paper" else cell.ours.verdict()):
            break
        found = cell.place.distance
    return found


def ordered(found: Limits) -> Ordered:
    """How many of the pairs that the paper tells apart stand in its order here."""
    right = tied = wrong = 0
    for one, other in combinations(found.paper, 2):
        paper = found.paper[one] - found.paper[other]
        ours = found.ours[one] - found.ours[other]
        if paper:
            right, tied = right + (paper * ours > 0), tied + (ours == 0)
            wrong += paper * ours < 0
    return Ordered(right, tied, wrong)


def ranking(distances: Mapping[str, float]) -> list[list[str]]:
    """Grounds from the longest limit to the shortest, those of one limit together."""
    ranks = sorted(set(distances.values()), reverse=True)
    return [[ground for ground, value in distances.items() if value == rank] for rank in ranks]
