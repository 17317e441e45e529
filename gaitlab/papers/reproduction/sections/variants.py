"""Variants of several members: how often each stays up, and what it differs from its base in.

Readings of a paper, parts of an optimisation taken alone, other grounds or soles: each is a variant
of a member, set against a base on the cells that both walked, pairs of equal cell and seed.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from math import ceil
from typing import cast

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gaitlab.papers.reproduction.answers import Answer, Judged, agreement, table_of
from gaitlab.papers.reproduction.answers import judged as judged_cells
from gaitlab.papers.reproduction.headline import count_text
from gaitlab.papers.reproduction.section import Context, Section, option
from gaitlab.papers.reproduction.together import (
    Shown,
    called,
    require_labels,
    shown_variants,
    together,
)
from gaitlab.render.figure_style import BAND, INK, PAPER, new_figure, save, style, wrapped
from gaitlab.report.comparison import difference, loud
from gaitlab.report.markdown import escape, image, table
from gaitlab.report.matching import matched
from gaitlab.report.results import Results
from gaitlab.report.scores import ScoredCell, efficiency_draws, interval_of, mean_percent
from gaitlab.report.variants import Variant
from gaitlab.report.words import (
    NOTHING,
    interval,
    path_text,
    percent,
    plural,
    surface_text,
    with_unit,
)
from gaitlab.statistics import Contrast, Count, judged, wilson

OPTIONS = (
    option("base", str, "", "variant that the others are set against; by default the first"),
    option("against", dict[str, str], {}, "another base for some variants, {variant: base}"),
    option("labels", dict[str, str], {}, "words for variants, {member/variant: words}"),
    option("leave_out", tuple[str, ...], (), "variants that are not shown"),
    option("figure", str, "", "name of the figure's file; by default that of the members"),
)
HOW_TO_READ = """\
Runs that stayed up, of all, with Wilson's interval of that share in percent. A variant less its
base: over the cells that both have walked, runs of equal cell and seed in pairs; *better* and
*worse* hold for the whole table together (Holm), where neither is said the runs cannot tell. *As
printed* counts the printed cells that a variant has walked, a step out of reach as not stable, and
apart those that all variants beside the same table have. In the figure a base is hollow, and the
dotted line is the share of the first one."""
ACROSS = 4  # panels side by side; more go below
LINE = 0.21  # in, height of a variant
HEAD = 0.75  # in, of titles and labels of a row of panels
LETTERS = 30  # of a label, on each of at most three lines


@dataclass(frozen=True, kw_only=True, eq=False)
class _Compared:
    """The variants of a section, and what each is set against."""

    shown: Sequence[Shown]
    bases: Sequence[Shown | None]

    @cached_property
    def results(self) -> Results:
        """All of them in one table: the rows that all have, or if there is none each its own."""
        whole = together(self.shown)
        trials, rows = whole.trials, whole.rows
        own = [set(whole.of(variant)[rows]) for variant in whole.variants]
        common = set.intersection(*own)
        return replace(whole, trials=trials[trials[rows].isin(common)]) if common else whole

    @cached_property
    def common(self) -> tuple[str, ...]:
        """Grounds on which every variant has walked, in their order."""
        walked = [list(self.cells(one)) for one in self.shown]
        walked = [grounds for grounds in walked if grounds]
        first = walked[0] if walked else []
        return tuple(g for g in first if all(g in grounds for grounds in walked))

    @property
    def pairs(self) -> list[tuple[Shown, Shown]]:
        """Each with its base."""
        both = zip(self.shown, self.bases, strict=True)
        return [(one, base) for one, base in both if base is not None]

    def variant(self, one: Shown) -> Variant:
        """The variant in the common table."""
        return next(v for v in self.results.variants if v.label == one.label)

    def cells(self, one: Shown) -> dict[str, list[ScoredCell]]:
        """Scored cells of a variant by ground."""
        found: dict[str, list[ScoredCell]] = {}
        for column in self.results.column_values:
            cells = self.results.column_cells(self.variant(one), column)
            scored = [cell for cell in cells if cell.n]
            if scored:
                found[str(column)] = scored
        return found


def variants_section(section: Section, context: Context) -> str:
    """Shares, differences to a base and agreement of all variants, with a figure.

    Raises:
        UsageError: If the members have different rows.
        WrongValue: If an option names a variant that there is not.
    """
    found = _compared(section, context)
    name = str(section.options["figure"]) or "variants_" + _file_name(section)
    blocks = [
        _extent(found),
        _table(found),
        _reach_sentence(found),
        _figure(found, context, name),
    ]
    return "\n\n".join(block for block in blocks if block)


def _file_name(section: Section) -> str:
    """The section's title and members, in letters that a file may have."""
    words = re.findall(r"[a-z0-9_]+", section.title.lower())
    return "_".join((*words, *section.experiments))[:80]


