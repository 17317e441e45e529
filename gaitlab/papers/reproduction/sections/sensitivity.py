"""Whether an improvement is robust against what was assumed, from a designed sweep.

At every point of a box of assumptions the plain variant and the one with everything switched on
walk the same cells. The section says over which share of the box switching on helps, and which
assumption its improvement hangs on.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import cast

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from gaitlab.experiment import Experiment, SweptRange
from gaitlab.papers.printed import eros_tables
from gaitlab.papers.reproduction.section import Context, Section, option
from gaitlab.papers.reproduction.swept import Sides, Sweep, sweep_of
from gaitlab.render.figure_style import BAND, INK, PAPER, new_figure, save, style, wrapped
from gaitlab.report.cells import STEP
from gaitlab.report.markdown import details, escape, image, table
from gaitlab.report.provenance import seeds_text
from gaitlab.report.results import Results
from gaitlab.report.words import (
    interval,
    path_text,
    percent,
    plural,
    share,
    surface_text,
    with_unit,
)
from gaitlab.statistics import (
    STABLE_SHARE,
    Contrast,
    Interval,
    Side,
    contrast,
    judged,
    runs_of,
    wilson,
)
from gaitlab.statistics.sensitivity import (
    Estimate,
    QuantityEffect,
    Sensitivity,
    fewest_points,
    sensitivity_of,
    sign_shares,
)

OPTIONS = (
    option(
        "labels",
        dict[str, str],
        {},
        "what swept paths are called, {surface.vertical_scale: blade stiffness}",
    ),
)
UNIT = "share of the variance over the box"
IMPROVEMENT = "improvement"  # title of what switching on adds to the stable share
HALF = 0.5  # of the box; a sign that holds in more of it is the rule there
LINE = 0.34  # in, height of a quantity with its range below it
HEAD = 1.25  # in, of titles, axis and legend
NAMED = 0.02  # total index that the interval of a quantity lies above if a sentence names it
DRAWS = 200  # of the seeds, for the indices' intervals
SEED = 20180622  # of those draws
METHOD = """\
A Gaussian process with a length scale for each quantity stands for the response; its noise at a
point is that of the seeds there and one more that all points share. Q² is 1 less its squared error
at points left out, over that of the mean; where that is no better than chance no model is shown.
*First-order*: share of the response's variance over the box that a quantity explains alone;
*total*: the share that it has a part in. *Low to high* is the mean change from end to end of its
range. Intervals are of drawn functions through resampled seeds, length scales held."""
WILSON = """\
Shares of the box with Wilson's 95 % interval, as if its points were drawn at random; they are
spread more evenly than that, so that the intervals are rather too wide. The sign at a point is that
of few walks and has chance in it, the mean over the box has less. A mean is told from none when its
bootstrap interval excludes it and the signed-rank test over the points has p < 0.05."""


def sensitivity_section(section: Section, context: Context) -> str:
    """Signs, effects and their figure for each member that sweeps, as Markdown.

    Raises:
        UsageError: If a member has no design, or varies no switch beside it.
    """
    labels = cast(Mapping[str, str], section.options.get("labels", {}))
    blocks = [
        _member(context.experiments[name], labels, context)
        if name in context.results
        else f"No trial of {escape(name)} has been simulated yet."
        for name in section.experiments
    ]
    return "\n\n".join(blocks)


def _member(experiment: Experiment, labels: Mapping[str, str], context: Context) -> str:
    results = context.results[experiment.name]
    sweep = sweep_of(experiment, results)
    if not len(sweep.places):
        return f"No point of {escape(experiment.name)} has been simulated completely yet."
    names = [_quantity(item, experiment, labels) for item in sweep.design.box]
    return "\n\n".join(
        [
            _setting(sweep, experiment, results, names),
            _signs(sweep),
            *_printed(sweep, experiment, results),
            *_effects(sweep, names, experiment, context),
        ]
    )


def _rows(results: Results) -> str:
    """What every point walks: `step length 0.02 m, 0.06 m`."""
    values = ", ".join(escape(with_unit(results, results.rows, row)) for row in results.row_values)
    return f"{path_text(results.rows)} {values}"


def _setting(sweep: Sweep, experiment: Experiment, results: Results, names: Sequence[str]) -> str:
    """What was walked at how many points."""
    without, with_it = (f"*{escape(label)}*" for label in sweep.labels)
    count = len(sweep.design.box)
    edges = "of one assumed quantity" if count == 1 else f"of {count} assumed quantities"
    text = (
        f"{plural(len(sweep.places), 'point')} of a box {edges}; at each, "
        f"{plural(sweep.walks, 'walk')} of {without} and as many of {with_it} on the same grounds, "
        f"over {_rows(results)}, with the same seeds, {seeds_text(experiment.seeds)} at every "
        "point: what is peculiar to them is in all points, and no interval below tells of it."
    )
    if sweep.left_out:
        text += f" {plural(sweep.left_out, 'point')} with missing or failed walks left out."
    return f"{text}{_beyond(sweep, experiment, names)}"


def _beyond(sweep: Sweep, experiment: Experiment, names: Sequence[str]) -> str:
    """What the experiment itself is set to outside of the box; empty if the box holds it."""
    found = []
    for item, name in zip(sweep.design.box, names, strict=True):
        values = [float(value) for value in experiment.parts.base_values(item.range.path)]
        outside = [v for v in values if not item.range.low <= v <= item.range.high]
        if outside:
            found.append(f"{escape(name)}: {', '.join(f'{value:.3g}' for value in outside)}")
    told = "; ".join(found)
    return f" **What is otherwise set lies outside of this box: {told}.**" if told else ""


def _signs(sweep: Sweep) -> str:
    """Where in the box switching on helps, overall and on each ground."""
    rows = [_sign_row("all grounds", sweep.shares)] if len(sweep.by_ground) > 1 else []
    rows += [_sign_row(surface_text(name), sides) for name, sides in sweep.by_ground.items()]
    names = (f"mean of {escape(label)} [%]" for label in sweep.labels)
    head = ["ground", "better at", "alike at", "worse at", *names, "mean improvement [points]"]
    return f"{_verdict(sweep)}\n\n{table(head, rows, 'l')}\n\n{WILSON}"


def _printed(sweep: Sweep, experiment: Experiment, results: Results) -> list[str]:
    """How near the box comes to what the paper prints for the only row that is walked."""
    before, after = eros_tables()
    if experiment.report.compare not in (before.name, after.name) or results.rows != STEP:
        return []
    steps = [float(row) for row in results.row_values]
    places = [before.place(steps[0], ground, results.reading) for ground in sweep.by_ground]
    there = [place for place in places if place is not None]
    if len(steps) > 1 or len(there) < len(places):
        return []
    without, with_it = (np.array([each.cells[p] for p in there]) for each in (before, after))
    turning = ~without & with_it
    if not turning.any():
        return []
    turned = [
        (sides.without < STABLE_SHARE) & (sides.with_it >= STABLE_SHARE)
        for sides, wanted in zip(sweep.by_ground.values(), turning, strict=True)
        if wanted
    ]
    n, count = len(sweep.places), int(np.all(turned, axis=0).sum())
    most = int(np.max(np.sum(turned, axis=0)))
    gain = 100.0 * (np.mean(with_it) - np.mean(without))
    return [
        f"The paper prints this row stable on {without.sum()} of {len(there)} grounds without and "
        f"on {with_it.sum()} with, {gain:+.0f} points. Its {len(turned)} grounds turn from not "
        f"stable to stable together at **{count} of {n} points of the box** "
        f"({percent(100.0 * count / n)} {interval(wilson(count, n), 100.0)}), at most {most} of "
        "them at any; the largest improvement of the stable share is "
        f"{100.0 * sweep.shares.improvement.max():+.0f} points."
    ]


def _sign_row(name: str, sides: Sides) -> list[str]:
    counts = (share(*count, wilson(*count)) for count in sign_shares(sides.improvement))
    means = (f"{100.0 * np.mean(side):.0f}" for side in sides)
    return [escape(name), *counts, *means, _improvement(sides.improvement)]


def _improvement(improvement: np.ndarray) -> str:
    return f"{100.0 * np.mean(improvement):+.0f} {_points(_against_none(improvement).interval)}"


def _against_none(improvement: np.ndarray) -> Contrast:
    """The mean improvement over independent points against none."""
    place = np.zeros(len(improvement), int), np.arange(len(improvement))
    sides = Side(np.zeros(len(improvement)), *place), Side(improvement, *place)
    found = contrast("improvement", runs_of(*sides, paired=True), "higher")
    return judged([found])[0]


def _points(bounds: Interval) -> str:
    """An interval of changes in percentage points; empty where nothing bounds them."""
    return f"[{100.0 * bounds.low:+.0f}, {100.0 * bounds.high:+.0f}]" if bounds.high < 1e9 else ""


def _verdict(sweep: Sweep) -> str:
    """The sign in one sentence, no stronger than its intervals."""
    improvement = sweep.shares.improvement
    found = sign_shares(improvement)
    mean = (
        f"On average over the box it changes the stable share by {_improvement(improvement)} points"
    )
    apart = _against_none(improvement).verdict in ("better", "worse")
    told = "" if apart else ", which cannot be told from none"
    words = zip(found, ("helps", "makes no difference", "harms"), strict=True)
    rule = [word for count, word in words if wilson(*count).low > HALF]
    what = f"adding *{escape(sweep.labels[1])}*"
    if rule:
        return f"**A{what[1:]} {rule[0]} in more than half of the box.** {mean}{told}."
    return f"**Whether {what} helps in more than half of the box cannot be told.** {mean}{told}."


def _effects(
    sweep: Sweep, names: Sequence[str], experiment: Experiment, context: Context
) -> list[str]:
    """What the improvement and both shares hang on: sentences, a figure and a table of indices."""
    needed = fewest_points(len(names))
    if len(sweep.places) < needed:
        return [
            f"{plural(len(sweep.places), 'point')} cannot tell {len(names)} quantities apart; "
            f"{needed} can."
        ]
    responses = (sweep.by_seed.improvement, *sweep.by_seed)
    titles = (IMPROVEMENT, *sweep.labels)
    fits = {t: _fit(sweep.places, y) for t, y in zip(titles, responses, strict=True)}
    told = "\n".join(f"- {_told(title, fit, names)}" for title, fit in fits.items())
    shown = {title: fit.effects for title, fit in fits.items() if fit.effects}
    if not shown:
        return [told]
    leading = next(iter(shown.values()))
    order = sorted(range(len(names)), key=lambda j: -leading[j].total.value)
    file = f"sensitivity_{experiment.name}"
    labels = [names[j].replace(", ", "\n", 1) for j in order]
    panels = {title: [effects[j] for j in order] for title, effects in shown.items()}
    save(index_dots(panels, labels), context.folder, file)
    return [
        told,
        image("First-order and total index of every quantity", f"{file}.png"),
        details("Every index, and how they are found", _table(shown, names, order), METHOD),
    ]


def _fit(places: np.ndarray, by_seed: np.ndarray) -> Sensitivity:
    """A model of a response. Shapes (n, k) and (n, seeds)."""
    seeds = by_seed.shape[1]
    chosen = np.random.default_rng(SEED).integers(0, seeds, (DRAWS, seeds))
    return sensitivity_of(
        places,
        by_seed.mean(axis=1),
        noise=by_seed.var(axis=1, ddof=1) / seeds if seeds > 1 else 0.0,
        resampled=by_seed[:, chosen].mean(axis=2),
    )


def _told(title: str, fit: Sensitivity, names: Sequence[str]) -> str:
    """The quantities that a response hangs on, or that no model tells of any."""
    subject = (
        "the improvement" if title == IMPROVEMENT else f"the stable share of *{escape(title)}*"
    )
    q_squared = f"Q² = {fit.quality.q_squared:.2f}"
    if not fit.effects:
        told = f"**No model predicts {subject} better than its mean**"
        return f"{told} ({q_squared}); no index is given."
    pairs = sorted(zip(names, fit.effects, strict=True), key=lambda pair: -pair[1].total.value)
    found = [
        f"{escape(name.partition(',')[0])} ({effect.total.value:.2f}, "
        f"{100.0 * effect.change.value:+.0f} points from low to high)"
        for name, effect in pairs
        if effect.total.interval.low > NAMED
    ]
    what = f"{subject[0].upper()}{subject[1:]} ({q_squared})"
    if not found:
        return f"{what} hangs on no quantity whose total index is told from {NAMED}."
    return f"{what} hangs on {', '.join(found)}: total index and mean change."


def _table(
    shown: Mapping[str, Sequence[QuantityEffect]], names: Sequence[str], order: Sequence[int]
) -> str:
    """One row a quantity, three columns for each response that has a model."""
    rows = [
        [
            escape(names[j]),
            *(
                text
                for effects in shown.values()
                for text in (
                    _index(effects[j].first),
                    _index(effects[j].total),
                    f"{100.0 * effects[j].change.value:+.0f} {_points(effects[j].change.interval)}",
                )
            ),
        ]
        for j in order
    ]
    words = ("first-order", "total", "low to high [points]")
    head = [f"{escape(title)}: {word}" for title in shown for word in words]
    return table(["quantity", *head], rows, "l")


def _index(found: Estimate) -> str:
    return f"{found.value:.2f} [{found.interval.low:.2f}, {found.interval.high:.2f}]"


def _quantity(item: SweptRange, experiment: Experiment, labels: Mapping[str, str]) -> str:
    """Name, range and unit: `sole length, 0.106 to 0.144 m`."""
    path = item.range.path
    name = labels.get(path, path.partition(".")[2].replace(".", " ").replace("_", " "))
    unit = experiment.parts.parameter(path).unit
    return (
        f"{name}, {item.range.low:.3g} to {item.range.high:.3g}{'' if unit == '-' else f' {unit}'}"
    )


def index_dots(panels: Mapping[str, Sequence[QuantityEffect]], quantities: Sequence[str]) -> Figure:
    """One line a quantity, in the order given: total index filled, first-order index hollow.

    Args:
        panels: Effects of all quantities by title of the panel.
        quantities: Name and range of each.
    """
    with style():
        figure = new_figure(height=HEAD + LINE * len(quantities))
        axes = figure.subplots(1, len(panels), squeeze=False, sharey=True)[0]
        for axis, (title, effects) in zip(axes, panels.items(), strict=True):
            _draw(axis, effects)
            axis.set_title(wrapped(title, 24), fontsize=9.0)
        axes[0].set_yticks(range(len(quantities)), quantities, fontsize=8.0)
        axes[0].set_ylim(len(quantities) - 0.5, -0.5)
        figure.supxlabel(UNIT, fontsize=9.0)
        texts = ((True, "total index"), (False, "first-order index"))
        keys = [_dot(0.0, 0.0, filled, text) for filled, text in texts]
        figure.legend(handles=keys, loc="outside upper right", ncols=2, fontsize=8.0)
    return figure


def _draw(axis: Axes, effects: Sequence[QuantityEffect]) -> None:
    for place, effect in enumerate(effects):
        if place % 2:
            axis.axhspan(place - 0.5, place + 0.5, color=BAND, linewidth=0)
        for found, down, filled in ((effect.total, -0.14, True), (effect.first, 0.14, False)):
            y = place + down
            axis.plot(found.interval, [y, y], color=INK, linewidth=1.2, solid_capstyle="butt")
            axis.add_line(_dot(found.value, y, filled))
    axis.set_xlim(-0.03, 1.03)
    axis.tick_params(axis="y", length=0)


def _dot(across: float, down: float, filled: bool, label: str = "") -> Line2D:
    return Line2D(
        [across], [down], linestyle="none", label=label, zorder=3, marker="o", markersize=4.5,
        color=INK, markerfacecolor=INK if filled else PAPER,
    )  # fmt: skip
