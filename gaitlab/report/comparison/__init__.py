"""Which of the variants of a page walks better, in what, by how much, and what n would tell."""

from __future__ import annotations

from collections.abc import Sequence

from gaitlab.report.comparison.contrast import (
    Contrast,
    Verdict,
    metric_contrast,
    stable_contrast,
    verdicts,
)
from gaitlab.report.comparison.grid import cell_grid
from gaitlab.report.comparison.matching import Matched, matched, matched_grounds
from gaitlab.report.comparison.tables import difference, surface_table, whole_table
from gaitlab.report.markdown import escape, section
from gaitlab.report.results import Results
from gaitlab.report.variants import Variant
from gaitlab.report.words import plural, surface_text

__all__ = ["comparison"]

METRICS = ("distance", "walking_speed", "pitch_amplitude", "cost_of_transport")
MOST_VARIANTS = 12  # that are set against the first one; more make no page
MOST_GROUNDS = 6  # of one gait, likewise
HOW_TO_READ = """\
*better* and *worse* hold for all lines of a comparison together: of twenty comparisons without any
difference at most one names one (Holm); where nothing is said, the runs cannot tell. Pairs have the
same cell and seed. Stable runs: exact McNemar test, interval of Bonett and Price. Other measures:
signed ranks, and the mean difference with its bootstrap interval (BCa). Without common seeds:
ranks within cells, shuffled by seed, Newcombe's interval and a normal one. Distance counts
falls; every other measure is taken over runs that stayed up and covered half of the commanded
distance, both of a pair. *Seeds that would tell*: a cell, for 80 % power at the difference seen,
5 % two-sided, that line alone."""


def comparison(results: Results) -> str:
    """How variants differ, as Markdown, and how grounds do if that is what the page is about.

    That is with one variant, or with two grounds, say a team's own beside a shipped one. Empty if
    there is nothing to compare.
    """
    order = in_order(results)
    grounds = list(dict.fromkeys(map(str, results.trials["surface"])))
    parts = [_variants(results, order)] if len(order) > 1 else []
    if len(grounds) > 1 and (len(order) < 2 or len(grounds) == 2):
        parts.append(_grounds(results, grounds))
    return "\n\n".join([*parts, HOW_TO_READ]) if parts else ""


def _variants(results: Results, order: Sequence[Variant]) -> str:
    """Every further variant against the first."""
    first, *others = order
    shown = others[:MOST_VARIANTS]
    rest = len(others) - len(shown)
    more = f"{plural(rest, 'further variant')} left out." if rest else ""
    return section("Comparison", *(_against(results, first, other) for other in shown), more)


def in_order(results: Results) -> list[Variant]:
    """Variants; of several experiments, in the order in which these were asked for."""
    if results.trials["experiment"].nunique() < 2:
        return list(results.variants)
    seen = list(dict.fromkeys(results.trials["variant"]))
    return sorted(results.variants, key=lambda variant: seen.index(variant.label))


def _against(results: Results, first: Variant, second: Variant) -> str:
    """Heading, sentence and tables of one variant against the first."""
    runs = matched(results, first, second)
    title = f"### {escape(second.label)} against {escape(first.label)}"
    if not runs.n:
        return f"{title}\n\nThey share no cell that both have walked: nothing to compare."
    parts = _by_surface(runs)
    metrics = results.metrics or METRICS
    table, *columns = [_contrasts(part, metrics) for part in (runs, *parts.values())]
    said = verdicts([contrast for column in (table, *columns) for contrast in column])
    blocks = [
        title,
        _sentence(runs, table[0], said[0], first, second),
        whole_table((first.label, second.label), table, said[: len(table)]),
        surface_table(list(parts), columns, said[len(table) :]) if parts else "",
        cell_grid(results, runs),
    ]
    return "\n\n".join(block for block in blocks if block)


def _grounds(results: Results, grounds: Sequence[str]) -> str:
    """Every further ground against the first."""
    first, *others = grounds
    blocks = [_ground(results, first, other) for other in others[: MOST_GROUNDS - 1]]
    rest = len(others) - len(blocks)
    more = f"{plural(rest, 'further ground')} left out." if rest else ""
    return section("The grounds compared", *blocks, more)


def _ground(results: Results, first: str, second: str) -> str:
    runs = matched_grounds(results, first, second)
    names = surface_text(first), surface_text(second)
    title = f"### {escape(names[1])} against {escape(names[0])}"
    if not runs.n:
        return f"{title}\n\nThey share no walk that both have carried: nothing to compare."
    table = _contrasts(runs, results.metrics or METRICS)
    said = verdicts(table)
    found = {
        "better": f"The robot stays up more often on {escape(names[1])}",
        "worse": f"The robot stays up less often on {escape(names[1])}",
    }.get(said[0], "The two cannot be told apart in staying up")
    sentence = f"{found}: {difference(table[0])} over {_counted(runs)}.{_unshared(runs)}"
    return "\n\n".join([title, sentence, whole_table(names, table, said)])


def _contrasts(runs: Matched, metrics: Sequence[str]) -> list[Contrast]:
    return [stable_contrast(runs), *(metric_contrast(runs, name) for name in metrics)]


def _by_surface(runs: Matched) -> dict[str, Matched]:
    """The runs of each ground; empty when there is only one."""
    names = list(dict.fromkeys(runs.first["surface"]))
    return {str(name): runs.only("surface", name) for name in names} if len(names) > 1 else {}


def _sentence(
    runs: Matched, stable: Contrast, verdict: Verdict, first: Variant, second: Variant
) -> str:
    here, there = f"*{escape(second.label)}*", f"*{escape(first.label)}*"
    found = {
        "better": f"{here} stays up more often than {there}",
        "worse": f"{here} stays up less often than {there}",
    }.get(verdict, f"{here} and {there} cannot be told apart in staying up")
    return f"{found}: {difference(stable)} over {_counted(runs)}.{_unshared(runs)}"


def _counted(runs: Matched) -> str:
    cells = plural(runs.cells, "cell")
    if not runs.paired:
        return f"{len(runs.second)} and {len(runs.first)} runs in {cells}, without common seeds"
    ending = "" if runs.n == 1 else "s"
    return f"{runs.n} pair{ending} of runs with equal cell and seed in {cells}"


def _unshared(runs: Matched) -> str:
    if not runs.unshared:
        return ""
    verb = "is" if runs.unshared == 1 else "are"
    cells = plural(runs.unshared, "cell")
    return f" {cells} that only one of them has walked {verb} left out."
