"""Which of the variants of a page walks better, in what, by how much, and how many seeds tell."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import degrees, inf

from gaitlab.metrics import lookup
from gaitlab.report.markdown import escape, table
from gaitlab.report.matching import Matched, matched, matched_grounds
from gaitlab.report.results import Results
from gaitlab.report.variants import Value
from gaitlab.report.words import NOTHING, path_text, plural, surface_text
from gaitlab.statistics import MOST_SEEDS, Contrast, Interval, judged

METRICS = ("distance", "walking_speed", "pitch_amplitude", "cost_of_transport")
MOST_VARIANTS = 12  # that are set against the first one; more make no page
MOST_GROUNDS = 6  # of one gait, likewise
AIMS = {"higher": ", more is better", "lower": ", less is better", "neither": ""}
HOW_TO_READ = """\
Runs are compared in pairs of equal cell and seed, by random signs of each seed's sum over its
cells, since a seed draws the same servos and ground in all of them (in one cell that is the exact
McNemar test); without common seeds by ranks within cells, whole seeds shuffled. *better* and
*worse* hold for the differences in *stable runs, all* of a page together, and apart from them for
the other differences of two variants together: of twenty pages without any difference at most one
names one (Holm). Where nothing is said, the runs cannot tell. Distance counts falls; the other
measures are of runs that stayed up and covered half of the commanded distance, both of a pair."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Comparison:
    """Two variants, or two grounds, run by run.

    Attributes:
        first: What the other is set against, as a reader calls it.
        second: The other.
        runs: Their runs in the cells that both have.
        stable: Staying up over all of them, judged with the other comparisons of the page.
        columns: Staying up in each column of the tables; empty with a single one.
        metrics: The other quantities, judged with `columns`.
    """

    first: str
    second: str
    runs: Matched
    stable: Contrast
    columns: Mapping[Value, Contrast]
    metrics: tuple[Contrast, ...]

    @property
    def counted(self) -> str:
        """What the difference rests on, in words."""
        cells = plural(self.runs.cells, "cell")
        if not self.runs.paired:
            sizes = f"{len(self.runs.second)} and {len(self.runs.first)} runs"
            return f"{sizes} in {cells}, without common seeds"
        return f"{plural(self.runs.n, 'pair')} of equal cell and seed in {cells}"

    @property
    def unshared(self) -> str:
        """How many cells were left out; empty if none."""
        lost = self.runs.unshared
        if not lost:
            return ""
        verb = "is" if lost == 1 else "are"
        return f"{plural(lost, 'cell')} that only one of them has walked {verb} left out."


def compared_variants(results: Results) -> list[Comparison]:
    """Every further variant against the first; of several experiments in the order asked for."""
    if results.trials["experiment"].nunique() > 1:
        seen = list(dict.fromkeys(results.trials["variant"]))
        ordered = sorted(results.variants, key=lambda variant: seen.index(variant.label))
    else:
        ordered = list(results.variants)
    pairs = [(ordered[0].label, other.label, matched(results, ordered[0], other))
             for other in ordered[1 : MOST_VARIANTS + 1]]  # fmt: skip
    return _compared(results, pairs, results.columns)


def compared_grounds(results: Results) -> list[Comparison]:
    """Every further ground against the first, if that is what the page is about.

    That is with one variant, or with two grounds, say a team's own beside a shipped one.
    """
    grounds = list(dict.fromkeys(map(str, results.trials["surface"])))
    if len(grounds) < 2 or (len(results.variants) > 1 and len(grounds) > 2):
        return []
    first, *others = grounds[:MOST_GROUNDS]
    pairs = [
        (surface_text(first), surface_text(other), matched_grounds(results, first, other))
        for other in others
    ]
    return _compared(results, pairs, "")


def _compared(
    results: Results, pairs: Sequence[tuple[str, str, Matched]], columns: str
) -> list[Comparison]:
    whole = judged([runs.contrast("stable") for _, _, runs in pairs])
    found = []
    for (first, second, runs), stable in zip(pairs, whole, strict=True):
        values = list(dict.fromkeys(runs.first[columns])) if columns else []
        parts = [runs.only(columns, value).contrast("stable") for value in values]
        parts = parts if len(parts) > 1 else []
        metrics = [runs.contrast(name) for name in results.metrics or METRICS]
        told = judged([*parts, *metrics])
        found.append(
            Comparison(
                first=first,
                second=second,
                runs=runs,
                stable=stable,
                columns=dict(zip(values, told, strict=False)) if parts else {},
                metrics=tuple(told[len(parts) :]),
            )
        )
    return found


