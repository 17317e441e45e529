"""Falls in words and tables: what the numbers carry, and that nothing more can be told."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from gaitlab.report.before_falls.comparing import Contrast
from gaitlab.report.before_falls.measures import MEASURES
from gaitlab.report.before_falls.scene import Contrasts
from gaitlab.report.falls import DIRECTIONS, quartiles
from gaitlab.report.markdown import escape, table
from gaitlab.report.words import NOTHING, percent, plural, surface_text

MOST_NAMED = 4  # differences in a sentence
APART = ("plough_share", "lift_base", "margin_p5", "toe_first")  # said otherwise or elsewhere
DEPTH = ("sink", "lift", "single", "plough")  # what a pile does to any walk, see `depth`
SMALL = 10.0  # points of a share; toes that catch would land first far more often
STEP = "gait.step_length"


def how_they_fell(done: pd.DataFrame, what: str) -> str:
    """Directions, when, from which feet and how fast, in a few sentences.

    Args:
        done: Walks with `fell`, `fall_direction`, `cycles`, `lead`, `support` and `axis`.
        what: Who walked.
    """
    falls = done[done["fell"]]
    if falls.empty:
        return f"{what} never falls in {plural(len(done), 'walk')}."
    n, ways = len(falls), _ordered(falls["fall_direction"])
    early = int((falls["cycles"] < 1.0).sum())
    feet, count = _ordered(falls["support"])[0]
    counted = {axis: int((falls["axis"] == axis).sum()) for axis in ("fore-aft", "sideways")}
    return (
        f"{what} falls in {n} of {len(done)} walks: {', '.join(f'{k} {way}' for way, k in ways)}"
        f"{_backward_walks(falls, ways[0][0])}. {early} of the {n} begin before a gait cycle at "
        f"full amplitude is done, {count} with load on {feet}; the fall is established "
        f"{_median(falls['lead'])} s later (median). The trunk leaves what it did before first "
        f"fore-aft in {counted['fore-aft']}, sideways in {counted['sideways']}."
    )


def _backward_walks(falls: pd.DataFrame, way: str) -> str:
    """How the commonest fall divides between walks forward and backward."""
    if STEP not in falls.columns:
        return ""
    parts = []
    back = falls[STEP].to_numpy(float) < 0.0
    for name, chosen in (("ahead or in place", falls[~back]), ("backward", falls[back])):
        if len(chosen):
            same = int((chosen["fall_direction"] == way).sum())
            parts.append(f"{same} of {len(chosen)} when walking {name}")
    return f" ({way}: {', '.join(parts)})"


def _ordered(values: pd.Series) -> list[tuple[str, int]]:
    counts = values.value_counts()
    return sorted(((str(k), int(n)) for k, n in counts.items()), key=lambda kn: (-kn[1], kn[0]))


def _median(values: pd.Series) -> str:
    known = values.to_numpy(float)
    known = known[np.isfinite(known)]
    return f"{np.median(known):.2g}" if len(known) else NOTHING


def depth(found: Contrasts, there: str) -> str:
    """What the pile does to any walk, against the reference ground; a sentence."""
    if not found["lift"].groups:
        return ""
    sunk = found["sink"].groups > 0
    single = [100.0 * float(np.mean(s)) for s in (found["single"].first, found["single"].second)]
    sole = f"The only loaded sole stands {_over_tips(-_mean(found['sink']))}; " if sunk else ""
    return (
        f"{sole}{'the' if sole else 'The'} swing foot's lowest corner rises to "
        f"{_over_tips(_mean(found['lift']))}, {_mean(found['lift_base']):.2g} mm over the base; "
        f"the robot is on one foot for {percent(single[0])} of the time, on {there} for "
        f"{percent(single[1])}; the pile holds a foot back by up to "
        f"{_mean(found['plough_share']):.2g} % of the weight."
    )


def _over_tips(height: float) -> str:
    """A height in [mm] over the tips of the pile."""
    return f"{abs(height):.2g} mm {'over' if height >= 0.0 else 'below'} the tips"


def _mean(contrast: Contrast) -> float:
    """Mean of the first side, in the unit of the table."""
    return MEASURES[contrast.measure].scale * float(np.mean(contrast.first))


def what_differs(found: Contrasts, head: str, counted: str, apart: Sequence[str] = APART) -> str:
    """The clearest differences of a comparison in a sentence; empty if there is none to make.

    What is not defined in half of the pairs or cells is left to the table.

    Args:
        found: Contrast by measure.
        head: What is compared with what.
        counted: Noun of what the differences are made from.
        apart: Measures that are not named.
    """
    most = _groups(found)
    asked = [c for name, c in found.items() if 2 * c.groups >= max(most, 1) and name not in apart]
    if not asked:
        return ""
    clear = sorted((c for c in asked if c.clear), key=lambda c: -c.size)
    head = f"{head} ({plural(most, counted)})"
    if not clear:
        return f"{head} nothing differs clearly, so nothing can be told."
    return f"{head}: {'; '.join(_difference(c) for c in clear[:MOST_NAMED])}."


def _difference(contrast: Contrast) -> str:
    measure = MEASURES[contrast.measure]
    first, second = (
        f"{measure.scale * float(np.mean(side)):.3g}" for side in (contrast.first, contrast.second)
    )
    unit = measure.unit if measure.unit == "°" else f" {measure.unit}"
    return f"{measure.name} {first}{unit} and not {second}{unit} ({gap_text(contrast)})"


def toes(found: Contrasts) -> str:
    """Whether walks that fall land on their toes more often than those of their cells that stay up.

    A sentence that claims no more than a difference, and none where there is not one.
    """
    contrast = found["toe_first"]
    if not contrast.groups:
        return "Whether toes catch cannot be told: too few of its cells have falls and none."
    first, second = (percent(100.0 * float(np.mean(s))) for s in (contrast.first, contrast.second))
    shares = f"Toes land first in {first} of landings against {second} ({gap_text(contrast)})"
    if not contrast.clear:
        most = 100.0 * contrast.interval.high
        if most > SMALL:
            return f"{shares}: whether toes catch cannot be told."
        return f"{shares}: at most {most:.0f} points more, so the toe is not what catches."
    if contrast.difference > 0.0:
        return f"{shares}: the toe may have a part in these falls."
    return f"{shares}: the toe is not what catches."


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
        [_title(name), *(_counted(found[name], _groups(found)) for found in compared.values())]
        for name in MEASURES
    ]
    return table(header, rows, "l")


def _groups(found: Contrasts) -> int:
    return max((contrast.groups for contrast in found.values()), default=0)


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
