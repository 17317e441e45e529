"""What a page says in plain words, in at most two sentences; every claim is computed."""

from __future__ import annotations

from collections.abc import Sequence

from gaitlab.report.comparison import Comparison, difference
from gaitlab.report.markdown import escape
from gaitlab.report.results import Results
from gaitlab.report.scores import SCORED, fell_standing, truth
from gaitlab.report.words import plural
from gaitlab.statistics import MOST_SEEDS, Contrast


def findings(
    results: Results, variants: Sequence[Comparison], grounds: Sequence[Comparison]
) -> str:
    """Which variants, and which grounds, can be told apart in staying up, and which cannot."""
    if results.done.empty:
        return "No trial has been simulated to its end, so nothing can be said."
    scored = results.trials[results.trials["state"].isin(SCORED)]
    first = ""
    if scored["variant"].nunique() < 2:
        runs = results.done
        falls, standing = int(truth(runs["fell"]).sum()), fell_standing(runs)
        early = f", in {standing} of them before its first step" if standing else ""
        first = f"The robot fell in {falls} of {plural(len(runs), 'simulated run')}{early}."
    elif not any(item.runs.n for item in variants):
        first = "The variants have no run in common, so nothing is said of what differs."
    kinds = (variants, grounds)
    said = [text for found in kinds for text in (told_apart(found), not_told_apart(found))]
    return " ".join(text for text in (first, *said) if text)


def told_apart(found: Sequence[Comparison]) -> str:
    """Which stays up more or less often than the first, in a sentence; empty if none does."""
    said = []
    for verdict, often in (("better", "more"), ("worse", "less")):
        items = [item for item in found if item.stable.verdict == verdict]
        if items:
            verb = "stays" if len(items) == 1 else "stay"
            said.append(f"{_listed(items, f'{verb} up {often} often than *FIRST*')}.")
    return " ".join(said)


def not_told_apart(found: Sequence[Comparison]) -> str:
    """Which cannot be told from the first, and how many seeds would tell; empty if all are."""
    items = [item for item in found if item.stable.verdict == "cannot tell"]
    if not items:
        return ""
    advice = max((item.stable for item in items), key=_seeds).advice
    text = _listed(items, "cannot be told from *FIRST* in staying up")
    return f"{text}; {advice}." if advice else f"{text}."


def seeds_needed(found: Sequence[Comparison]) -> int | None:
    """Seeds a cell that would tell the differences that are not told; None if no number would."""
    asked = [_seeds(item.stable) for item in found if item.stable.verdict == "cannot tell"]
    return int(max(asked, default=0.0)) or None


def _seeds(stable: Contrast) -> float:
    """Seeds that would tell, 0 where nobody would wait for them."""
    return stable.needed if stable.needed <= MOST_SEEDS else 0.0


def _listed(items: Sequence[Comparison], verb: str) -> str:
    """Who does what, with the differences and what they rest on."""
    names = [f"*{escape(item.second)}*" for item in items]
    done = verb.replace("FIRST", escape(items[0].first))
    if len(items) == 1:
        return f"{names[0]} {done}: {difference(items[0].stable)} over {items[0].counted}"
    gaps = (difference(item.stable) for item in items)
    listed = ", ".join(f"{name} ({gap})" for name, gap in zip(names, gaps, strict=True))
    return f"{listed} {done}"


def not_standing(results: Results) -> str:
    """Cells whose robot falls before it is told to step; empty if there are none."""
    cells = [cell for v in results.variants for cells in results.by_column(v) for cell in cells]
    known = [cell for cell in cells if cell.n]
    fallen = sum(not cell.stands for cell in known)
    if not fallen:
        return ""
    return (
        f"**In {fallen} of {plural(len(known), 'cell')} the robot does not stand: most seeds fell "
        "before their first step, which says nothing of the gait.**"
    )
