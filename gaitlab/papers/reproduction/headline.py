"""The three lines that a reproduction's page begins with, computed from its results."""

from __future__ import annotations

from collections.abc import Sequence

from gaitlab.papers.printed import eros_tables
from gaitlab.papers.reproduction.answers import (
    Answer,
    Calibrated,
    Judged,
    Limits,
    agreement,
    always_stable,
    judged,
    limits,
    ordered,
    ranking,
    untouched_grounds,
)
from gaitlab.papers.reproduction.efficiency import Simulated, claims, simulated
from gaitlab.papers.reproduction.together import Shown, together
from gaitlab.report.matching import Matched, matched
from gaitlab.report.words import interval, percent, share, surface_text
from gaitlab.statistics import Count, wilson

SHOWN_CLAIMS = ("stated in the text", "counted, all 10 rows")
SHORT = {"stated in the text": "as stated", "counted, all 10 rows": "as its tables count"}
DIRECTION_WORDS = {"forward": "forward cells as printed", "backward": "backward cells"}


def headline(found: Sequence[Answer], calibrated: Calibrated) -> str:
    """A line for each table and one for the efficiency."""
    first = first_answers(found)
    cells = [judged(answer, calibrated) for answer in first]
    lines = [_table_line(answer, here) for answer, here in zip(first, cells, strict=True)]
    if len(first) == 2:
        lines.append(_efficiency_line(first[0], first[1], [*cells[0], *cells[1]]))
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
    """Cells with the printed verdict, which of them were predicted, and the order of grounds."""
    parts = [
        f"{_of(chosen)} {words}{_basis(chosen)}"
        for direction, words in DIRECTION_WORDS.items()
        if (chosen := [cell for cell in cells if cell.place.direction == direction])
    ]
    pairs = ordered(limits(cells))
    if pairs.pairs:
        order = f"{pairs.right} of {pairs.pairs} pairs of pedestals in the paper's order"
        parts.append(f"{order}{_order_basis(cells)}")
    gait = f"{'without' if answer.table is eros_tables()[0] else 'with'} optimisation"
    return f"**{answer.table.title}**, {gait}: {'; '.join(parts)}."


def _order_basis(cells: Sequence[Judged]) -> str:
    """Whether constants were chosen on the rows that the order of the grounds comes from."""
    chosen = [cell.calibrated for cell in cells if cell.place.direction == "forward"]
    if not any(chosen):
        return " (predicted)"
    return f" (constants were chosen on {'all' if all(chosen) else 'some'} of the forward cells)"


def _of(cells: Sequence[Judged]) -> str:
    count = agreement(cells)
    return f"**{count.successes} of {count.n}**"


def _basis(cells: Sequence[Judged]) -> str:
    """What was calibrated and what predicted, and what calling the predicted ones stable gives."""
    held = [cell for cell in cells if not cell.calibrated]
    if not held:
        return " (constants were chosen on them)"
    guess = f"calling each of them stable gives {always_stable(held).successes}"
    if len(held) == len(cells):
        return f" (predicted; {guess})"
    grounds = untouched_grounds(cells)
    apart = all(cell.place.surface in grounds for cell in held)
    named = " and ".join(surface_text(name) for name in grounds)
    where = f", all on {named}" if apart else ""
    count = agreement(held)
    return f", **{count.successes} of the {count.n} predicted** ones{where} ({guess})"


def _efficiency_line(before: Answer, after: Answer, cells: Sequence[Judged]) -> str:
    found = efficiencies(before, after)
    told = {claim.name: claim for claim in claims()}
    paper = ", ".join(
        f"{told[name].with_ - told[name].without:+.0f} {SHORT[name]} "
        f"({told[name].without:.0f} → {told[name].with_:.0f} %)"
        for name in SHOWN_CLAIMS
    )
    chosen = sum(cell.calibrated for cell in cells)
    basis = f", with constants chosen on {chosen} of the {len(cells)} cells" if chosen else ""
    least, most = min(c.ours.n for c in cells), max(c.ours.n for c in cells)
    seeds = str(most) if least == most else f"{least} to {most}"
    n, printed = len(judged(before, {})), len(before.table.cells)
    part_of = "" if n == printed else f" over {n} of the {printed} printed cells"
    return (
        f"**Efficiency**: {percent(found.without)} {interval(found.without_interval)} → "
        f"{percent(found.with_)} {interval(found.with_interval)}, a gain of "
        f"**{found.gain:+.0f} points** {interval(found.gain_interval)}{part_of}{basis}; "
        f"its interval, of the seeds alone ({seeds} a cell), {zero_words(found)}. "
        f"The paper's gain: {paper}."
    )


def zero_words(found: Simulated) -> str:
    """Whether the gain can be told from none."""
    low, high = found.gain_interval
    return "holds zero" if low <= 0.0 <= high else "excludes zero"


def order_sentence(answer: Answer, cells: Sequence[Judged]) -> str:
    """The grounds from the longest stable forward step to the shortest, and the paper's order."""
    found = limits(cells)
    if len(found.paper) < 2:
        return ""
    pairs = ordered(found)
    return (
        f"{answer.table.title}: {_ranked(found, 'ours')}; the paper: {_ranked(found, 'paper')}; "
        f"{pairs.right} of the {pairs.pairs} pairs that the paper tells apart in its order, "
        f"{pairs.tied} tied, {pairs.wrong} reversed."
    )


def _ranked(found: Limits, side: str) -> str:
    distances = found.paper if side == "paper" else found.ours
    ranks = ranking(distances)
    return " > ".join(" = ".join(surface_text(ground) for ground in rank) for rank in ranks)
