"""What a report says in plain words; every claim is computed from the trials."""

from __future__ import annotations

from collections.abc import Mapping

from gaitlab.report.cells import STEP, forward_agreement
from gaitlab.report.comparison import compared_variants, not_told_apart, told_apart
from gaitlab.report.markdown import escape
from gaitlab.report.matching import common
from gaitlab.report.reference import published
from gaitlab.report.results import Results
from gaitlab.report.scores import (
    efficiency_draws,
    fell_standing,
    interval_of,
    mean_percent,
    truth,
)
from gaitlab.report.variants import Value, Variant
from gaitlab.report.words import column_text, interval, path_text, percent, plural, with_unit

MOST_NAMED = 4  # rows or columns in one sentence
FEW_SEEDS = 10  # a cell; the EROS protocol of this project asks for at least as many


def sentences(results: Results, assumed: int) -> str:
    """A few sentences: the effect, where, the paper, what does not stand, what was assumed.

    Args:
        results: What was simulated.
        assumed: Parameters of robot, gait, servos and ground that nobody published.
    """
    parts = [
        _effect(results),
        _everywhere(results),
        _paper(results),
        _not_standing(results),
        _small_n(results),
        _assumptions(assumed),
    ]
    return " ".join(part for part in parts if part)


def _effect(results: Results) -> str:
    if results.done.empty:
        return "No trial has been simulated to its end, so nothing can be said."
    scored = [
        v for v in results.variants if results.of(v)["state"].isin(("DONE", "INFEASIBLE")).any()
    ]
    if len(scored) < 2:
        return _one_variant(results)
    shared = common(results)
    if shared.trials.empty:
        return "The variants have no run in common, so nothing is said of what differs."
    first, best = scored[0], max(scored[1:], key=lambda v: mean_percent(shared.by_column(v)))
    found = compared_variants(results)
    parts = (_difference(shared, first, best), told_apart(found), not_told_apart(found))
    return " ".join(part for part in parts if part)


def _one_variant(results: Results) -> str:
    variant = max(results.variants, key=lambda v: len(results.done_of(v)))
    columns = results.by_column(variant)
    bounds = interval_of(efficiency_draws(columns))
    runs = results.done
    falls, standing = int(truth(runs["fell"]).sum()), fell_standing(runs)
    early = f", in {standing} of them before its first step" if standing else ""
    return (
        f"Efficiency is {percent(mean_percent(columns))} {interval(bounds)}; the robot fell in "
        f"{falls} of {plural(len(runs), 'simulated run')}{early}."
    )


def _difference(results: Results, first: Variant, second: Variant) -> str:
    before, after = results.by_column(first), results.by_column(second)
    change = mean_percent(after) - mean_percent(before)
    return (
        f"From *{escape(first.label)}* to *{escape(second.label)}* efficiency goes from "
        f"{percent(mean_percent(before))} to {percent(mean_percent(after))}, a change of "
        f"{change:+.0f} points."
    )


def _paper(results: Results) -> str:
    compared = [variant for variant in results.variants if variant.compare]
    found = forward_agreement(results, compared)
    if not found or results.rows != STEP:
        return ""
    tables = sorted({published(str(v.compare)).title for v in compared})
    return f"The verdict is the paper's ({' and '.join(tables)}) in {found}."


def _everywhere(results: Results) -> str:
    """Columns and rows in which every cell is stable, and in which none is."""
    verdicts = _verdicts(results)
    if results.done.empty or len(verdicts) < 2:
        return ""
    if len(set(verdicts)) == 1:
        return "Every cell is stable." if verdicts[0] else "No cell is stable."
    columns = {column_text(results, c): _verdicts(results, column=c) for c in results.column_values}
    rows = {_row_text(results, r): _verdicts(results, row=r) for r in results.row_values}
    kinds = (("on" if results.columns == "surface" else "with", columns), ("with", rows))
    told = [_all_or_none(found, word) for word, found in kinds if len(found) > 1]
    return " ".join(text for text in told if text)


def _row_text(results: Results, row: Value) -> str:
    return f"{path_text(results.rows)} {with_unit(results, results.rows, row)}"


def _verdicts(
    results: Results, *, row: Value | None = None, column: Value | None = None
) -> list[bool]:
    """Verdicts of the scored cells of a row or a column, of all variants."""
    rows = results.row_values if row is None else (row,)
    columns = results.column_values if column is None else (column,)
    cells = [results.cell(v, r, c) for v in results.variants for r in rows for c in columns]
    return [bool(cell.verdict()) for cell in cells if cell.n]


def _all_or_none(verdicts: Mapping[str, list[bool]], word: str) -> str:
    stable = [name for name, found in verdicts.items() if found and all(found)]
    fallen = [name for name, found in verdicts.items() if found and not any(found)]
    texts = [
        f"{what} cell is stable {word} {' and '.join(map(escape, names))}."
        for names, what in ((stable, "Every"), (fallen, "No"))
        if names and len(names) <= MOST_NAMED
    ]
    return " ".join(texts)


def _not_standing(results: Results) -> str:
    """Cells whose robot falls before it is told to step."""
    cells = [cell for v in results.variants for cells in results.by_column(v) for cell in cells]
    known = [cell for cell in cells if cell.n]
    fallen = sum(not cell.stands for cell in known)
    if not fallen:
        return ""
    return (
        f"In {fallen} of {plural(len(known), 'cell')} the robot does not stand: most seeds fell "
        "before their first step, which says nothing of the gait. They count as not stable."
    )


def _small_n(results: Results) -> str:
    sizes = [cell.n for v in results.variants for cells in results.by_column(v) for cell in cells]
    smallest = min((n for n in sizes if n), default=0)
    if not smallest or smallest >= FEW_SEEDS:
        return ""
    return (
        f"With {plural(smallest, 'seed')} in the thinnest cell a single verdict can be luck: read "
        "the intervals, not the letters."
    )


def _assumptions(assumed: int) -> str:
    if not assumed:
        return ""
    return (
        f"{plural(assumed, 'parameter')} of robot, gait, servos and ground rest on an assumption "
        "or a reconstruction (bold in the tables at the end); the numbers hold for those values."
    )
