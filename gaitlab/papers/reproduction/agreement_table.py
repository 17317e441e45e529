"""How many cells of a printed table each of many variants meets, and how many of the same ones."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from gaitlab.experiment.reference import Place
from gaitlab.papers.reproduction.answers import Answer, Judged, agreement, judged, table_of
from gaitlab.papers.reproduction.headline import count_text
from gaitlab.papers.reproduction.together import Shown
from gaitlab.report.markdown import escape, table
from gaitlab.report.words import NOTHING


def agreement_table(shown: Sequence[Shown]) -> str:
    """Cells with the printed verdict; empty if no variant answers to a printed table."""
    found = {one.label: cells for one in shown if (cells := _cells(one))}
    if not found:
        return ""
    rows = [_row(label, cells, _shared(cells, found.values())) for label, cells in found.items()]
    head = ["cells as printed [95 %]", "table", "forward", "backward", "all", "the same cells"]
    return table(head, rows, "ll")


def _cells(one: Shown) -> list[Judged]:
    """Empty for a variant that answers to no table or has none of its cells."""
    if (reference := table_of(one.variant)) is None:
        return []
    answer = Answer(
        table=reference, experiment=one.experiment, results=one.results, variant=one.variant
    )
    return judged(answer, {})


def _shared(cells: Sequence[Judged], every: Iterable[Sequence[Judged]]) -> set[Place]:
    """Places that all variants beside the same table have."""
    beside = [other for other in every if other[0].table == cells[0].table]
    return set.intersection(*({cell.place for cell in other} for other in beside))


def _row(label: str, cells: Sequence[Judged], shared: set[Place]) -> list[str]:
    groups = [
        *([c for c in cells if c.place.direction == way] for way in ("forward", "backward")),
        cells,
        [c for c in cells if c.place in shared],
    ]
    texts = [count_text(agreement(group)) if group else NOTHING for group in groups]
    return [escape(label), cells[0].table.title, *texts]
