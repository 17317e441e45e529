"""What a foot stands on in MuJoCo: its plane of the ground, and the spheres that carry it there.

A pile is a plane that is tangent to its law in this step, with a spring at every support of the
sole. As many spheres as have the sum, the moments and the stiffness of those that are loaded stand
for them: two to each side along their principal axes, a standard deviation from their mean.
"""

from __future__ import annotations

from math import sqrt

import numpy as np

from gaitlab.kinematics.compiled import njit
from gaitlab.model.soles import SUPPORT_RADIUS
from gaitlab.simulation.mujoco.model import MARGIN, PARKED, SPHERES
from gaitlab.simulation.mujoco.world import LAYER, PILE, Acting, Carried, Places, velocity
from gaitlab.surfaces.ground import Footprint, Pile
from gaitlab.surfaces.press import press

NEAR = 5e-4  # m, by which supports that touch nothing yet may be over the lowest to count
LINKS = 2  # of the soft planes, the one under all links but the feet
_UPRIGHT = (0.0, 0.0, 0.0, 1.0)


@njit
def stand(
    at: Places, robot: Carried, pile: Pile, footprint: Footprint, acting: Acting, side: int
) -> None:
    """Put the plane under one foot and the spheres that it stands on; let the pile push it."""
    body, plane, normal = robot.feet[side], robot.planes[side], acting.normal
    if robot.ground == PILE:
        w, x, y, z = at.xquat[body]
        origin = (at.xpos[body, 0], at.xpos[body, 1], at.xpos[body, 2])
        centre = (at.xipos[body, 0], at.xipos[body, 1], at.xipos[body, 2])
        moving = velocity(at, robot.trunk, body)
        spin = (at.cvel[body, 0], at.cvel[body, 1], at.cvel[body, 2])
        support = press(pile, footprint, origin, (x, y, z, w), centre, moving, spin, robot.dt)
        acting.spring[side, 0], acting.spring[side, 1] = support.stiffness, support.damping
        for i in range(2):
            acting.plough[side, i], acting.push[side, i] = support.plough[i], support.push[i]
            at.applied[body, i] = support.push[i]
        for i in range(3):
            at.applied[body, 3 + i] = support.torque[i]
        _place(at, plane, support.point, support.turn, normal)
        acting.spring[side, 2] = _carry(at, robot, acting, side, 0)
    elif robot.ground == LAYER:
        acting.spring[side, 0], acting.spring[side, 1] = robot.spring
        _place(at, plane, (0.0, 0.0, robot.top), _UPRIGHT, normal)
        _place(at, robot.planes[LINKS], (0.0, 0.0, robot.top), _UPRIGHT, normal)
        acting.spring[side, 2] = _carry(at, robot, acting, side, 0)
    else:
        _park(at, robot.spheres[side, 0], 0)
    normal[0], normal[1], normal[2], normal[3] = 0.0, 0.0, 1.0, 0.0
    _carry(at, robot, acting, side, 1)


@njit
def _place(
    at: Places,
    plane: int,
    point: tuple[float, float, float],
    turn: tuple[float, float, float, float],
    normal: np.ndarray,
) -> None:
    """Put a plane there, xyzw; says its normal and its height along that."""
    x, y, z, w = turn
    matrix = at.geom_xmat[plane]
    matrix[0], matrix[1] = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w)
    matrix[3], matrix[4] = 2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z)
    matrix[6], matrix[7] = 2.0 * (x * z - y * w), 2.0 * (y * z + x * w)
    matrix[2], matrix[5] = 2.0 * (x * z + y * w), 2.0 * (y * z - x * w)
    matrix[8] = 1.0 - 2.0 * (x * x + y * y)
    normal[3] = 0.0
    for i in range(3):
        at.geom_xpos[plane, i] = point[i]
        normal[i] = matrix[3 * i + 2]
        normal[3] += normal[i] * point[i]


@njit
def _park(at: Places, spheres: np.ndarray, first: int) -> None:
    """Put spheres out of the way, from one of them on."""
    for k in range(first, SPHERES):
        at.geom_xpos[spheres[k], 2] = PARKED


