"""Everything the engine gave, tick by tick, kept in arrays that were there before the loop."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gaitlab.engine import TickState

CHUNK = 500  # ticks of contact points kept as Python tuples before they become an array
CONTACT_FIELDS = 12  # tick, side, position, normal force, two friction forces with directions


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
            (k, sides[p[3]], *p[5], p[9], p[10], *p[11][:2], p[12], *p[13][:2])
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

    def contacts(self) -> np.ndarray:
        """Contact points of the soles: tick, side, position [m], normal force [N], then twice a
        friction force [N] and the x and y of its direction. Shape (points, 12)."""
        self._pack()
        return np.concatenate(self._chunks)
