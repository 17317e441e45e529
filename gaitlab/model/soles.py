"""Soles: where they stand on the ground.

Equal supports on a bed of stiffness K resist tipping with K times the mean square of their
distance from the middle. n of them out to the edges of a length L give
K L^2 / 12 (n + 1) / (n - 1), derived here: K L^2 / 4 for two, K L^2 / 7.2 for four, and
K L^2 / 12 in the limit of a uniform pressure.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from gaitlab.parameters import parameter

MOST_SUPPORTS = 12  # along or across; each one is a contact that the engine solves
SUPPORT_RADIUS = 0.004  # m, sphere at each support point; only its lowest point touches
_GRID = "assumption: a few points stand for a plate; the more, the nearer to uniform pressure"


@dataclass(frozen=True, kw_only=True)
class Sole:
    """A rectangular sole and how it stands: on a grid of points out to its edges."""

    length: float = parameter(unit="m", low=0.01, high=1.0, doc="sole along x of the foot")
    width: float = parameter(unit="m", low=0.01, high=1.0, doc="sole along y of the foot")
    heel: float = parameter(unit="m", low=0.0, high=1.0, doc="ankle axis to the heel edge")
    height: float = parameter(unit="m", low=0.005, high=0.5, doc="ankle axis over the sole")
    kind: Literal["flat", "studs"] = parameter(
        unit="-", doc="flat is a grid of equal supports out to the edges, studs four corners"
    )
    supports_along: int = parameter(
        4,
        unit="-",
        low=2,
        high=MOST_SUPPORTS,
        doc="rows of supports from heel to toe of a flat sole",
        source=_GRID,
        late=True,
    )
    supports_across: int = parameter(
        3,
        unit="-",
        low=2,
        high=MOST_SUPPORTS,
        doc="supports of each row of a flat sole",
        source=_GRID,
        late=True,
    )

    @property
    def outward(self) -> float:
        """Lateral offset of the sole's centre from the ankle, away from the other foot, in [m]."""
        return 0.0

    @property
    def centre(self) -> tuple[float, float, float]:
        """Centre of the left sole in its foot link frame, in [m]."""
        return self.centre_of(0)

    def centre_of(self, foot: int) -> tuple[float, float, float]:
        """Centre of the sole of foot 0, left, or 1, right, in its link frame, in [m]."""
        across = self.outward if foot == 0 else 0.0 - self.outward
        return (self.length / 2.0 - self.heel, across, -self.height)

    def sensors(self, foot: int) -> np.ndarray | None:
        """Force sensors of foot 0, left, or 1, right, in the order of the log, link frame, in [m].

        Shape (4, 2); None for a robot that has none, whose log has the loads of sole quarters.
        """
        return None

    def supports(self, foot: int = 0) -> np.ndarray:
        """Support points in the foot link frame, in [m], from the rear right. Shape (m, 3)."""
        counts = (self.supports_along, self.supports_across)
        along, across = counts if self.kind == "flat" else (2, 2)
        x = np.linspace(-self.heel, self.length - self.heel, along)
        y = np.linspace(-self.width / 2.0, self.width / 2.0, across) + self.centre_of(foot)[1]
        grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
        return np.column_stack([grid, np.full(len(grid), -self.height)])

    def corners(self, foot: int = 0) -> np.ndarray:
        """Corners in the foot link frame, in [m]. Shape (4, 3).

        Their order is rear right, rear left, front right, front left.
        """
        x, y = (-self.heel, self.length - self.heel), (-self.width / 2.0, self.width / 2.0)
        middle = self.centre_of(foot)[1]
        return np.array([(a, b + middle, -self.height) for a in x for b in y])
