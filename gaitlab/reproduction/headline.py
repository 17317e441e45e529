"""The three lines that a reproduction's page begins with, computed from its results."""

from __future__ import annotations

from collections.abc import Sequence

from gaitlab.report.comparison.matching import Matched, matched
from gaitlab.report.words import interval, percent, share, surface_text
from gaitlab.reproduction.answers import (
    Answer,
    Calibrated,
    Judged,
    agreement,
    judged,
    untouched_grounds,
)
from gaitlab.reproduction.efficiency import Simulated, claims, simulated
from gaitlab.reproduction.order import Limits, limits, ordered, ranking
from gaitlab.reproduction.together import Shown, together
from gaitlab.statistics import Count, wilson

SHOWN_CLAIMS = ("stated in the text", "counted, all 10 rows")
SHORT = {"stated in the text": "stated", "counted, all 10 rows": "counted"}


def headline(found: Sequence[Answer], calibrated: Calibrated) -> str:
    """A line for each table, one for the efficiency, and the order of the pedestals."""
    first = first_answers(found)
    lines = [_table_line(answer, judged(answer, calibrated)) for answer in first]
    if len(first) == 2:
        lines.append(_efficiency_line(first[0], first[1]))
    lines += [_order_line(answer, judged(answer, calibrated)) for answer in first]
    return "\n".join(f"- {line}" for line in lines if line)


def first_answers(found: Sequence[Answer]) -> list[Answer]:
    """The first answer to each table."""
    return list({answer.table.name: answer for answer in reversed(found)}.values())[::-1]


def count_text(count: Count) -> str:
    """Count, n, percentage and Wilson interval."""
    return share(*count, wilson(*count)) if count.n else "0/0"


def efficiencies(before: Answer, after: Answer) -> Simulated:
    """Efficiencies of two answers and the gain."""
    return simulated(before, after, paired_runs(before, after))


def paired_runs(before: Answer, after: Answer) -> Matched:
    """Runs of two answers in the cells that both have, paired by seed where they can be."""
    sides = (("before", before), ("after", after))
    shown = [
        Shown(label=label, experiment=a.experiment, results=a.results, variant=a.variant)
        for label, a in sides
    ]
    results = together(shown)
    return matched(results, *results.variants)


def _table_line(answer: Answer, cells: Sequence[Judged]) -> str:
    """Forward cells with the printed verdict, and which of them were predicted."""
    forward = [cell for cell in cells if cell.place.direction == "forward"]
    backward = [cell for cell in cells if cell.place.direction == "backward"]
    parts = [f"{_of(forward)} forward cells as printed{_basis(forward)}"]
    if backward:
        parts.append(f"{_of(backward)} backward cells{_basis(backward)}")
    return f"**{answer.table.title}**: {'; '.join(parts)}."


def _of(cells: Sequence[Judged]) -> str:
    count = agreement(cells)
    return f"**{count.successes} of {count.n}**"


def _basis(cells: Sequence[Judged]) -> str:
    """What was calibrated and what predicted, in brackets."""
    fit = [cell for cell in cells if cell.calibrated]
    if not fit:
        return " (predicted)"
    if len(fit) == len(cells):
        return " (calibrated on them)"
    held = [cell for cell in cells if not cell.calibrated]
    grounds = untouched_grounds(cells)
    count = agreement(held)
    named = " and ".join(surface_text(name) for name in grounds)
    apart = all(cell.place.surface in grounds for cell in held)
    where = f" on the grounds that no constant was chosen on, {named}" if apart else ""
    return f", of which {count.successes} of {count.n} predicted{where}"


def _efficiency_line(before: Answer, after: Answer) -> str:
    found = efficiencies(before, after)
    told = {claim.name: claim for claim in claims()}
    paper = ", ".join(
        f"{told[name].without:.0f} → {told[name].with_:.0f} % {SHORT[name]}"
        for name in SHOWN_CLAIMS
    )
    return (
        f"**Efficiency**: {percent(found.without)} {interval(found.without_interval)} → "
        f"{percent(found.with_)} {interval(found.with_interval)}, a gain of "
        f"**{found.gain:+.0f} points** {interval(found.gain_interval)}{_part_of(before)}; "
        f"the paper: {paper}."
    )


def _part_of(answer: Answer) -> str:
    """How many of the printed cells are here, if not all."""
    n, printed = len(judged(answer, {})), len(answer.table.cells)
    return "" if n == printed else f" over {n} of the {printed} printed cells"


def _order_line(answer: Answer, cells: Sequence[Judged]) -> str:
    """The grounds from the longest stable forward step to the shortest."""
    found = limits(cells)
    if len(found.paper) < 2:
        return ""
    pairs = ordered(found)
    return (
        f"Order of the pedestals, {answer.table.title}: {_ranked(found, 'ours')}; the paper: "
        f"{_ranked(found, 'paper')}; {pairs.right} of the {pairs.pairs} pairs that the paper tells "
        f"apart in its order, {pairs.tied} tied, {pairs.wrong} reversed."
    )


def _ranked(found: Limits, side: str) -> str:
    distances = found.paper if side == "paper" else found.ours
    ranks = ranking(distances)
    return " > ".join(" = ".join(surface_text(ground) for ground in rank) for rank in ranks)