def _compared(section: Section, context: Context) -> _Compared:
    whole = len(context.results) == len(context.experiments)
    labels = cast(Mapping[str, str], section.options["labels"])
    every = shown_variants(context.results, section.experiments, labels)
    if whole:
        require_labels(every, labels)
    wanted = partial(_wanted, whole=whole)
    hidden = wanted(every, cast("tuple[str, ...]", section.options["leave_out"]))
    shown = [one for one in every if one not in hidden.values()]
    asked = str(section.options["base"])
    base = asked if asked in wanted(shown, [asked]) else shown[0].names[0]
    against = cast(Mapping[str, str], section.options["against"])
    others = {
        one.label: against[name]
        for name, one in wanted(shown, list(against)).items()
        if wanted(shown, [against[name]])
    }
    bases = [_base(shown, one, others.get(one.label, base)) for one in shown]
    return _Compared(shown=shown, bases=bases)


def _wanted(shown: Sequence[Shown], names: Sequence[str], *, whole: bool) -> dict[str, Shown]:
    """The variants of these names; before every member was run only those there are.

    Raises:
        WrongValue: If every member was run and one has none of the names.
    """
    known = {name for one in shown for name in one.names}
    return {name: called(shown, name) for name in names if name and (whole or name in known)}


def _base(shown: Sequence[Shown], one: Shown, name: str) -> Shown | None:
    """What a variant is set against: a member's own base first, for that the first member's."""
    near = called(shown, name, beside=one)
    found = near if near is not one else called(shown, name)
    return None if found is one else found


def _extent(found: _Compared) -> str:
    """Over which rows and grounds shares and differences are taken."""
    results = found.results
    values = ", ".join(escape(with_unit(results, results.rows, row)) for row in results.row_values)
    text = f"Shares and differences are over {path_text(results.rows)} {values}."
    own = {ground for one in found.shown for ground in found.cells(one)}
    if found.common and own != set(found.common):
        names = ", ".join(escape(surface_text(ground)) for ground in found.common)
        return f"{text} *All* of a share, and the efficiency, are over the grounds of all: {names}."
    if not found.common and len(own) > 1:
        return f"{text} No ground is shared by all: *all* and efficiency are of each one's own."
    return text


def _table(found: _Compared) -> str:
    """Each variant with its share, its efficiency, its base and the printed cells it meets."""
    pairs = [(one, matched(found.results, found.variant(base), found.variant(one)))
             for one, base in found.pairs]  # fmt: skip
    walked = [(one, runs.contrast("stable")) for one, runs in pairs]
    walked = [(one, contrast) for one, contrast in walked if contrast.n]
    told = judged([contrast for _, contrast in walked])
    gaps = {one.label: _gap(gap) for (one, _), gap in zip(walked, told, strict=True)}
    cells = {one.label: _judged(one) for one in found.shown}
    beside = any(cells.values())
    head = ["", "stable runs", "efficiency [95 %]", "less its base [95 %]", "base"]
    rows = []
    for one, base in zip(found.shown, found.bases, strict=True):
        gap = gaps.get(one.label, NOTHING)
        against = NOTHING if base is None else escape(base.label)
        met = [_met(cells[one.label], list(cells.values()))] if beside else []
        rows.append([escape(one.label), *_shares(found, one), gap, against, *met])
    return table([*head, *(["cells as printed"] if beside else [])], rows, "l")


def _shares(found: _Compared, one: Shown) -> tuple[str, str]:
    cells = found.cells(one)
    alike = {g: column for g, column in cells.items() if g in found.common} or cells
    every = [cell for column in alike.values() for cell in column]
    return _share(_count(every)) if every else NOTHING, _efficiency(alike)


def _gap(contrast: Contrast) -> str:
    said = "" if contrast.verdict == "cannot tell" else f" {loud(contrast)}"
    return f"{difference(contrast)}{said}, n = {contrast.n}"


def _judged(one: Shown) -> list[Judged]:
    """Cells beside a printed table; empty for a variant that answers to none."""
    if (reference := table_of(one.variant)) is None:
        return []
    return judged_cells(
        Answer(
            table=reference, experiment=one.experiment, results=one.results, variant=one.variant
        ),
        {},
    )


