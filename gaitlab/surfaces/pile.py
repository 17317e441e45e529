"""Quasi-static law of a pile that is pressed flat: folded blades, then a packed mat.

Derived here from two conservative terms, see `PileLaw`. h is the gap between sole and base,
H the height of the free pile, x = H/h.

References:
    Toll1998: Toll, Packing mechanics of fiber reinforcements, Polymer Engineering & Science, 1998.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

SMALLEST_GAP = 2e-4  # m, keeps x finite when a pile has no solid height


@dataclass(frozen=True, kw_only=True)
class PileLaw:
    """p(h) = p1 (x^2 - 1) + p2 (x^n - 1) for h < H, else 0.

    The first term is the bending energy of blades folded into the gap, the second the packing of
    the laid-over mat, [Toll1998].

    Attributes:
        height: Free pile height H, in [m].
        exponent: n of the packing term.
        p1: Folding pressure, in [Pa].
        p2: Packing pressure, in [Pa].
        solid_height: Gap h_s at which the mat is solid, in [m].
    """

    height: float
    exponent: float
    p1: float
    p2: float
    solid_height: float

    def _ratio(self, gap: np.ndarray) -> np.ndarray:
        lowest = max(self.solid_height, SMALLEST_GAP)
        return self.height / np.clip(gap, lowest, self.height)

    def pressure(self, gap: np.ndarray) -> np.ndarray:
        """Pressure on a flat sole, in [Pa], at a gap in [m]. Same shape."""
        x = self._ratio(np.asarray(gap, dtype=float))
        return self.p1 * (x**2 - 1.0) + self.p2 * (x**self.exponent - 1.0)

    def energy(self, gap: np.ndarray) -> np.ndarray:
        """Work stored per area, the integral of p from h to H, in [J/m^2]. Same shape."""
        x = self._ratio(np.asarray(gap, dtype=float))
        n, height = self.exponent, self.height
        travel = height * (1.0 - 1.0 / x)
        folding = height * (x - 1.0) - travel
        packing = height / (n - 1.0) * (x ** (n - 1.0) - 1.0) - travel
        return self.p1 * folding + self.p2 * packing

    def stiffness(self, gap: np.ndarray) -> np.ndarray:
        """Tangent -dp/dh, in [Pa/m]. Same shape."""
        x = self._ratio(np.asarray(gap, dtype=float))
        n = self.exponent
        return (2.0 * self.p1 * x**3 + n * self.p2 * x ** (n + 1.0)) / self.height

    @lru_cache(maxsize=256)  # noqa: B019, small laws that trials share
    def gap_under(self, pressure: float) -> float:
        """Gap in [m] at which the pile carries a pressure in [Pa]; inverted by bisection."""
        low, high = max(self.solid_height, SMALLEST_GAP), self.height
        for _ in range(60):
            middle = 0.5 * (low + high)
            if float(self.pressure(np.array(middle))) > pressure:
                low = middle
            else:
                high = middle
        return 0.5 * (low + high)
