"""What a report says in plain words; every claim is computed from the trials."""

from __future__ import annotations

from gaitlab.report.cells import STEP, forward_agreement
from gaitlab.report.markdown import escape
from gaitlab.report.reference import published
from gaitlab.report.results import Results
from gaitlab.report.scores import efficiency_draws, interval_of, mean_percent, truth
from gaitlab.report.variants import Variant
from gaitlab.report.words import interval, percent, plural
from gaitlab.statistics import McNemar, mcnemar

LEVEL = 0.05  # two-sided; a larger p is called chance
FEW_SEEDS = 10  # a cell; the EROS protocol of this project asks for at least as many


def sentences(results: Results, assumed: int) -> str:
    """Two to five sentences: the effect, what chance could do, the paper, what was assumed.

    Args:
        results: What was simulated.
        assumed: Parameters of robot, gait, servos and ground that nobody published.
    """
    parts = [_effect(results), _paper(results), _small_n(results), _assumptions(assumed)]
    return " ".join(part for part in parts if part)


def _effect(results: Results) -> str:
    if results.done.empty:
        return "No trial has been simulated to its end, so nothing can be said."
    scored = [
        v for v in results.variants if results.of(v)["state"].isin(("DONE", "INFEASIBLE")).any()
    ]
    if len(scored) < 2:
        return _one_variant(results)
    first, best = scored[0], max(scored[1:], key=lambda v: mean_percent(results.by_column(v)))
    return _difference(results, first, best)


def _one_variant(results: Results) -> str:
    variant = max(results.variants, key=lambda v: len(results.done_of(v)))
    columns = results.by_column(variant)
    bounds = interval_of(efficiency_draws(columns))
    runs = results.done
    falls = int(truth(runs["fell"]).sum())
    return (
        f"Efficiency is {percent(mean_percent(columns))} {interval(bounds)}; the robot fell in "
        f"{falls} of {plural(len(runs), 'simulated run')}."
    )


def _difference(results: Results, first: Variant, second: Variant) -> str:
    before, after = results.by_column(first), results.by_column(second)
    change = mean_percent(after) - mean_percent(before)
    draws = efficiency_draws(after, stream=1) - efficiency_draws(before, stream=0)
    test = mcnemar(paired(results, first, second))
    return (
        f"From *{escape(first.label)}* to *{escape(second.label)}* efficiency goes from "
        f"{percent(mean_percent(before))} to {percent(mean_percent(after))}, a change of "
        f"{change:+.0f} points {interval(interval_of(draws))}. {_paired_text(test, first, second)}"
    )


def paired(results: Results, first: Variant, second: Variant) -> list[tuple[bool, bool]]:
    """Outcomes of runs that both variants share: same row, column and seed."""
    keys = [results.rows, results.columns, "seed"]
    sides = []
    for variant in (first, second):
        trials = results.of(variant)
        trials = trials[trials["state"].isin(("DONE", "INFEASIBLE"))]
        up = truth(trials["stable"])
        sides.append(dict(zip(map(tuple, trials[keys].to_numpy(object)), up, strict=True)))
    return [(bool(sides[0][k]), bool(sides[1][k])) for k in sides[0] if k in sides[1]]


def _paired_text(test: McNemar, first: Variant, second: Variant) -> str:
    if test.only_first + test.only_second == 0:
        return "Run by run, with the same seeds, nothing differs between the two."
    text = (
        f"Run by run, with the same seeds, {test.only_second} stayed up only with "
        f"*{escape(second.label)}* and {test.only_first} only with *{escape(first.label)}* "
        f"(exact McNemar test, p {_p_text(test.p_value)})"
    )
    if test.p_value > LEVEL:
        return f"{text}: at this n the two cannot be told apart."
    return f"{text}: more than chance explains."


def _p_text(p_value: float) -> str:
    return "< 0.001" if p_value < 0.001 else f"= {p_value:.2g}"


def _paper(results: Results) -> str:
    compared = [variant for variant in results.variants if variant.compare]
    found = forward_agreement(results, compared)
    if not found or results.rows != STEP:
        return ""
    tables = sorted({published(str(v.compare)).title for v in compared})
    return f"The verdict is the paper's ({' and '.join(tables)}) in {found}."


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
