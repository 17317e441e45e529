"""What a reproduction's page begins with: the scores, a picture of them and three sentences.

Cells by whose outcome no constant was chosen come first, those that constants were chosen on after
them, each beside what guessing scores.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from gaitlab.experiment.experiment import ENGINE
from gaitlab.experiment.reference import ReferenceTable
from gaitlab.papers.reproduction.answers import (
    Answer,
    AnswerColumn,
    Calibrated,
    Judged,
    Limits,
    agreement,
    always_stable,
    best_constant,
    judged,
    limits,
    ordered,
    ranking,
    sides,
)
from gaitlab.papers.reproduction.efficiency import Simulated, claims, differing, simulated
from gaitlab.papers.reproduction.section import Context
from gaitlab.papers.reproduction.together import Shown, together
from gaitlab.render.figure_style import (
    INK,
    letters_on,
    new_figure,
    save,
    share_colours,
    style,
    surface_text,
    wrapped,
)
from gaitlab.report.agreement import Agreement, agreement_sentence
from gaitlab.report.agreement import agreement as engines_agreement
from gaitlab.report.markdown import escape, image, table
from gaitlab.report.matching import Matched, matched
from gaitlab.report.words import interval, percent, plural, share
from gaitlab.statistics import Count, wilson

SHOWN_CLAIMS = ("stated in the text", "counted, all 10 rows")
SHORT = {"stated in the text": "as stated", "counted, all 10 rows": "as its tables count"}
PICTURE = "tables"  # file of the figure
ROW = 0.19  # in, height of a printed row in the figure
ABOVE = 1.15  # in, of titles and labels


class Scored(NamedTuple):
    """A column of the page: what stands beside the printed tables, cell by cell."""

    side: AnswerColumn
    cells: tuple[Judged, ...]


def scored(found: Sequence[Answer], calibrated: Calibrated) -> list[Scored]:
    """Every column with its cells, Table 7 first."""
    return [
        Scored(side, tuple(cell for answer in side.answers for cell in judged(answer, calibrated)))
        for side in sides(found)
    ]


def front(found: Sequence[Answer], calibrated: Calibrated, context: Context) -> list[str]:
    """Scores and efficiencies, a picture and three sentences, as blocks of Markdown."""
    columns = [one for one in scored(found, calibrated) if one.cells]
    if not columns:
        return []
    save(verdict_figure(columns), context.folder, PICTURE)
    what = "Printed verdicts and the share of runs that stay up beside them, cell by cell"
    lines = "\n".join(f"- {line}" for line in headline(columns))
    return [score_table(columns), efficiency_table(columns), image(what, f"{PICTURE}.png"), lines]


def headline(columns: Sequence[Scored]) -> list[str]:
    """A sentence on the predicted cells, on the gain, on what it lacks and on the engines."""
    engines = engines_agree(columns)
    return [
        sentence
        for sentence in (
            _predicted_sentence(columns),
            _gain_sentence(columns),
            _missing_sentence(columns),
            agreement_sentence(engines) if engines else "",
        )
        if sentence
    ]


def engines_agree(columns: Sequence[Scored]) -> Agreement | None:
    """How far the first two engines agree; None where the answers are of one."""
    if len(columns) < 2 or len({a.engine for one in columns for a in one.side.answers}) < 2:
        return None
    results = columns[0].side.answers[0].results
    frames = [
        answer.results.of(answer.variant).assign(**{ENGINE: answer.engine, "variant": "all"})
        for one in columns[:2]
        for answer in one.side.answers
    ]
    trials = pd.concat([frame.drop(columns="experiment", errors="ignore") for frame in frames])
    return engines_agreement(replace(results, trials=trials.reset_index(drop=True)))


def score_table(columns: Sequence[Scored]) -> str:
    """Cells as printed: predicted ones first, then those that constants were chosen on."""
    rows = [_score_row("**predicted, all**", columns, lambda cell: not cell.calibrated)]
    for basis, chosen in (("predicted", False), ("chosen on", True)):
        for reference in dict.fromkeys(cell.table for one in columns for cell in one.cells):
            for direction in ("forward", "backward"):
                rows.append(
                    _score_row(
                        f"{basis}: {reference.title}, {direction}",
                        columns,
                        partial(_belongs, reference, direction, chosen),
                    )
                )
    head = [
        "cells as printed [95 %]",
        *(f"{escape(one.side.label)}{_seeds(one)}" for one in columns),
        "calling each stable",
        "best verdict a ground",
    ]
    return table(head, [row for row in rows if row], "l")


def _belongs(reference: ReferenceTable, direction: str, chosen: bool, cell: Judged) -> bool:
    return (
        cell.table is reference and cell.place.direction == direction and cell.calibrated is chosen
    )


def _score_row(name: str, columns: Sequence[Scored], wanted: Callable[[Judged], bool]) -> list[str]:
    """A group of cells in every column and under guessing; empty where no column has any."""
    groups = [[cell for cell in one.cells if wanted(cell)] for one in columns]
    largest = max(groups, key=len)
    if not largest:
        return []
    guesses = (always_stable(largest), best_constant(largest))
    counts = (count_text(agreement(cells)) for cells in groups)
    return [name, *counts, *(f"{guess.successes}/{guess.n}" for guess in guesses)]


def _seeds(one: Scored) -> str:
    """Seeds a cell of a column."""
    least, most = min(c.ours.n for c in one.cells), max(c.ours.n for c in one.cells)
    count = plural(most, "seed")
    return f", {count if least == most else f'{least} to {count}'} a cell"


def efficiency_table(columns: Sequence[Scored]) -> str:
    """The paper's efficiencies as stated and as counted, and those of every column."""
    rows = [
        [f"paper, {SHORT[claim.name]}", percent(claim.without), percent(claim.with_),
         f"{claim.with_ - claim.without:+.0f} points"]
        for claim in claims()
        if claim.name in SHOWN_CLAIMS
    ]  # fmt: skip
    ours = [
        [f"**{escape(label)}**", f"{percent(found.without)} {interval(found.without_interval)}",
         f"{percent(found.with_)} {interval(found.with_interval)}", _gain(found)]
        for label, found in _gains(columns)
    ]  # fmt: skip
    head = ["efficiency [95 %]", "plain gait", "heel strike and deceleration", "gain"]
    return table(head, [*rows, *ours], "l") if ours else ""