def _left_out(results: Results) -> str:
    """How many variants and grounds were not compared; empty if none."""
    grounds = results.trials["surface"].nunique()
    rest = len(results.variants) - 1 - MOST_VARIANTS
    more = grounds - MOST_GROUNDS if len(results.variants) < 2 else 0
    counts = ((rest, "further variant"), (more, "further ground"))
    return "".join(f"{plural(n, noun)} not compared." for n, noun in counts if n > 0)


def comparison_blocks(
    results: Results, variants: Sequence[Comparison], grounds: Sequence[Comparison]
) -> list[str]:
    """Every comparison of a page with its table; empty if there is none."""
    blocks = [block for item in (*variants, *grounds) for block in _blocks(item)]
    return [*blocks, _left_out(results), HOW_TO_READ] if blocks else []


def _blocks(item: Comparison) -> list[str]:
    title = f"### {escape(item.second)} against {escape(item.first)}"
    if not item.runs.n:
        return [title, "They share no cell that both have walked: nothing to compare."]
    said = f"Over {item.counted}. {item.unshared}".rstrip()
    return [title, said, contrast_table((item.first, item.second), [item.stable, *item.metrics])]


def contrast_table(labels: tuple[str, str], contrasts: Sequence[Contrast]) -> str:
    """One row a quantity: both sides, the difference with its interval, n, and what is told."""
    head = ["", *map(escape, labels), "difference [95 %]", "n", "verdict", "seeds that would tell"]
    return table(head, [_row(item) for item in contrasts], "lrrrrlr")


def _row(item: Contrast) -> list[str]:
    if not item.n:
        return [_name(item.quantity), *[NOTHING] * 4, item.verdict, NOTHING]
    return [
        _name(item.quantity),
        _value(item.quantity, item.first),
        _value(item.quantity, item.second),
        difference(item),
        str(item.n),
        loud(item),
        _seeds(item),
    ]


def loud(item: Contrast) -> str:
    """The verdict, bold where one is told."""
    return item.verdict if item.verdict in ("cannot tell", "no data") else f"**{item.verdict}**"


def _seeds(item: Contrast) -> str:
    if not item.advice:
        return NOTHING
    return f"more than {MOST_SEEDS}" if item.needed > MOST_SEEDS else f"{item.needed:.0f}"


def difference(item: Contrast) -> str:
    """The difference with its interval, in points for a share, in degrees for an angle."""
    low, high = item.interval
    if item.quantity == "stable":
        middle, low, high = (100.0 * value for value in (item.difference, low, high))
        return f"{_signed(middle, 0)} points [{_signed(low, 0)}, {_signed(high, 0)}]"
    # Decimals that leave two digits of the interval's width.
    width = _scaled(item.quantity, item.interval.high - item.interval.low)
    if not 0.0 < width < inf:
        width = abs(_scaled(item.quantity, item.difference)) or 1.0
    digits = max(0, min(9, 1 - int(f"{width:e}".rpartition("e")[2])))
    middle = _scaled(item.quantity, item.difference)
    return f"{_signed(middle, digits)} {_interval(item.quantity, item.interval, digits)}"


def _name(quantity: str) -> str:
    if quantity == "stable":
        return "stable runs, all"
    unit = {"rad": "°", "-": ""}.get(lookup(quantity).unit, lookup(quantity).unit)
    shown = f" \\[{escape(unit)}\\]" if unit else ""
    return f"{escape(path_text(quantity))}{shown}{AIMS[lookup(quantity).better]}"


def _scaled(quantity: str, value: float) -> float:
    return degrees(value) if lookup(quantity).unit == "rad" else value


def _value(quantity: str, value: float) -> str:
    if quantity == "stable":
        return f"{100.0 * value:.0f} %"
    return f"{_scaled(quantity, value):.3g}"


def _interval(quantity: str, bounds: Interval, digits: int) -> str:
    if bounds.high - bounds.low == inf:
        return "[too few]"
    return f"[{', '.join(_signed(_scaled(quantity, end), digits) for end in bounds)}]"


def _signed(value: float, digits: int) -> str:
    text = f"{value:+.{digits}f}"
    return text if float(text) else text.lstrip("+-")
