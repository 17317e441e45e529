"""Everything the engine gave, tick by tick, kept in arrays that were there before the loop."""

from __future__ import annotations

from array import array
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from gaitlab.simulation.engine import TickState

CONTACT_FIELDS = 17  # tick, side, position, then three forces with their directions


class Contacts(NamedTuple):
    """Contact points under the soles.

    Attributes:
        tick: Index of the tick. Shape (points,).
        side: 0 left, 1 right. Shape (points,).
        position: Point on the sole, world frame, in [m]. Shape (points, 3).
        force: Force on the robot, world frame, in [N]. Shape (points, 3).
    """

    tick: np.ndarray
    side: np.ndarray
    position: np.ndarray
    force: np.ndarray

    def of(self, side: int) -> Contacts:
        """The points under one sole."""
        return Contacts(*(part[self.side == side] for part in self))

    def total(self, weights: np.ndarray, ticks: int) -> np.ndarray:
        """Sum of a quantity of the points at each tick. Shapes (points,) to (ticks,)."""
        return np.bincount(self.tick, weights, ticks)


class Recording:
    """Raw states of a trial; rows from `length` on are not filled.

    Attributes:
        length: Ticks recorded so far.
        base: Trunk: position of its centre of mass [m], quaternion, velocity, spin. Shape (n, 13).
        joints: Position [rad], velocity [rad/s], torque [N m]. Shape (n, 3, joints).
        plough: Plough force on each foot, world x and y, in [N]. Shape (n, 2, 2).
        push: All that pushed each foot sideways beside the contacts, likewise.
        body_contact: A link other than a foot touched the ground. Shape (n,).
        fall_cause: Code of the log's column of that name. Shape (n,).
    """

    def __init__(self, ticks: int, joints: int, feet: Sequence[int]) -> None:
        """Room for a number of ticks; `feet` are the engine's link indices, left then right."""
        self.length = 0
        self.base = np.empty((ticks, 13))
        self.joints = np.empty((ticks, 3, joints))
        self.plough, self.push = np.empty((ticks, 2, 2)), np.empty((ticks, 2, 2))
        self.body_contact = np.zeros(ticks, dtype=bool)
        self.fall_cause = np.zeros(ticks, dtype=np.int8)
        self._sides = {link: side for side, link in enumerate(feet)}
        self._points = array("d")

    def put(
        self,
        state: TickState,
        plough: Sequence[tuple[float, float]],
        push: Sequence[tuple[float, float]],
    ) -> bool:
        """Record the end of a tick, and say whether a link other than a foot is on the ground.

        Indices into contacts are the fields of Bullet's getContactPoints.
        """
        k, sides, body_contact = self.length, self._sides, False
        row = self.base[k]
        row[0:3], row[3:7], row[7:10], row[10:13] = state[:4]
        self.joints[k] = state.joints
        self.plough[k], self.push[k] = plough, push
        for p in state.contacts:
            side = sides.get(p[3])
            if side is None:  # Bullet also lists what is near
                body_contact = body_contact or p[9] > 0.0
            else:
                self._points.extend((k, side, *p[5], p[9], *p[7], p[10], *p[11], p[12], *p[13]))
        self.body_contact[k] = body_contact
        self.length = k + 1
        return body_contact

    def end(self, fall_cause: int) -> None:
        """Mark the last recorded tick as the one in which a fall was established."""
        self.fall_cause[self.length - 1] = fall_cause

    def contacts(self) -> Contacts:
        """Contact points of the soles, in the order of the ticks."""
        rows = np.frombuffer(self._points).reshape(-1, CONTACT_FIELDS)
        force = sum(rows[:, i, None] * rows[:, i + 1 : i + 4] for i in (5, 9, 13))
        return Contacts(
            tick=rows[:, 0].astype(int),
            side=rows[:, 1].astype(int),
            position=rows[:, 2:5],
            force=np.asarray(force),
        )
