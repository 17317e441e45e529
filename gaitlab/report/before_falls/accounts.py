"""Falls in words: what the numbers carry, and that nothing more can be told."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from gaitlab.report.before_falls.comparing import Contrast
from gaitlab.report.before_falls.measures import MEASURES
from gaitlab.report.before_falls.scene import Contrasts
from gaitlab.report.falls import numbers
from gaitlab.report.markdown import escape
from gaitlab.report.words import NOTHING, percent, plural, surface_text

MOST_NAMED = 4  # differences in a sentence
TWICE = ("plough_share", "lift_base")  # another measure less or over a constant
APART = (*TWICE, "margin_p5", "toe_first")  # said otherwise or elsewhere
DEPTH = ("sink", "lift", "single", "plough")  # what a pile does to any walk, see `depth`
FEWEST_GROUNDS = 2  # that have something in common
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
    ahead, aside = (int((falls["axis"] == axis).sum()) for axis in ("fore-aft", "sideways"))
    untold = f", in {n - ahead - aside} neither" if ahead + aside < n else ""
    return (
        f"{what} falls in {n} of {len(done)} walks: {', '.join(f'{k} {way}' for way, k in ways)}"
        f"{_backward_walks(falls, ways[0][0])}. {early} of the {n} begin before a gait cycle at "
        f"full amplitude is done, {count} with load on {feet}; the fall is established "
        f"{_median(falls['lead'])} s later (median). The trunk leaves what it did before first "
        f"fore-aft in {ahead}, sideways in {aside}{untold}."
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
    known = numbers(values)
    return f"{np.median(known):.2g}" if len(known) else NOTHING


def depth(found: Contrasts, there: str) -> str:
    """What the pile does to any walk, against the reference ground; a sentence."""
    if not found["lift"].groups:
        return ""
    sunk = found["sink"].groups > 0
    single = [100.0 * mean for mean in found["single"].means]
    sole = f"The only loaded sole stands {_over_tips(-_mean(found['sink']))}; " if sunk else ""
    return (
        f"{sole}{'the' if sole else 'The'} swing foot's lowest corner rises to "
        f"{_over_tips(_mean(found['lift']))}, {_mean(found['lift_base']):.2g} mm over the base; "
        f"the robot is on one foot for {percent(single[0])} of the time, on {there} for "
        f"{percent(single[1])}; the pile holds a foot back by "
        f"{_mean(found['plough_share']):.2g} % of the weight at its peak."
    )


def _over_tips(height: float) -> str:
    """A height in [mm] over the tips of the pile."""
    return f"{abs(height):.2g} mm {'over' if height >= 0.0 else 'below'} the tips"


def _mean(contrast: Contrast) -> float:
    """Mean of the first side, in the unit of the table."""
    return MEASURES[contrast.measure].scale * contrast.means[0]


def what_differs(found: Contrasts, head: str, counted: str, apart: Sequence[str] = APART) -> str:
    """The clearest differences of a comparison in a sentence; empty if there is none to make.

    What is not defined in half of the pairs or cells is left to the table.

    Args:
        found: Contrast by measure.
        head: What is compared with what.
        counted: Noun of what the differences are made from.
        apart: Measures that are not named.
    """
    most = groups(found)
    asked = [c for name, c in found.items() if 2 * c.groups >= max(most, 1) and name not in apart]
    if not asked:
        return ""
    clear = sorted((c for c in asked if c.clear), key=lambda c: -c.size)
    head = f"{head} ({plural(most, counted)})"
    if not clear:
        return f"{head} nothing differs clearly, so nothing can be told."
    return f"{head}: {'; '.join(_difference(c, most) for c in clear[:MOST_NAMED])}."


def common(grounds: Mapping[str, Contrasts], head: str) -> str:
    """What differs clearly and the same way on every ground that can be compared; a sentence.

    Args:
        grounds: Contrasts by ground.
        head: What is compared with what.
    """
    compared = {name: found for name, found in grounds.items() if groups(found)}
    if len(compared) < FEWEST_GROUNDS:
        return ""
    where = ", ".join(escape(surface_text(name)) for name in compared)
    sets = {name: [found[name] for found in compared.values()] for name in MEASURES}
    shared = {name: found for name, found in sets.items() if name not in APART and _alike(found)}
    ordered = sorted(shared, key=lambda name: -min(c.size for c in shared[name]))
    named = "; ".join(_spread(name, shared[name]) for name in ordered[:MOST_NAMED])
    return f"{head} on each of {where}: {named or 'no measure differs clearly on all of them'}."


def _alike(found: Sequence[Contrast]) -> bool:
    return all(c.clear for c in found) and len({c.difference > 0.0 for c in found}) == 1


def _spread(name: str, found: Sequence[Contrast]) -> str:
    gaps = sorted((MEASURES[name].scale * c.difference for c in found), key=abs)
    word = "higher" if gaps[0] > 0.0 else "lower"
    unit = {"°": "°", "%": " points"}.get(MEASURES[name].unit, f" {MEASURES[name].unit}")
    return f"{MEASURES[name].name} {word} by {abs(gaps[0]):.3g} to {abs(gaps[-1]):.3g}{unit}"


def _difference(contrast: Contrast, most: int) -> str:
    """Both means and their difference, with its n where it is made from fewer than the others."""
    measure = MEASURES[contrast.measure]
    first, second = (f"{measure.scale * mean:.3g}" for mean in contrast.means)
    unit = measure.unit if measure.unit == "°" else f" {measure.unit}"
    fewer = f", n = {contrast.groups}" if contrast.groups < most else ""
    return f"{measure.name} {first}{unit} and not {second}{unit} ({gap_text(contrast)}{fewer})"


def toes(found: Contrasts) -> str:
    """Whether walks that fall land on their toes more often than those of their cells that stay up.

    A sentence that claims no more than a difference, and none where there is not one: how a foot
    lands says nothing of a toe that catches on its way.
    """
    contrast = found["toe_first"]
    if not contrast.groups:
        return "Whether toes catch cannot be told: too few walks fall beside others that stay up."
    first, second = (percent(100.0 * mean) for mean in contrast.means)
    shares = f"Toes land first in {first} of landings against {second} ({gap_text(contrast)})"
    most = 100.0 * contrast.interval.high
    if contrast.clear and contrast.difference > 0.0:
        return f"{shares}: the toe may have a part in these falls."
    if contrast.clear:
        return f"{shares}: no sign of toes that catch in landing."
    if most > SMALL or not contrast.scatters:
        return f"{shares}: whether toes catch cannot be told."
    return f"{shares}, at most {most:.0f} points more: no sign of toes that catch in landing."


def gap_text(contrast: Contrast) -> str:
    """Difference and interval in the unit of the table."""
    scale = MEASURES[contrast.measure].scale
    values = (contrast.difference, *contrast.interval)
    gap, low, high = (f"{scale * value:.1f}" for value in values)
    return f"{gap} [{low}, {high}]"


def groups(found: Contrasts) -> int:
    """Pairs or cells that the differences are made from, at most."""
    return max((contrast.groups for contrast in found.values()), default=0)
