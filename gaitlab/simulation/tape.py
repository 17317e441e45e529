"""What happened in a trial, tick by tick: an engine writes it, the log is made from it.

The arrays are there before the first tick and belong to whoever made the tape, so that an engine
may write them from compiled code and nothing is collected in lists.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

CONTACT_FIELDS = 8  # tick, side, point, force
ROOM = 16  # contact points a tick for which there is room at first, 4 supports a foot twice


class Contacts(NamedTuple):
    """Contact points under the soles, in the order of the ticks.

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


class Tape:
    """The world at the end of every tick; rows from `length` on are not written yet.

    Attributes:
        length: Ticks written so far.
        trunk: Trunk link frame: position [m], orientation xyzw; velocity of the trunk's centre of
            mass [m/s] and angular velocity [rad/s]; all in the world frame. Shape (n, 13).
        joints: Position [rad], velocity [rad/s] and torque [N m] of each joint in the order of the
            robot's tree, the pitch of a gantry last. The torque is that of the joint's motor, the
            mean over the tick. Shape (n, 3, joints).
        plough: Plough force on the left and the right foot, world x and y, in [N]. Shape (n, 2, 2).
        push: All that pushed each foot sideways beside its contacts, likewise.
        body_touches: Whether the ground pushed on a link other than a foot. Shape (n,).
        fall_cause: Code of the log's column of that name. Shape (n,).
        points: Contact points of the soles: tick, side, point [m] and force on the robot [N], world
            frame. Rows from `contacts_used` on are not written yet. Shape (m, 8).
        contacts_used: Contact points written so far.
    """

    def __init__(self, ticks: int, joints: int) -> None:
        """Takes the ticks there is to be room for, and the joints of the log."""
        self.length = self.contacts_used = 0
        self.trunk = np.empty((ticks, 13))
        self.joints = np.empty((ticks, 3, joints))
        self.plough, self.push = np.zeros((ticks, 2, 2)), np.zeros((ticks, 2, 2))
        self.body_touches = np.zeros(ticks, dtype=bool)
        self.fall_cause = np.zeros(ticks, dtype=np.int8)
        self.points = np.empty((ROOM * ticks, CONTACT_FIELDS))

    def reserve(self, rows: int) -> None:
        """Make room for that many further contact points; the array may become another one."""
        wanted = self.contacts_used + rows
        if wanted > len(self.points):
            larger = np.empty((max(wanted, 2 * len(self.points)), CONTACT_FIELDS))
            larger[: self.contacts_used] = self.points[: self.contacts_used]
            self.points = larger

    def end(self, fall_cause: int) -> None:
        """Mark the last tick as the one in which a fall was established."""
        self.fall_cause[self.length - 1] = fall_cause

    @property
    def contacts(self) -> Contacts:
        """The contact points that were written."""
        rows = self.points[: self.contacts_used]
        return Contacts(
            tick=rows[:, 0].astype(int),
            side=rows[:, 1].astype(int),
            position=rows[:, 2:5],
            force=rows[:, 5:8],
        )