@njit
def _carry(at: Places, robot: Carried, acting: Acting, side: int, ground: int) -> float:
    """Put the spheres of a foot where they carry what its supports do on the plane of `acting`.

    Those carry that overlap; if none does, those that will.

    Returns:
        How many supports stand in each sphere.
    """
    normal = acting.normal
    body, spheres = robot.feet[side], robot.spheres[side, ground]
    w, x, y, z = at.xquat[body]
    # The foot's axes along the normal, so that a support's height is linear in its coordinates.
    up_x = normal[0] * (1.0 - 2.0 * (y * y + z * z))
    up_x += normal[1] * 2.0 * (x * y + z * w) + normal[2] * 2.0 * (x * z - y * w)
    up_y = normal[0] * 2.0 * (x * y - z * w)
    up_y += normal[1] * (1.0 - 2.0 * (x * x + z * z)) + normal[2] * 2.0 * (y * z + x * w)
    up_z = normal[0] * 2.0 * (x * z + y * w)
    up_z += normal[1] * 2.0 * (y * z - x * w) + normal[2] * (1.0 - 2.0 * (x * x + y * y))
    supports = robot.supports[side]
    base = -normal[3] - SUPPORT_RADIUS + up_z * (supports[0, 2] + SUPPORT_RADIUS)
    for i in range(3):
        base += normal[i] * at.xpos[body, i]
    lowest = MARGIN
    for i in range(len(supports)):
        lowest = min(lowest, base + up_x * supports[i, 0] + up_y * supports[i, 1])
    reach, count = 0.0 if lowest < 0.0 else min(lowest + NEAR, MARGIN), 0
    for i in range(len(supports)):
        if base + up_x * supports[i, 0] + up_y * supports[i, 1] < reach:
            acting.points[count, 0], acting.points[count, 1] = supports[i, 0], supports[i, 1]
            count += 1
    if count == 0:
        _park(at, spheres, 0)
        return 0.0
    mx, my = 0.0, 0.0
    for i in range(count):
        mx += acting.points[i, 0] / count
        my += acting.points[i, 1] / count
    xx, xy, yy = 0.0, 0.0, 0.0
    for i in range(count):
        dx, dy = acting.points[i, 0] - mx, acting.points[i, 1] - my
        xx += dx * dx / count
        xy += dx * dy / count
        yy += dy * dy / count
    half, apart = 0.5 * (xx + yy), sqrt(0.25 * (xx - yy) ** 2 + xy * xy)
    longer, shorter = sqrt(half + apart), sqrt(max(half - apart, 0.0))
    ax, ay = 1.0, 0.0
    if apart > 0.0:
        # The longer axis, from the row of the matrix that says it best.
        ax, ay = (0.5 * (xx - yy) + apart, xy) if xx > yy else (xy, 0.5 * (yy - xx) + apart)
        length = sqrt(ax * ax + ay * ay)
        ax, ay = ax / length, ay / length
    made = 0
    tiny = 1e-6 * longer
    for a in range(2 if longer > 0.0 else 1):
        for b in range(2 if shorter > tiny else 1):
            along = longer * (1.0 - 2.0 * a)
            across = shorter * (1.0 - 2.0 * b) if shorter > tiny else 0.0
            px, py = mx + ax * along - ay * across, my + ay * along + ax * across
            pz = supports[0, 2] + SUPPORT_RADIUS
            geom = at.geom_xpos[spheres[made]]
            # The vector (px, py, pz) turned by the quaternion.
            tx, ty, tz = 2.0 * (y * pz - z * py), 2.0 * (z * px - x * pz), 2.0 * (x * py - y * px)
            geom[0] = at.xpos[body, 0] + px + w * tx + y * tz - z * ty
            geom[1] = at.xpos[body, 1] + py + w * ty + z * tx - x * tz
            geom[2] = at.xpos[body, 2] + pz + w * tz + x * ty - y * tx
            made += 1
    _park(at, spheres, made)
    return count / made
