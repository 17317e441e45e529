"""How far simulated cells lie from a paper's printed verdicts, and which of the gaps are sure."""

from __future__ import annotations

from collections.abc import Sequence

from gaitlab.papers.reproduction.answers import Judged
from gaitlab.report.markdown import escape
from gaitlab.report.words import letter, surface_text
from gaitlab.statistics import STABLE_SHARE

MOST_NAMED = 6  # cells in a sentence


def gaps_sentence(cells: Sequence[Judged]) -> str:
    """The cells that differ, those that more seeds could not turn round named; empty for none."""
    off = [cell for cell in cells if not cell.agrees()]
    if not off:
        return ""
    clear = sorted(filter(is_clear, off), key=lambda cell: -_gap(cell))
    told = "; ".join(map(_cell_text, clear[:MOST_NAMED]))
    counted = (
        f"{len(off)} of {len(cells)} cells differ from what is printed, {len(clear)} of them with "
        "an interval of the stable share that leaves out one half; of the others seeds cannot tell."
    )
    return f"{counted} Among the largest gaps: {told}." if told else counted


def is_clear(cell: Judged) -> bool:
    """Whether the interval of the stable share leaves out the half that decides."""
    low, high = cell.ours.interval()
    return low > STABLE_SHARE or high < STABLE_SHARE


def _gap(cell: Judged) -> float:
    """Stable share less the printed verdict, unsigned."""
    return abs(cell.ours.share() - float(cell.printed))


def _cell_text(cell: Judged) -> str:
    return (
        f"{cell.table.title} {cell.place.direction} {cell.place.distance:g} on "
        f"{escape(surface_text(cell.place.surface))}, printed {letter(cell.printed)}, "
        f"{cell.ours.count()} of {cell.ours.n} stayed up"
    )
