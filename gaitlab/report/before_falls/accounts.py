"""Falls in words and tables: what the numbers carry, and that nothing more can be told."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from gaitlab.report.before_falls.comparing import Contrast
from gaitlab.report.before_falls.measures import MEASURES
from gaitlab.report.falls import DIRECTIONS, quartiles
from gaitlab.report.markdown import escape, table
from gaitlab.report.words import NOTHING, percent, plural, surface_text

MOST_NAMED = 4  # differences in a sentence
REPEATED = ("plough_share", "lift_base", "margin_p5", "toe_first")  # said otherwise or elsewhere
Contrasts = Mapping[str, Contrast]


def how_they_fell(done: pd.DataFrame, what: str) -> str:
    """Directions, when, from which feet and how fast, in a sentence.

    Args:
        done: Walks with `fell`, `fall_direction`, `cycles`, `lead` and `support`.
        what: Who walked.
    """
    falls = done[done["fell"]]
    if falls.empty:
        return f"{what} never falls in {plural(len(done), 'walk')}."
    ways = ", ".join(f"{n} {way}" for way, n in _ordered(falls["fall_direction"]))
    early = int((falls["cycles"] < 1.0).sum())
    feet, count = _ordered(falls["support"])[0]
    return (
        f"{what} falls in {len(falls)} of {len(done)} walks: {ways}. {early} of these falls begin "
        f"before a gait cycle at full amplitude is done; {count} begin with load on {feet}, and "
        f"the fall is established {_median(falls['lead'])} s later (median)."
    )


def _ordered(values: pd.Series) -> list[tuple[str, int]]:
    counts = values.value_counts()
    return sorted(((str(k), int(n)) for k, n in counts.items()), key=lambda kn: (-kn[1], kn[0]))


def _median(values: pd.Series) -> str:
    known = values.to_numpy(float)
    known = known[np.isfinite(known)]
    return f"{np.median(known):.2g}" if len(known) else NOTHING


def what_differs(found: Contrasts, against: str, counted: str) -> str:
    """The clearest differences of a comparison in a sentence; empty if there is none to make.

    Args:
        found: Contrast by measure.
        against: What the falls are compared with.
        counted: Noun of what the differences are made from.
    """
    asked = [c for name, c in found.items() if c.groups and name not in REPEATED]
    if not asked:
        return ""
    clear = sorted((c for c in asked if c.clear), key=lambda c: -c.size)
    n = max(c.groups for c in asked)
    head = f"In the last gait cycle that it stood well, against {against} ({plural(n, counted)})"
    if not clear:
        return f"{head}, nothing differs clearly: why these fell cannot be told."
    named = "; ".join(_difference(c) for c in clear[:MOST_NAMED])
    return f"{head}: {named}."


def _difference(contrast: Contrast) -> str:
    measure = MEASURES[contrast.measure]
    first, second = (
        f"{measure.scale * float(np.mean(side)):.3g}" for side in (contrast.first, contrast.second)
    )
    space = "" if measure.unit == "°" else " "
    unit = f"{space}{measure.unit}"
    return f"{measure.name} {first}{unit} and not {second}{unit} ({gap_text(contrast)})"


def toes(found: Contrasts) -> str:
    """Whether toes that land first have a part in the falls; a sentence."""
    contrast = found["toe_first"]
    if not contrast.groups:
        return "Too few of these walks landed a foot to say whether toes do it."
    first, second = (percent(100.0 * float(np.mean(s))) for s in (contrast.first, contrast.second))
    shares = f"Toes land first in {first} of landings against {second} ({gap_text(contrast)})"
    if not contrast.clear:
        return f"{shares}: whether the toe catches cannot be told from them."
    if contrast.difference > 0.0:
        return f"{shares}: the toe has a part in it."
    return f"{shares}: it is not the toe that catches."


def gap_text(contrast: Contrast) -> str:
    """Difference and interval in the unit of the table."""
    scale = MEASURES[contrast.measure].scale
    values = (contrast.difference, *contrast.interval)
    gap, low, high = (f"{scale * value:.1f}" for value in values)
    return f"{gap} [{low}, {high}]"


def contrast_table(grounds: Mapping[str, Contrasts], counted: str) -> str:
    """Differences of every measure, one column a ground; bold where the interval excludes zero."""
    compared = {name: found for name, found in grounds.items() if _groups(found)}
    if not compared:
        return ""
    header = [
        "",
        *(f"{surface_text(g)}, {plural(_groups(f), counted)}" for g, f in compared.items()),
    ]
    rows = [
        [_title(name), *(_gap(found[name]) for found in compared.values())] for name in MEASURES
    ]
    return table(header, rows, "l")


def _groups(found: Contrasts) -> int:
    return max((contrast.groups for contrast in found.values()), default=0)


def _title(name: str) -> str:
    return f"{MEASURES[name].name} [{MEASURES[name].unit}]"


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


def falls_table(parts: Sequence[tuple[str, str, pd.DataFrame]]) -> str:
    """How the falls of each ground and variant went.

    Args:
        parts: Ground, variant and the walks there, with `fell`, `fall_direction`, and what
            `stands` and `stories` say of them.
    """
    header = [
        *("", "variant", "falls", *DIRECTIONS, "before a full cycle", "on one foot"),
        *("to the fall [s]", "first fore-aft", "first sideways"),
        *("pitch growth [%/cycle]", "roll growth [%/cycle]", "ZMP drift [mm/cycle]"),
    ]
    return table(header, [_falls_row(*part) for part in parts], "ll")


def _falls_row(ground: str, variant: str, done: pd.DataFrame) -> list[str]:
    falls = done[done["fell"]]
    count = [str(int((falls["fall_direction"] == way).sum())) for way in DIRECTIONS]
    single = int(falls["support"].isin(("left foot", "right foot")).sum())
    axes = [str(int((falls["axis"] == axis).sum())) for axis in ("fore-aft", "sideways")]
    growth = [quartiles(100.0 * falls[name]) for name in ("pitch_growth", "roll_growth")]
    head = [escape(surface_text(ground)), escape(variant), f"{len(falls)} of {len(done)}", *count]
    when = [str(int((falls["cycles"] < 1.0).sum())), str(single), quartiles(falls["lead"])]
    return [*head, *when, *axes, *growth, quartiles(1000.0 * falls["zmp_drift"])]
