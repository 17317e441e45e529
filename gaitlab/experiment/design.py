"""A space-filling sweep: few points that cover a box of parameters evenly.

Where a grid of k parameters needs n^k cells, a Sobol' sequence or a Latin hypercube of some tens
of points varies all of them at once, each over its whole range. A scrambled Sobol' sequence,
[Owen1998], is random like any draw from the box but more even, and its first points are a sweep by
themselves: more points extend a smaller sweep. It is balanced when their number is a power of two.

References:
    McKay1979: McKay, Beckman and Conover, A comparison of three methods for selecting values of
        input variables in the analysis of output from a computer code, Technometrics, 1979.
    Owen1998: Owen, Scrambling Sobol' and Niederreiter-Xing points, J. of Complexity, 1998.
    Sobol1967: Sobol', On the distribution of points in a cube and the approximate evaluation of
        integrals, USSR Computational Mathematics and Mathematical Physics, 1967.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import exp, floor, log
from typing import Literal

import numpy as np

from gaitlab.experiment.axes import Axis
from gaitlab.experiment.parts import Value
from gaitlab.experiment.study import Numbers

DIGITS = 6  # significant ones of a value, so that no library's last bit names a trial
MOST_POINTS = 65_536


@dataclass(frozen=True, kw_only=True)
class Follower:
    """A parameter that moves in a straight line with a swept one.

    Attributes:
        path: Dotted path.
        low: Its value where the swept one is lowest, in its own unit.
        high: Its value where the swept one is highest; may lie below `low`.
        integer: Whether only whole numbers are allowed.
    """

    path: str
    low: float
    high: float
    integer: bool = False


@dataclass(frozen=True, kw_only=True)
class Quantity:
    """One edge of the box.

    Attributes:
        range: The swept parameter and its ends.
        followers: Parameters that move with it.
    """

    range: Numbers
    followers: tuple[Follower, ...] = ()

    @property
    def paths(self) -> tuple[str, ...]:
        """The swept path and those that move with it."""
        return (self.range.path, *(follower.path for follower in self.followers))

    def values(self, place: float) -> tuple[Value, ...]:
        """Values of the paths at a place in [0, 1) along the edge."""
        value = _at(self.range, place)
        share = (value - self.range.low) / (self.range.high - self.range.low)
        others = (_line(follower, share) for follower in self.followers)
        return (value, *others)

    def place(self, value: float) -> float:
        """Place of a value of the swept parameter along the edge, 0 at its low end."""
        ends = np.array([self.range.low, self.range.high, value], dtype=float)
        low, high, at = np.log(ends) if self.range.log else ends
        return float((at - low) / (high - low))


@dataclass(frozen=True, kw_only=True)
class Design:
    """Points spread over a box.

    Attributes:
        type: `sobol`, a scrambled Sobol' sequence [Sobol1967], or `lhs`, a Latin hypercube
            [McKay1979].
        points: How many.
        seed: Of scrambling or drawing.
        box: The swept parameters.
    """

    type: Literal["sobol", "lhs"]
    points: int
    seed: int
    box: tuple[Quantity, ...]

    @property
    def texts(self) -> Mapping[str, str]:
        """How each path is spread, in words, by dotted path: `64 points, 3 to 4`."""
        kind = {"sobol": "Sobol' points", "lhs": "Latin hypercube points"}[self.type]
        ranges = {item.range.path: f"{self.points} {kind}, {item.range.text}" for item in self.box}
        followers = [(item.range.path, other) for item in self.box for other in item.followers]
        lines = {o.path: f"{o.low:g} to {o.high:g} with {path}" for path, o in followers}
        return {path: {**ranges, **lines}[path] for item in self.box for path in item.paths}

    def axis(self) -> Axis:
        """The points as one axis of the experiment, the swept paths before their followers'."""
        paths = tuple(path for quantity in self.box for path in quantity.paths)
        return Axis(paths=paths, rows=tuple(self._rows()))

    def _rows(self) -> Iterator[tuple[Value, ...]]:
        for places in unit_points(self.type, self.points, len(self.box), self.seed).tolist():
            pairs = zip(self.box, places, strict=True)
            yield tuple(value for quantity, place in pairs for value in quantity.values(place))


def unit_points(kind: Literal["sobol", "lhs"], points: int, across: int, seed: int) -> np.ndarray:
    """Points in the unit box. Shape (points, across)."""
    # scipy.stats takes half a second to import, which only a sweep should pay.
    from scipy.stats import qmc

    generator = np.random.default_rng(seed)
    if kind == "lhs":
        return np.asarray(qmc.LatinHypercube(across, rng=generator).random(points))
    sequence = qmc.Sobol(across, scramble=True, rng=generator)
    return np.asarray(sequence.random_base2((points - 1).bit_length())[:points])


def _at(numbers: Numbers, place: float) -> float:
    low, high = numbers.low, numbers.high
    if numbers.integer:  # each whole number, or each ratio, gets an equal share of the edge
        low, high = low - 0.5, high + 0.5
    if numbers.log:
        value = exp(log(low) + place * (log(high) - log(low)))
    else:
        value = low + place * (high - low)
    return _rounded(value, numbers.low, numbers.high, numbers.integer)


def _line(follower: Follower, share: float) -> float:
    value = follower.low + share * (follower.high - follower.low)
    low, high = sorted((follower.low, follower.high))
    return _rounded(value, low, high, follower.integer)


def _rounded(value: float, low: float, high: float, integer: bool) -> float:
    found = floor(value + 0.5) if integer else float(f"{value:.{DIGITS}g}")
    return min(max(found, low), high)
