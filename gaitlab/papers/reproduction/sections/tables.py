"""A paper's printed tables beside the simulated ones, cell by cell, and what agreement is worth.

The agreement is counted apart for the cells that constants were chosen on and for those that were
predicted, and set beside what guessing gives.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import cast

from gaitlab.experiment.reference import ReferenceCell
from gaitlab.papers.reproduction.answers import (
    Answer,
    Calibrated,
    Judged,
    agreement,
    always_stable,
    answers,
    best_constant,
    forward_only,
    judged,
    require_known,
)
from gaitlab.papers.reproduction.efficiency import Simulated, claims
from gaitlab.papers.reproduction.headline import (
    count_text,
    efficiencies,
    first_answers,
    order_sentence,
)
from gaitlab.papers.reproduction.section import Context, Section, option
from gaitlab.report.markdown import escape, table
from gaitlab.report.words import (
    NOTHING,
    interval,
    letter,
    percent,
    surface_text,
    verdict_text,
)
from gaitlab.statistics import Count

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
Each cell: what the paper prints (S stable, U unstable), what the simulation finds, and how many of
its seeds stayed up; with at least half of them it is stable. **`≠` in bold where the two differ**;
`†` marks a cell that constants were chosen on; *predicted* is a cell by whose outcome no constant
was chosen. Steps out of reach count as not stable. A cell in which most seeds fall before their
first step does not stand, which is no verdict and agrees with none. `?` marks what rests on a share
whose 95 % interval holds one half."""
GUESSES = """\
*Always S* says stable of every cell. *Best constant* says of each ground and table whichever
verdict the paper prints there more often, with the answer in hand. Intervals are Wilson's; cells of
one ground hang together, so they are narrower than they should be."""
STRICT = """\
*Strict* counts a walk as stable only if it also covered half of the commanded distance; the paper
asks for no fall alone."""
BACKWARD = """\
The backward blocks of the two tables are printed identical, and the percentages that the text
states for Table 7 do not fit its own; the backward rows therefore say little about the simulation,
and the forward rows are counted apart."""
SEEDS = """\
Intervals in this table are of the seeds alone, cells taken as independent: of what was assumed and
of the choice of constants there is nothing in them."""
CLAIMS = """\
The text states 32 → 80 %; counting the printed cells gives 50 → 80 %. With 0, 0, 0 and 2 stable
backward rows in Table 7 the same counting gives the pedestals' stated 10, 10, 30 and 80 %, which
suggests that its backward block was printed from Table 8; nothing in the paper proves it."""


def tables_section(section: Section, context: Context) -> str:
    """Matrices, agreement, order of the grounds and efficiency, as Markdown.

    Raises:
        WrongValue: If the option `calibrated` names what there is not.
    """
    calibrated = cast(Calibrated, section.options["calibrated"])
    require_known(calibrated)
    found = answers(context.results, section.experiments)
    if not found:
        return "No variant here answers to a printed table; an experiment says so by `compare:`."
    cells = {id(answer): judged(answer, calibrated) for answer in found}
    every = [(answer, cells[id(answer)]) for answer in found]
    told = (order_sentence(answer, cells) for answer, cells in every)
    lines = "\n".join(f"- {text}" for text in told if text)
    order = f"### Order of the pedestals\n\n{lines}" if lines else ""
    blocks = [
        f"{LEGEND} The printed distance is read as {_reading(found[0])}.",
        *(_matrix(answer, judgements, found) for answer, judgements in every),
        _agreement(every),
        order,
        _efficiency(first_answers(found)),
    ]
    return "\n\n".join(block for block in blocks if block)


Every = Sequence[tuple[Answer, Sequence[Judged]]]


def _name(answer: Answer, found: Sequence[Answer]) -> str:
    """The table, and the variant where several answer to it."""
    several = sum(other.table is answer.table for other in found) > 1
    tail = f"{answer.experiment}, {answer.label}" if several else answer.label
    return f"{answer.table.title}, {escape(tail)}"


