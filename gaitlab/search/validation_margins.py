"""How far one parameter may move from a gait before the robot falls: which step to walk next.

Outwards from the gait in growing steps until one is too far, then halving the last gap. The search
is a pure function of what was walked so far, so a killed run finds its place again in the store.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Literal

from gaitlab.experiment.study import Numbers
from gaitlab.search.results import Ending, Reach

Verdict = Literal["holds", "fell", "out of reach", "failed"]
RUNGS = (0.05, 0.15, 0.45)  # of the searched range, from the winner
HALVINGS = 2  # of the gap between the last step that holds and the first that does not
MOST_STEPS = len(RUNGS) + HALVINGS  # of one parameter one way


def ladder(
    item: Numbers, value: float, sign: Literal[-1, 1], low: float | None, high: float | None
) -> tuple[float, ...]:
    """Values to try, outwards from the winner's, in the parameter's unit.

    They may leave the searched range, not what the parameter itself allows.

    Args:
        item: The searched parameter.
        value: The winner's value.
        sign: Which way.
        low: Smallest value the parameter allows; None for no bound.
        high: Largest value the parameter allows; None for no bound.
    """
    steps = (on_grid(item, value, _moved(item, value, sign * share)) for share in RUNGS)
    clipped = (min(max(step, _or(low, -math.inf)), _or(high, math.inf)) for step in steps)
    return tuple(dict.fromkeys(step for step in clipped if (step - value) * sign > 0))


def _or(bound: float | None, otherwise: float) -> float:
    return otherwise if bound is None else bound


def _moved(item: Numbers, value: float, share: float) -> float:
    """A value moved by a share of the range, of its ratios if the search is by ratio."""
    if item.log:
        return float(value * (item.high / item.low) ** share)
    return value + share * (item.high - item.low)


def on_grid(item: Numbers, value: float, other: float) -> float:
    """The allowed value nearest to another one, at least one step from the winner's."""
    step = item.step or (1.0 if item.integer else 0.0)
    if not step:
        return float(f"{other:.6g}")  # digits beyond are nobody's to set
    count = round((other - value) / step) or math.copysign(1.0, other - value)
    return value + count * step


def halfway(item: Numbers, holds: float, fails: float) -> float | None:
    """Value between two; None if the grid has none."""
    middle = math.sqrt(holds * fails) if item.log else (holds + fails) / 2.0
    middle = on_grid(item, holds, middle)
    between = min(holds, fails) < middle < max(holds, fails)
    return middle if between else None


def next_step(
    item: Numbers, value: float, rungs: Sequence[float], walked: Mapping[float, Verdict]
) -> float | None:
    """Value to walk next; None when the limit is known as finely as asked."""
    holds, fails = _outwards(value, rungs, walked)
    waiting = next((rung for rung in rungs if rung not in walked), None)
    if fails is None:
        return waiting
    for _ in range(HALVINGS):
        middle = halfway(item, holds, fails)
        if middle is None or middle not in walked:
            return middle
        holds, fails = (middle, fails) if walked[middle] == "holds" else (holds, middle)
    return None


def _outwards(
    value: float, rungs: Sequence[float], walked: Mapping[float, Verdict]
) -> tuple[float, float | None]:
    """Last rung that holds before the first that does not, and that one."""
    holds = value
    for rung in rungs:
        verdict = walked.get(rung)
        if verdict is None:
            return holds, None
        if verdict != "holds":
            return holds, rung
        holds = rung
    return holds, None


def reach(
    item: Numbers, value: float, rungs: Sequence[float], walked: Mapping[float, Verdict]
) -> Reach:
    """How far the parameter moves, by what was walked."""
    holds, fails = _outwards(value, rungs, walked)
    if fails is None:
        return Reach(holds=holds, fails=None, ending=_unbroken(rungs, holds))
    for _ in range(HALVINGS):
        middle = halfway(item, holds, fails)
        if middle is None or middle not in walked:
            break
        holds, fails = (middle, fails) if walked[middle] == "holds" else (holds, middle)
    verdict = walked[fails]
    ending: Ending = verdict if verdict == "fell" or verdict == "out of reach" else "a walk failed"
    return Reach(holds=holds, fails=fails, ending=ending)


def _unbroken(rungs: Sequence[float], holds: float) -> Ending:
    if not rungs:
        return "limit of the parameter"
    return "no fall found" if holds == rungs[-1] else "not walked yet"