def _gains(columns: Sequence[Scored]) -> Iterator[tuple[str, Simulated]]:
    for one in columns:
        if len(one.side.answers) == 2:
            yield one.side.label, efficiencies(*one.side.answers)


def _gain(found: Simulated) -> str:
    return f"**{found.gain:+.0f} points** {interval(found.gain_interval)}"


def _predicted_sentence(columns: Sequence[Scored]) -> str:
    """How many predicted cells come out as printed, and what calling each stable gives."""
    held = [(one.side.label, [c for c in one.cells if not c.calibrated]) for one in columns]
    held = [(label, cells) for label, cells in held if cells]
    if not held:
        return "**No cell was predicted**: constants were chosen on all of them."
    counts = [
        f"**{agreement(cells).successes} of {len(cells)}** in {escape(label)}"
        for label, cells in held
    ]
    guess = always_stable(max((cells for _, cells in held), key=len))
    return (
        f"Predicted cells as printed: {', '.join(counts)}; calling each of them stable gives "
        f"{guess.successes}."
    )


def _gain_sentence(columns: Sequence[Scored]) -> str:
    """The gain in every column, whether it is told from none, and the paper's own."""
    gains = list(_gains(columns))
    if not gains:
        return ""
    told = {claim.name: claim for claim in claims()}
    paper = ", ".join(
        f"{told[name].with_ - told[name].without:+.0f} {SHORT[name]}" for name in SHOWN_CLAIMS
    )
    ours = "; ".join(
        f"{_gain(found)} in {escape(label)}, which {zero_words(found)}" for label, found in gains
    )
    return f"Gain in efficiency: {ours}{_part_of(columns)}. The paper's: {paper}."


