"""Gears and belts between joints, in Bullet.

Bullet's gear acts on the coordinates of two joints and on their speeds; what drifts is pulled back
by a share of the error a tick.

References:
    Bullet: Coumans and Bai, PyBullet, a Python module for physics simulation, 2016-2021.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from gaitlab.body import Coupling
from gaitlab.engine.bullet import JOINT_GEAR, BulletClient

STRENGTH = 1e4  # N m, more than any belt of these robots transmits
CORRECTION = 4.0  # -, Bullet's erp; smaller lets a loaded leg sag by degrees, larger rings


def add_couplings(
    client: BulletClient, body: int, couplings: Sequence[Coupling], joints: Mapping[str, int]
) -> None:
    """Tie joints of a body together.

    Args:
        client: The world.
        body: The robot.
        couplings: Its gears and belts.
        joints: Bullet's index of every joint by name.
    """
    for coupling in couplings:
        pair = joints[coupling.leader], body, joints[coupling.follower]
        along, here = [0.0, 1.0, 0.0], [0.0, 0.0, 0.0]
        gear = client.createConstraint(body, *pair, JOINT_GEAR, along, here, here)
        # Bullet's ratio is the leader's turns for one of the follower, the other way round.
        ratio = -1.0 / coupling.ratio
        client.changeConstraint(gear, gearRatio=ratio, erp=CORRECTION, maxForce=STRENGTH)
