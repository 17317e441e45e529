"""Falls in tables: where they went, how they came, and what differs from other walks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from gaitlab.report.before_falls.accounts import gap_text, groups
from gaitlab.report.before_falls.comparing import Contrast
from gaitlab.report.before_falls.measures import MEASURES
from gaitlab.report.before_falls.scene import Contrasts
from gaitlab.report.falls import DIRECTIONS, quartiles
from gaitlab.report.markdown import escape, table
from gaitlab.report.words import NOTHING, plural, surface_text

Part = tuple[str, str, pd.DataFrame]  # ground, variant and the walks there


def contrast_table(grounds: Mapping[str, Contrasts], counted: str) -> str:
    """Differences of every measure, one column a ground; bold where the interval excludes zero."""
    compared = {name: found for name, found in grounds.items() if groups(found)}
    if not compared:
        return ""
    header = [
        "",
        *(f"{surface_text(g)}, {plural(groups(f), counted)}" for g, f in compared.items()),
    ]
    rows = [
        [_title(name), *(_counted(found[name], groups(found)) for found in compared.values())]
        for name in MEASURES
    ]
    return table(header, rows, "l")


def _title(name: str) -> str:
    return f"{MEASURES[name].name} [{MEASURES[name].unit}]"


def _counted(contrast: Contrast, usual: int) -> str:
    """The difference, with its n where a measure is defined less often than others."""
    fewer = contrast.groups and contrast.groups < usual
    return _gap(contrast) + (f", n = {contrast.groups}" if fewer else "")


def _gap(contrast: Contrast) -> str:
    if not contrast.groups or not np.isfinite(contrast.interval.low):
        return NOTHING
    return f"**{gap_text(contrast)}**" if contrast.clear else gap_text(contrast)


def sides_table(found: Contrasts, first: str, second: str) -> str:
    """Median, quartiles and n of both sides, the difference of the means and its interval."""
    rows = [
        [_title(name), _side(name, c.first), _side(name, c.second), _gap(c), _verdict(c)]
        for name, c in found.items()
        if c.groups
    ]
    header = ["", first, second, "difference of means [99 %]", ""]
    return table(header, rows, "l") if rows else ""


def _side(name: str, values: np.ndarray) -> str:
    return quartiles(pd.Series(MEASURES[name].scale * values))


def _verdict(contrast: Contrast) -> str:
    if not contrast.clear:
        return "cannot tell"
    return "higher" if contrast.difference > 0.0 else "lower"


def falls_table(parts: Sequence[Part]) -> str:
    """Where the falls of each ground and variant went and began.

    Args:
        parts: Walks with `fell`, `fall_direction`, and what `stands` and `Read.stories` say.
    """
    header = [*("", "variant", "falls", *DIRECTIONS, "before a full cycle", "on one foot")]
    header += ["first fore-aft", "first sideways"]
    return table(header, [_falls_row(*part) for part in parts], "ll")


def _falls_row(ground: str, variant: str, done: pd.DataFrame) -> list[str]:
    falls = done[done["fell"]]
    single = falls["support"].isin(("left foot", "right foot"))
    counted = [
        *(falls["fall_direction"] == way for way in DIRECTIONS),
        falls["cycles"] < 1.0,
        single,
        *(falls["axis"] == axis for axis in ("fore-aft", "sideways")),
    ]
    head = [escape(surface_text(ground)), escape(variant), f"{len(falls)} of {len(done)}"]
    return [*head, *(str(int(flags.sum())) for flags in counted)]


def courses_table(parts: Sequence[Part]) -> str:
    """How fast the falls of each ground and variant came; those without a fall are left out.

    Args:
        parts: As for `falls_table`.
    """
    header = ["", "variant", "to the fall [s]", "pitch growth [%/cycle]"]
    header += ["roll growth [%/cycle]", "ZMP drift [mm/cycle]"]
    rows = [_course_row(*part) for part in parts if part[2]["fell"].any()]
    return table(header, rows, "ll") if rows else ""


def _course_row(ground: str, variant: str, done: pd.DataFrame) -> list[str]:
    falls = done[done["fell"]]
    growth = [quartiles(100.0 * falls[name]) for name in ("pitch_growth", "roll_growth")]
    drift = quartiles(1000.0 * falls["zmp_drift"])
    return [escape(surface_text(ground)), escape(variant), quartiles(falls["lead"]), *growth, drift]