def _met(cells: Sequence[Judged], every: Sequence[Sequence[Judged]]) -> str:
    """How many cells have the printed verdict, and how many of those that all variants have."""
    if not cells:
        return NOTHING
    beside = [other for other in every if other and other[0].table is cells[0].table]
    shared = set.intersection(*({cell.place for cell in other} for other in beside))
    same = agreement([cell for cell in cells if cell.place in shared])
    text = f"{count_text(agreement(cells))} ({cells[0].table.title})"
    if same.n in (0, len(cells)):
        return text
    return f"{text}; the same cells {same.successes}/{same.n}"


def _reach_sentence(found: _Compared) -> str:
    """What was out of reach, and the efficiency without it; empty if nothing was."""
    parts = []
    for one in found.shown:
        cells = found.cells(one)
        every = [cell for column in cells.values() for cell in column]
        lost = sum(not cell.feasible for cell in every)
        if lost:
            within = {g: [c for c in column if c.feasible] for g, column in cells.items()}
            left = {ground: column for ground, column in within.items() if column}
            parts.append(
                f"*{escape(one.label)}* {lost} of {plural(len(every), 'cell')} (efficiency without "
                f"them {_efficiency(left)})"
            )
    told = "; ".join(parts)
    return f"Steps out of the legs' reach count as not stable: {told}." if told else ""


def _efficiency(cells: Mapping[str, Sequence[ScoredCell]]) -> str:
    if not cells:
        return NOTHING
    columns = list(cells.values())
    return f"{percent(mean_percent(columns))} {interval(interval_of(efficiency_draws(columns)))}"


def _count(cells: Sequence[ScoredCell]) -> Count:
    return Count(sum(cell.count() for cell in cells), sum(cell.n for cell in cells))


def _share(count: Count) -> str:
    """Runs that stayed up of all, and the interval of their share in percent."""
    return f"{count.successes}/{count.n} {interval(wilson(*count), 100.0)}"


def _figure(found: _Compared, context: Context, name: str) -> str:
    counts = {
        one.label: {ground: _count(cells) for ground, cells in found.cells(one).items()}
        for one in found.shown
    }
    if not any(counts.values()):
        return ""
    bases = list(dict.fromkeys(base.label for _, base in found.pairs))
    save(share_dots(counts, bases), context.folder, name)
    what = f"Stable share of {plural(len(counts), 'variant')} on each ground, with intervals"
    return image(what, f"{name}.png")


def share_dots(counts: Mapping[str, Mapping[str, Count]], bases: Sequence[str]) -> Figure:
    """Dots over [0, 100] percent, in the order given; bases are hollow, with a line down.

    Args:
        counts: By label of the variant, then by ground; a ground that is not there leaves a gap.
        bases: Labels of those that others are compared with.
    """
    grounds = list(dict.fromkeys(ground for found in counts.values() for ground in found))
    across, down = min(ACROSS, len(grounds)), ceil(len(grounds) / ACROSS)
    with style():
        figure = new_figure(height=down * (HEAD + LINE * len(counts)))
        axes = figure.subplots(down, across, squeeze=False, sharey=True)
        for index, axis in enumerate(axes.ravel()):
            axis.set_visible(index < len(grounds))
            if index < len(grounds):
                _draw(axis, {k: v.get(grounds[index]) for k, v in counts.items()}, bases)
                axis.set_title(wrapped(surface_text(grounds[index]), 16))
        for row in axes:
            row[0].set_yticks(range(len(counts)), [wrapped(name, LETTERS) for name in counts])
            row[0].set_ylim(len(counts) - 0.4, -0.6)
    return figure


def _draw(axis: Axes, counts: Mapping[str, Count | None], bases: Sequence[str]) -> None:
    for place, (label, count) in enumerate(counts.items()):
        if place % 2:
            axis.axhspan(place - 0.5, place + 0.5, color=BAND, linewidth=0)
        if count is None or not count.n:
            continue
        share, (low, high) = 100.0 * count.successes / count.n, wilson(*count)
        axis.plot([100.0 * low, 100.0 * high], [place, place], color=INK, linewidth=1.2)
        hollow = label in bases
        axis.plot(
            [share], [place], marker="D" if hollow else "o", markersize=5.0, color=INK,
            markerfacecolor=PAPER if hollow else INK,
        )  # fmt: skip
    first = counts.get(bases[0]) if bases else None
    if first is not None and first.n:
        axis.axvline(100.0 * first.successes / first.n, color=INK, linewidth=0.6, linestyle=":")
    axis.set_xlim(-4, 104)
    axis.set_xticks([0, 50, 100])
    axis.set_xlabel("stable runs [%]")
    axis.tick_params(axis="y", length=0, labelsize=7.5)
