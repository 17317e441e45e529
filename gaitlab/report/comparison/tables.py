"""Contrasts as tables: every number with its interval, its n and what would tell."""

from __future__ import annotations

from collections.abc import Sequence
from math import degrees, inf

from gaitlab.metrics import better, unit_of
from gaitlab.report.comparison.contrast import Contrast, Verdict
from gaitlab.report.markdown import escape, table
from gaitlab.report.words import NOTHING, path_text, surface_text
from gaitlab.statistics import Interval

MOST_SEEDS = 1000  # a cell; beyond it nobody waits
AIMS = {"higher": ", more is better", "lower": ", less is better", "neither": ""}


def whole_table(
    labels: tuple[str, str], contrasts: Sequence[Contrast], said: Sequence[Verdict]
) -> str:
    """One row a quantity, over all cells."""
    told = ("difference [95 %]", "n", "verdict", "seeds that would tell")
    rows = [_row(contrast, verdict) for contrast, verdict in zip(contrasts, said, strict=True)]
    return table(["", *map(escape, labels), *told], rows, "lrrrrlr")


def surface_table(
    names: Sequence[str], columns: Sequence[Sequence[Contrast]], said: Sequence[Verdict]
) -> str:
    """Differences on each ground, one row a quantity.

    Args:
        names: Grounds.
        columns: Contrasts of each ground, in the same order of quantities.
        said: Verdict of each contrast, ground by ground.
    """
    count = len(columns[0])
    rows = [
        [
            _name(columns[0][i].quantity),
            *(_short(column[i], said[k * count + i]) for k, column in enumerate(columns)),
        ]
        for i in range(count)
    ]
    return table(["difference on", *(escape(surface_text(name)) for name in names)], rows, "l")


def difference(contrast: Contrast) -> str:
    """The difference with its interval, in points for a share, in degrees for an angle."""
    low, high = contrast.interval
    if contrast.quantity == "stable":
        middle, low, high = (100.0 * value for value in (contrast.difference, low, high))
        return f"{_signed(middle, 0)} points [{_signed(low, 0)}, {_signed(high, 0)}]"
    digits = _digits(contrast)
    middle = _scaled(contrast.quantity, contrast.difference)
    return f"{_signed(middle, digits)} {_interval(contrast.quantity, contrast.interval, digits)}"


def _row(contrast: Contrast, verdict: Verdict) -> list[str]:
    if not contrast.n:
        return [_name(contrast.quantity), *[NOTHING] * 4, verdict, NOTHING]
    return [
        _name(contrast.quantity),
        _value(contrast.quantity, contrast.first),
        _value(contrast.quantity, contrast.second),
        difference(contrast),
        str(contrast.n),
        _loud(verdict),
        _seeds(contrast, verdict),
    ]


def _short(contrast: Contrast, verdict: Verdict) -> str:
    if not contrast.n:
        return NOTHING
    return difference(contrast) + ("" if verdict == "cannot tell" else f" {_loud(verdict)}")


def _seeds(contrast: Contrast, verdict: Verdict) -> str:
    if verdict != "cannot tell":
        return NOTHING
    return f"more than {MOST_SEEDS}" if contrast.seeds > MOST_SEEDS else f"{contrast.seeds:.0f}"


def _loud(verdict: Verdict) -> str:
    return verdict if verdict in ("cannot tell", "no data") else f"**{verdict}**"


def _name(quantity: str) -> str:
    if quantity == "stable":
        return "stable runs"
    unit = {"rad": "°", "-": ""}.get(unit_of(quantity), unit_of(quantity))
    shown = f" \\[{escape(unit)}\\]" if unit else ""
    return f"{escape(path_text(quantity))}{shown}{AIMS[better(quantity)]}"


def _scaled(quantity: str, value: float) -> float:
    return degrees(value) if unit_of(quantity) == "rad" else value


def _value(quantity: str, value: float) -> str:
    if quantity == "stable":
        return f"{100.0 * value:.0f} %"
    return f"{_scaled(quantity, value):.3g}"


def _interval(quantity: str, bounds: Interval, digits: int) -> str:
    if bounds.high - bounds.low == inf:
        return "[too few]"
    return f"[{', '.join(_signed(_scaled(quantity, end), digits) for end in bounds)}]"


def _digits(contrast: Contrast) -> int:
    """Decimals that leave two digits of the interval's width."""
    width = _scaled(contrast.quantity, contrast.interval.high - contrast.interval.low)
    if not 0.0 < width < inf:
        width = abs(_scaled(contrast.quantity, contrast.difference)) or 1.0
    return max(0, min(9, 1 - int(f"{width:e}".rpartition("e")[2])))


def _signed(value: float, digits: int) -> str:
    text = f"{value:+.{digits}f}"
    return text if float(text) else text.lstrip("+-")
