"""Everything the engine gave, tick by tick, kept in arrays that were there before the loop."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from gaitlab.engine import TickState

CHUNK = 500  # ticks of contact points kept as Python tuples before they become an array
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
        body_contact: A link other than a foot touched the ground. Shape (n,).
        fall_cause: Code of the log's column of that name. Shape (n,).
    """

    def __init__(self, ticks: int, joints: int, feet: Sequence[int]) -> None:
        """Room for a number of ticks; `feet` are the engine's link indices, left then right."""
        self.length = 0
        self.base = np.empty((ticks, 13))
        self.joints = np.empty((ticks, 3, joints))
        self.plough = np.empty((ticks, 2, 2))
        self.body_contact = np.zeros(ticks, dtype=bool)
        self.fall_cause = np.zeros(ticks, dtype=np.int8)
        self._sides = {link: side for side, link in enumerate(feet)}
        self._points: list[tuple[float, ...]] = []
        self._chunks: list[np.ndarray] = [np.empty((0, CONTACT_FIELDS))]

    def touches_ground(self, state: TickState) -> bool:
        """Whether a link other than a foot is on the ground."""
        sides = self._sides
        return any(point[3] not in sides for point in state.contacts)

    def put(
        self,
        state: TickState,
        plough: Sequence[tuple[float, float]],
        body_contact: bool,
        fall_cause: int,
    ) -> None:
        """Record the end of a tick; indices into contacts are Bullet's getContactPoints fields."""
        k, sides = self.length, self._sides
        row, joints = self.base[k], self.joints[k]
        row[0:3], row[3:7], row[7:10], row[10:13] = state[:4]
        joints[0], joints[1], _, joints[2] = zip(*state.joints, strict=True)
        self.plough[k] = plough
        self.body_contact[k], self.fall_cause[k] = body_contact, fall_cause
        self._points += [
            (k, sides[p[3]], *p[5], p[9], *p[7], p[10], *p[11], p[12], *p[13])
            for p in state.contacts
            if p[3] in sides
        ]
        self.length = k + 1
        if self.length % CHUNK == 0:
            self._pack()

    def _pack(self) -> None:
        if self._points:
            self._chunks.append(np.array(self._points))
            self._points = []

    def contacts(self) -> Contacts:
        """Contact points of the soles, in the order of the ticks."""
        self._pack()
        rows = np.concatenate(self._chunks)
        force = sum(rows[:, i, None] * rows[:, i + 1 : i + 4] for i in (5, 9, 13))
        return Contacts(
            tick=rows[:, 0].astype(int),
            side=rows[:, 1].astype(int),
            position=rows[:, 2:5],
            force=np.asarray(force),
        )
