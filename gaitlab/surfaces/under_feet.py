"""A pile under both feet of a robot, and what it remembers of each."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gaitlab.log import GRAVITY
from gaitlab.model import Robot
from gaitlab.surfaces.ground import new_footprint, pile_for, under_right_foot
from gaitlab.surfaces.press import stand
from gaitlab.surfaces.surface import FibreMat, TuftedPile

HIGHEST = 0.1  # m, by which a robot may have to be lifted to where its pile carries it
HALVINGS = 45  # of twice that, down to less than a thousandth of a micrometre

Pose = tuple[tuple[float, float, float], tuple[float, float, float, float]]


class UnderFeet:
    """A fresh lawn under a robot.

    Attributes:
        piles: Under the left and the right foot, as `press` wants them.
        footprints: Their memory, changed by `press`.
    """

    def __init__(
        self,
        robot: Robot,
        surface: TuftedPile | FibreMat,
        *,
        dt: float,
        irregularity: float,
        rng: np.random.Generator,
        down: float = GRAVITY,
    ) -> None:
        """Arguments as of `pile_for`, and how strongly gravity presses on it, in [m/s^2]."""
        self._load = robot.tree.mass * down
        pile = pile_for(
            surface,
            robot.sole,
            weight=robot.tree.mass * GRAVITY,
            foot_mass=robot.tree.links[robot.tree.index(robot.feet[0])].mass,
            dt=dt,
            rng=rng,
            irregularity=irregularity,
        )
        self.piles = (pile, under_right_foot(pile, robot.sole))
        count = len(pile.supports)
        self.footprints = (new_footprint(count), new_footprint(count))

    def settle(self, feet: Sequence[Pose]) -> float:
        """Let the feet have stood for long; how far the robot has to be lifted for that, in [m].

        Args:
            feet: Link frame of the left and of the right foot: position in [m] and xyzw.
        """
        low, high = -HIGHEST, HIGHEST
        for _ in range(HALVINGS):
            lift = 0.5 * (low + high)
            carried = 0.0
            for pile, footprint, (at, turn) in zip(self.piles, self.footprints, feet, strict=True):
                carried += stand(pile, footprint, (at[0], at[1], at[2] + lift), turn)
            low, high = (lift, high) if carried > self._load else (low, lift)
        return lift
