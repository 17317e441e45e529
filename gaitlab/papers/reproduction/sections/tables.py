"""A paper's printed tables beside the simulated ones, cell by cell, folded below the first screen.

The scores, the picture and the sentences of the first screen are `headline`'s.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import cast

from gaitlab.experiment.reference import ReferenceCell, ReferenceTable
from gaitlab.papers.reproduction.answers import (
    Answer,
    Calibrated,
    Judged,
    answers,
    require_known,
)
from gaitlab.papers.reproduction.headline import (
    Scored,
    scored,
)
from gaitlab.papers.reproduction.section import Context, Section, option
from gaitlab.report.markdown import details, escape, table
from gaitlab.report.words import (
    NOTHING,
    letter,
    surface_text,
    verdict_text,
)

OPTIONS = (
    option(
        "calibrated",
        dict[str, dict[str, object] | tuple[dict[str, object], ...]],
        {},
        "cells that constants were chosen on, {eros_table7: {direction: forward, surfaces: [...], "
        "distances: [...]}}; a list where one block does not hold them all",
    ),
)
LEGEND = """\
Each cell: what the paper prints (S stable, U unstable), then for each column of the scores what the
simulation finds and how many of its seeds stayed up; with at least half of them it is stable. **`≠`
in bold where the two differ**; `†` marks a cell that constants were chosen on. Steps out of reach
count as not stable. A cell in which most seeds fall before their first step does not stand, which
is no verdict and agrees with none. `?` marks what rests on a share whose 95 % interval holds one
half."""
GUESSES = """\
*Best verdict a ground* says of each ground and table whichever verdict the paper prints there more
often, with the answer in hand. Intervals are Wilson's; cells of one ground hang together, so they
are narrower than they should be."""


def tables_section(section: Section, context: Context) -> str:
    """The printed cells with what was simulated beside them, as Markdown.

    Raises:
        WrongValue: If the option `calibrated` names what there is not.
    """
    calibrated = cast(Calibrated, section.options["calibrated"])
    require_known(calibrated)
    found = answers(context.results, section.experiments, context.experiments)
    if not found:
        return "No variant here answers to a printed table; an experiment says so by `compare:`."
    columns = scored(found, calibrated)
    references = list(dict.fromkeys(answer.table for answer in found))
    return details(
        "Cell by cell",
        *(_matrix(reference, columns) for reference in references),
        f"{LEGEND} The printed distance is read as {_reading(found[0])}.",
        GUESSES,
    )


def _matrix(reference: ReferenceTable, columns: Sequence[Scored]) -> str:
    """One printed table, its columns side by side in every cell."""
    cells = [{c.place: c for c in one.cells if c.table is reference} for one in columns]
    places = list(dict.fromkeys(place for found in cells for place in found))
    grounds = list(dict.fromkeys(place.surface for place in places))
    rows = sorted({place.printed for place in places}, key=lambda row: (row < 0.0, abs(row)))
    one = next(a for c in columns for a in c.side.answers if a.table is reference)
    reading = reference.readings[one.results.reading]
    body = [
        [
            f"{ReferenceCell(row, '').direction} {abs(row):g}",
            f"{row * reading.one:+.3g} m",
            *(
                _cell([f[place] for f in cells if place in f]) or NOTHING
                for place in (ReferenceCell(row, ground) for ground in grounds)
            ),
        ]
        for row in rows
    ]
    head = ["printed", "step length", *(_pedestal(reference, ground) for ground in grounds)]
    said = " and ".join(escape(c.side.label) for c in columns)
    return f"**{reference.title}**: the paper, then {said}\n\n{table(head, body, 'lr')}"


def _reading(answer: Answer) -> str:
    return answer.table.readings[answer.results.reading].text


def _pedestal(reference: ReferenceTable, ground: str) -> str:
    number = list(reference.stated).index(ground) + 1
    return f"{number}: {escape(surface_text(ground))}"


def _cell(there: Sequence[Judged]) -> str:
    """Printed verdict, and of each column its own and the seeds that stayed up."""
    if not there:
        return ""
    parts = []
    for cell in there:
        reach = "" if cell.ours.feasible else " out of reach"
        sign = "=" if cell.agrees() else "≠"
        parts.append(f"{sign} {verdict_text(cell.ours)} {cell.ours.count()}/{cell.ours.n}{reach}")
    text = f"{letter(there[0].printed)} {', '.join(parts)}"
    text = text if all(cell.agrees() for cell in there) else f"**{text}**"
    return text + (" †" if there[0].calibrated else "")