def _missing_sentence(columns: Sequence[Scored]) -> str:
    """Which cells of the first column make the gain smaller than the printed one."""
    if len(columns[0].side.answers) != 2:
        return ""
    found = differing(columns[0].cells)
    missing = [each for each in found if each.points < 0.0]
    total = sum(each.points for each in found)
    if total >= 0.0:
        return ""
    told = "; ".join(f"{-each.points:.3g} in {each.text}" for each in missing)
    rest = total - sum(each.points for each in missing)
    given = f"; {rest:.3g} come back in other cells" if rest else ""
    where = escape(columns[0].side.label)
    return f"{-total:.3g} points of the printed gain are missing in {where}: {told}{given}."


def _part_of(columns: Sequence[Scored]) -> str:
    """Over how many of the printed cells, if not over all."""
    n = max(len(one.cells) for one in columns)
    printed = sum(len(answer.table.cells) for answer in columns[0].side.answers)
    return "" if n == printed else f", over {n} of the {printed} printed cells"


def verdict_figure(columns: Sequence[Scored]) -> Figure:
    """Printed verdicts of every ground and row, and beside each the stable shares found here."""
    references = list(dict.fromkeys(cell.table for one in columns for cell in one.cells))
    rows = max(len({c.place.printed for one in columns for c in one.cells if c.table is r})
               for r in references)  # fmt: skip
    with style():
        figure = new_figure(height=ABOVE + ROW * (rows + 1))
        axes = figure.subplots(1, len(references), squeeze=False)[0]
        for axis, reference in zip(axes, references, strict=True):
            _draw(axis, reference, columns)
        labels = ", ".join(["paper", *(one.side.label for one in columns)])
        figure.supxlabel(
            f"on each ground from left to right: {labels}; dark: stays up; \u2260: another verdict "
            "than the paper's; \u2020: a constant was chosen on it",
            fontsize=7.5,
        )
    return figure


def _draw(axis: Axes, reference: ReferenceTable, columns: Sequence[Scored]) -> None:
    """One printed table: a block of columns a ground, a line a printed row."""
    cells = [{c.place: c for c in one.cells if c.table is reference} for one in columns]
    places = list(dict.fromkeys(place for found in cells for place in found))
    grounds = list(dict.fromkeys(place.surface for place in places))
    rows = sorted({place.printed for place in places}, key=lambda row: (row < 0.0, abs(row)))
    width = len(columns) + 1
    for place in places:
        x, y = grounds.index(place.surface) * (width + 0.6), rows.index(place.printed)
        there = [found[place] for found in cells if place in found]
        mark = "\u2020" if there[0].calibrated else ""
        _patch(axis, x, y, float(there[0].printed), mark)
        for index, found in enumerate(cells):
            if place in found:
                mark = "" if found[place].agrees() else "\u2260"
                _patch(axis, x + 1 + index, y, found[place].ours.share(), mark)
    axis.set_xlim(-0.1, len(grounds) * (width + 0.6) - 0.5)
    axis.set_ylim(len(rows) - 0.4, -0.6)
    axis.set_yticks(
        range(len(rows)), [f"{'back ' if row < 0.0 else ''}{abs(row):g}" for row in rows]
    )
    ticks = [index * (width + 0.6) + width / 2.0 for index in range(len(grounds))]
    axis.set_xticks(ticks, [wrapped(surface_text(ground), 8) for ground in grounds], fontsize=8.0)
    axis.tick_params(length=0)
    axis.spines[:].set_visible(False)
    axis.set_title(reference.title)


def _patch(axis: Axes, x: float, y: int, share_up: float, mark: str) -> None:
    face = share_colours()(share_up)
    axis.add_patch(
        Rectangle((x, y - 0.45), 0.94, 0.9, facecolor=face, edgecolor=INK, linewidth=0.3)
    )
    if mark:
        ink = letters_on(share_up)
        axis.text(x + 0.47, y, mark, ha="center", va="center", fontsize=8.0, color=ink)


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
