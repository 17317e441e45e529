"""Gears and belts between joints, in Bullet.

Bullet's gear acts on the coordinates of two joints and on their speeds; what drifts is pulled back
by a share of the error a tick. A loaded gear drifts because the solver stops before it has
converged: each tick leaves a speed that grows with the impulse of the load, load x dt, so the error
settles in proportion to load x dt^2 / share. A share that grows with dt^2 is a stiffness: the same
sag at every step of time.

References:
    Bullet: Coumans and Bai, PyBullet, a Python module for physics simulation, 2016-2021.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from gaitlab.model import Coupling
from gaitlab.simulation.bullet.world import JOINT_GEAR, BulletClient

STRENGTH = 1e4  # N m, more than any belt of these robots transmits
CORRECTION = 1e6  # 1/s^2, Bullet's erp over dt^2; smaller lets a loaded leg sag by degrees
# -, largest erp: the whole error, as Bullet's own share is a fifth, and more rings. At 2 ms, the
# longest step, it is 4.
WHOLE = 5.0


def add_couplings(
    client: BulletClient,
    body: int,
    couplings: Sequence[Coupling],
    joints: Mapping[str, int],
    *,
    dt: float,
) -> None:
    """Tie joints of a body together.

    Args:
        client: The world.
        body: The robot.
        couplings: Its gears and belts.
        joints: Bullet's index of every joint by name.
        dt: Time step of the world, in [s].
    """
    share = min(CORRECTION * dt * dt, WHOLE)
    for coupling in couplings:
        pair = joints[coupling.leader], body, joints[coupling.follower]
        along, here = [0.0, 1.0, 0.0], [0.0, 0.0, 0.0]
        gear = client.createConstraint(body, *pair, JOINT_GEAR, along, here, here)
        # Bullet's ratio is the leader's turns for one of the follower, the other way round.
        ratio = -1.0 / coupling.ratio
        client.changeConstraint(gear, gearRatio=ratio, erp=share, maxForce=STRENGTH)