def _matrix(answer: Answer, cells: Sequence[Judged], found: Sequence[Answer]) -> str:
    grounds = list(dict.fromkeys(cell.place.surface for cell in cells))
    rows = list(dict.fromkeys(cell.place.printed for cell in cells))
    rows.sort(key=lambda row: row < 0.0)
    at = {cell.place: cell for cell in cells}
    reading = answer.table.readings[answer.results.reading]
    body = [
        [
            f"{ReferenceCell(row, '').direction} {abs(row):g}",
            f"{row * reading.one:+.3g} m",
            *(
                _cell(at[ReferenceCell(row, g)]) if ReferenceCell(row, g) in at else NOTHING
                for g in grounds
            ),
        ]
        for row in rows
    ]
    head = ["printed", "step length", *(f"{_pedestal(answer, g)}" for g in grounds)]
    return f"### {_name(answer, found)}\n\n{table(head, body, 'lr')}"


def _reading(answer: Answer) -> str:
    return answer.table.readings[answer.results.reading].text


def _pedestal(answer: Answer, ground: str) -> str:
    number = list(answer.table.stated).index(ground) + 1
    return f"{number}: {escape(surface_text(ground))}"


def _cell(cell: Judged) -> str:
    """Printed verdict, ours, and seeds that stayed up."""
    ours = verdict_text(cell.ours)
    reach = "" if cell.ours.feasible else " out of reach"
    sign = "=" if cell.agrees() else "≠"
    text = f"{letter(cell.printed)} {sign} {ours} {cell.ours.count()}/{cell.ours.n}{reach}"
    text = text if cell.agrees() else f"**{text}**"
    return text + (" †" if cell.calibrated else "")


def _short(count: Count) -> str:
    return f"{count.successes}/{count.n}"


KINDS: tuple[tuple[str, Callable[[Judged], bool]], ...] = (
    ("forward", lambda cell: cell.place.direction == "forward"),
    ("backward", lambda cell: cell.place.direction == "backward"),
    ("calibrated on", lambda cell: cell.calibrated),
    ("predicted, forward", lambda c: not c.calibrated and c.place.direction == "forward"),
    ("predicted, backward", lambda c: not c.calibrated and c.place.direction == "backward"),
    ("predicted, all", lambda cell: not cell.calibrated),
)


def _agreement(every: Every) -> str:
    """Cells as printed by direction, calibrated or predicted, beside what guessing gives."""
    rows = []
    found = [answer for answer, _ in every]
    for answer, cells in every:
        for kind, wanted in KINDS:
            chosen = [cell for cell in cells if wanted(cell)]
            if chosen:
                counts = agreement(chosen, "stable_strict"), always_stable(chosen)
                texts = map(_short, (*counts, best_constant(chosen)))
                rows.append(
                    [f"{_name(answer, found)}: {kind}", count_text(agreement(chosen)), *texts]
                )
    head = ["cells", "as printed [95 %]", "strict", "always S", "best constant a ground"]
    return f"### Agreement\n\n{table(head, rows, 'l')}\n\n{STRICT} {GUESSES} {BACKWARD}"


def _efficiency(first: Sequence[Answer]) -> str:
    """The paper's percentages under every way of counting, and ours with their intervals."""
    if len(first) < 2:
        return ""
    ours = efficiencies(first[0], first[1])
    paper = [
        [
            f"paper, {c.name}",
            f"{c.without:.3g} %",
            f"{c.with_:.3g} %",
            f"{c.with_ - c.without:+.3g}",
        ]
        for c in claims()
    ]
    rows = [*paper, _simulated_row("simulated, all rows", ours)]
    forward = [forward_only(answer) for answer in first]
    if all(
        len(a.results.trials) < len(b.results.trials) for a, b in zip(forward, first, strict=True)
    ):
        rows.append(_simulated_row("simulated, forward rows", efficiencies(forward[0], forward[1])))
    head = ["efficiency", "without [95 %]", "with [95 %]", "gain, points [95 %]"]
    pairs = "drawn in pairs of equal cell and seed" if ours.paired else "without common seeds"
    note = f"{CLAIMS} The interval of the gain is {pairs}. {SEEDS}"
    return f"### Efficiency\n\n{table(head, rows, 'l')}\n\n{note}"


def _simulated_row(name: str, found: Simulated) -> list[str]:
    return [
        f"**{name}**",
        f"{percent(found.without)} {interval(found.without_interval)}",
        f"{percent(found.with_)} {interval(found.with_interval)}",
        f"{found.gain:+.0f} {interval(found.gain_interval)}",
    ]
