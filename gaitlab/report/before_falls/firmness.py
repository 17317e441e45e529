"""Whether the ground holds a robot on one foot, by the law of its pile alone."""

from __future__ import annotations

from collections.abc import Mapping
from math import isinf
from typing import NamedTuple

from gaitlab.log import TrialLog
from gaitlab.report.markdown import escape, table
from gaitlab.report.words import surface_text
from gaitlab.surfaces.tipping import SUPPORTS, Settled, Support, settled, tipping_ratio
from gaitlab.trial import Trial

STANDING = 0.5  # s into a trial, at which it still stands
NAMES: dict[Support, str] = {
    "flat": "flat, 4 x 3 points",
    "studs": "four studs",
    "uniform": "even pressure",
}


class Firmness(NamedTuple):
    """What one ground gives a robot that stands on one foot.

    Attributes:
        rest: Sink and stiffness under the weight of the robot.
        pitch: Tipping ratio fore-aft for each kind of support.
        roll: Tipping ratio sideways.
        kind: Kind of the robot's own sole.
    """

    rest: Settled
    pitch: Mapping[Support, float]
    roll: Mapping[Support, float]
    kind: Support


def firmness(trial: Trial, log: TrialLog) -> Firmness:
    """What a trial's ground gives its robot; the log says how high its CoM stands."""
    row = round(STANDING / log.header.dt)
    height = float(log["com_z"][row] - log.per_foot("z")[row].mean())
    sole, weight = trial.robot.sole, log.header.weight
    pitch, roll = (
        {
            support: tipping_ratio(
                trial.surface, sole, weight=weight, com_height=height, support=support, axis=axis
            )
            for support in SUPPORTS
        }
        for axis in ("x", "y")
    )
    rest = settled(trial.surface, sole, weight)
    return Firmness(rest=rest, pitch=pitch, roll=roll, kind=sole.kind)


def firmness_table(grounds: Mapping[str, Firmness], outcome: Mapping[str, str], what: str) -> str:
    """One row a ground, its own kind of sole first.

    Args:
        grounds: By the name of the ground.
        outcome: How many walks fell there, by the name of the ground.
        what: Whose walks.
    """
    if not grounds:
        return ""
    own = next(iter(grounds.values())).kind
    kinds = [own, *(kind for kind in SUPPORTS if kind != own)]
    header = ["", "sink on one foot [mm]", "stiffness [kN/m]"]
    header += [f"{way}, {NAMES[kind]}" for kind in kinds for way in ("fore-aft", "sideways")]
    rows = [
        [
            escape(surface_text(name)),
            f"{1000.0 * ground.rest.sink:.1f}",
            _number(ground.rest.stiffness / 1000.0),
            *(_number(way[kind]) for kind in kinds for way in (ground.pitch, ground.roll)),
            outcome.get(name, ""),
        ]
        for name, ground in grounds.items()
    ]
    return table([*header, f"falls of {what}"], rows, "lr")


def _number(value: float) -> str:
    return "∞" if isinf(value) else f"{value:.3g}"


def firmness_order(grounds: Mapping[str, Firmness], fell: Mapping[str, float]) -> str:
    """Whether the grounds come in one order by firmness and by falls, in a sentence.

    Args:
        grounds: By the name of the ground.
        fell: Share of walks that fell, by the name of the ground.
    """
    firm = sorted(grounds, key=lambda name: grounds[name].rest.stiffness)
    falls = sorted(grounds, key=lambda name: -fell[name])
    pairs = [(a, b) for i, a in enumerate(firm) for b in firm[i + 1 :] if _apart(grounds, a, b)]
    wrong = sum(fell[a] < fell[b] for a, b in pairs)
    right = sum(fell[a] > fell[b] for a, b in pairs)
    orders = " < ".join(surface_text(name) for name in firm)
    seen = " > ".join(surface_text(name) for name in falls)
    return (
        f"By firmness: {escape(orders)}; by walks that fell: {escape(seen)}. Of the {len(pairs)} "
        f"pairs of grounds whose firmness differs by over 5 %, {right} have more falls on the "
        f"softer, {wrong} on the firmer: {_order_told(right, wrong, len(pairs))}."
    )


def _order_told(right: int, wrong: int, pairs: int) -> str:
    if wrong:
        return "the orders differ"
    if right == pairs > 0:
        return "the falls come in the order of firmness, which does not make it their reason"
    return "nothing contradicts the order of firmness, and not all of it is seen"


def _apart(grounds: Mapping[str, Firmness], soft: str, firm: str) -> bool:
    return grounds[firm].rest.stiffness > 1.05 * grounds[soft].rest.stiffness


def firmness_words(ground: Firmness) -> str:
    """The ratios of the robot's own sole in a sentence."""
    if isinf(ground.rest.stiffness):
        return "The floor does not yield."
    pitch, roll = ground.pitch[ground.kind], ground.roll[ground.kind]
    return (
        f"By the law of the pile its sole holds {pitch:.2g} times what one foot needs fore-aft and "
        f"{roll:.2g} times sideways."
    )
