"""Variants of several members: how often each stays up, and what it differs from its base in.

Readings of a paper, parts of an optimisation taken alone, other grounds or soles: each is a variant
of a member, set against a base on the cells that both walked, pairs of equal cell and seed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import cast

from gaitlab.papers.reproduction.agreement_table import agreement_table
from gaitlab.papers.reproduction.figures.share_dots import share_dots
from gaitlab.papers.reproduction.section import Context, Section, option
from gaitlab.papers.reproduction.together import (
    Shown,
    called,
    require_labels,
    shown_variants,
    together,
)
from gaitlab.render.figure_style import save
from gaitlab.report.comparison import difference, loud
from gaitlab.report.markdown import details, escape, image, table
from gaitlab.report.matching import matched
from gaitlab.report.results import Results
from gaitlab.report.scores import Cell, efficiency_draws, interval_of, mean_percent
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
Runs that stayed up, of all, and in brackets the Wilson interval of that share in percent. A
difference is taken over the cells that both have walked, in pairs of equal cell and seed; seeds,
not pairs, count as independent, since walks of one seed share their servos (random signs of each
seed's sum). *better* and *worse* hold for the whole column *all*, and apart from it for the columns
of the grounds together: of twenty such tables without any difference at most one names one (Holm).
Where neither is said, the runs cannot tell. Agreement counts every printed cell that a variant has
walked, a step out of reach as not stable, and apart the cells that all variants beside the same
table have walked. In the figure a base is hollow, and the dotted line is the share of the first
one."""


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

    def cells(self, one: Shown) -> dict[str, list[Cell]]:
        """Scored cells of a variant by ground."""
        found: dict[str, list[Cell]] = {}
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
    name = str(section.options["figure"]) or "variants_" + "_".join(section.experiments)
    blocks = [
        _extent(found),
        _share_table(found),
        _reach_sentence(found),
        _figure(found, context, name),
        _difference_table(found),
        agreement_table(found.shown),
        details("How to read these tables", HOW_TO_READ),
    ]
    return "\n\n".join(block for block in blocks if block)


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


def _share_table(found: _Compared) -> str:
    grounds = [str(ground) for ground in found.results.column_values]
    head = [
        "stable runs [%]",
        *(escape(surface_text(g)) for g in grounds),
        "all",
        "efficiency [95 %]",
    ]
    rows = [_share_row(found, one, grounds) for one in found.shown]
    return table(head, rows, "l")


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


def _share_row(found: _Compared, one: Shown, grounds: Sequence[str]) -> list[str]:
    cells = found.cells(one)
    alike = {g: column for g, column in cells.items() if g in found.common} or cells
    every = [cell for column in alike.values() for cell in column]
    texts = [_share(_count(cells[g])) if g in cells else NOTHING for g in grounds]
    whole = _share(_count(every)) if every else NOTHING
    return [escape(one.label), *texts, whole, _efficiency(alike)]


def _efficiency(cells: Mapping[str, Sequence[Cell]]) -> str:
    if not cells:
        return NOTHING
    columns = list(cells.values())
    return f"{percent(mean_percent(columns))} {interval(interval_of(efficiency_draws(columns)))}"


def _count(cells: Sequence[Cell]) -> Count:
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


def _difference_table(found: _Compared) -> str:
    """Each variant against its base, on each ground and on all, one family of tests."""
    grounds = [str(ground) for ground in found.results.column_values]
    walked = [(pair, _contrasts(found, *pair, grounds)) for pair in found.pairs]
    lines = [(pair, line) for pair, line in walked if line[0].n]
    whole = judged([line[0] for _, line in lines])
    parts = iter(judged([contrast for _, line in lines for contrast in line[1:]]))
    rows = [
        [
            escape(one.label),
            escape(base.label),
            _difference(first),
            *(_difference(next(parts)) for _ in line[1:]),
            str(first.n),
        ]
        for ((one, base), line), first in zip(lines, whole, strict=True)
    ]
    if not rows:
        return ""
    titles = (escape(surface_text(ground)) for ground in grounds)
    return table(["difference, points [95 %]", "against", "all", *titles, "pairs"], rows, "ll")


def _contrasts(found: _Compared, one: Shown, base: Shown, grounds: Sequence[str]) -> list[Contrast]:
    runs = matched(found.results, found.variant(base), found.variant(one))
    parts = (runs, *(runs.only(found.results.columns, ground) for ground in grounds))
    return [part.contrast("stable") for part in parts]


def _difference(contrast: Contrast) -> str:
    if not contrast.n:
        return NOTHING
    points = difference(contrast).replace(" points", "")
    return points if contrast.verdict == "cannot tell" else f"{points} {loud(contrast)}"
