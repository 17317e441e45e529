"""How a pile pushes back on a sole, one tick at a time: the compiled kernel behind the engine.

Every support point of a sole obeys the pile law at its own gap, with its own hysteresis and its
own local pile height. Their sum is handed to the engine as one plane per foot that is tangent to
the law: it carries the same total force, the same moments and the same stiffness, and the engine
solves it implicitly together with weight and motors. The blades of a pile push upwards; a sloping
plane pushes along its normal, so that a force on the foot takes the sideways part away. Edges that
move forward through standing pile meet the plough force: the energy u(h) stored per area swept,
times a hooking factor, derived here from the same potential.

References:
    Dahl1968: Dahl, A solid friction model, Aerospace Corporation TOR-0158, 1968.
"""

from __future__ import annotations

import numpy as np

from gaitlab.kinematics.compiled import njit
from gaitlab.surfaces.ground import Footprint, Pile, Support
from gaitlab.surfaces.pile import SMALLEST_GAP

CELL = 0.02  # m, side of a cell in which the pile is alike
CLEAR = 1.35  # times the pile height: a foot above this meets nothing
PLOUGH_GAP = 8e-4  # m, smallest gap at which a leading edge is evaluated
STEEPEST = 0.6  # largest slope of the tangent plane, reached far beyond a tilt of 20 degrees
ROUNDS = 6  # of finding which supports the plane loads; two or three do
LEVEL = 1e-6  # m^2, keeps the plane level along an axis in which the loaded points do not differ


@njit
def _cell(field: np.ndarray, x: float, y: float) -> float:
    return field[int(np.floor(x / CELL)) % len(field), int(np.floor(y / CELL)) % len(field)]


@njit
def _pressure(law: np.ndarray, gap: float, height: float) -> tuple[float, float]:
    """Pressure [Pa] and its tangent [Pa/m] of a pile of local height at a gap [m]."""
    _, n, p1, p2, solid = law
    x = height / max(gap, solid, SMALLEST_GAP)
    power = x ** (n - 1.0)
    pressure = p1 * (x * x - 1.0) + p2 * (power * x - 1.0)
    return pressure, (2.0 * p1 * x**3 + n * p2 * power * x * x) / height


@njit
def _energy(law: np.ndarray, gap: float) -> float:
    """Energy per area stored in the pile at a gap [m], in [J/m^2]."""
    height, n, p1, p2, solid = law
    gap = max(gap, solid, PLOUGH_GAP)
    if gap >= height:
        return 0.0
    x, travel = height / gap, height - gap
    packing = height / (n - 1.0) * (x ** (n - 1.0) - 1.0) - travel
    return p1 * (height * (x - 1.0) - travel) + p2 * packing


@njit
def _turn(rotation: np.ndarray, local: np.ndarray, out: np.ndarray) -> None:
    for i in range(len(local)):
        for j in range(3):
            out[i, j] = (
                rotation[j, 0] * local[i, 0]
                + rotation[j, 1] * local[i, 1]
                + rotation[j, 2] * local[i, 2]
            )


@njit
def rotation_of(q: tuple[float, float, float, float]) -> np.ndarray:
    """Rotation matrix of a unit quaternion xyzw. Shape (3, 3)."""
    x, y, z, w = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


@njit
def _loads(
    pile: Pile, footprint: Footprint, points: np.ndarray, load: np.ndarray
) -> tuple[float, float]:
    """Load [N] of each support point; returns their sum [N] and the mean stiffness [N/m]."""
    area = pile.size[0] * pile.size[1] / len(points)
    eta, reach, slack = pile.loss
    total, stiffness, touching = 0.0, 0.0, 0
    for i in range(len(points)):
        height = pile.law[0] * (1.0 + _cell(pile.height_field, points[i, 0], points[i, 1]))
        gap = points[i, 2]
        load[i] = 0.0
        if gap >= height:
            footprint.hysteresis[i], footprint.gap[i] = 0.0, np.nan
            continue
        pressure, tangent = _pressure(pile.law, gap, height)
        span = reach * height + slack
        before = height if np.isnan(footprint.gap[i]) else footprint.gap[i]
        q = min(max(footprint.hysteresis[i] + (before - gap) / span, -eta), eta)
        footprint.hysteresis[i], footprint.gap[i] = q, gap
        load[i] = area * pressure * (1.0 + q)
        slope = area * tangent * (1.0 + q)
        if abs(q) < eta:
            slope += area * pressure / span
        total += load[i]
        stiffness += slope
        touching += 1
    return total, stiffness / max(touching, 1)


@njit
def _slopes(points: np.ndarray, load: np.ndarray, stiffness: float) -> tuple[float, float]:
    """Slopes dz/dx, dz/dy of the plane whose equal springs carry the moments of these loads.

    The springs stand between the plane and the points; those that are pressed carry the loads'
    total and moments, and which are pressed is found by repetition. Bounded.
    """
    sx, sy = 0.0, 0.0
    pressed = load > 0.0
    for _ in range(ROUNDS):
        n, x, y, z = 0.0, 0.0, 0.0, 0.0
        for i in range(len(points)):
            if pressed[i]:
                n += 1.0
                x += points[i, 0]
                y += points[i, 1]
                z += points[i, 2]
        x, y, z = x / n, y / n, z / n
        xx, xy, yy, xz, yz, total = LEVEL, 0.0, LEVEL, 0.0, 0.0, 0.0
        for i in range(len(points)):
            dx, dy = points[i, 0] - x, points[i, 1] - y
            total += load[i] / stiffness
            xz += load[i] / stiffness * dx
            yz += load[i] / stiffness * dy
            if pressed[i]:
                xx += dx * dx
                xy += dx * dy
                yy += dy * dy
                xz += dx * (points[i, 2] - z)
                yz += dy * (points[i, 2] - z)
        determinant = xx * yy - xy * xy
        sx = min(max((xz * yy - yz * xy) / determinant, -STEEPEST), STEEPEST)
        sy = min(max((yz * xx - xz * xy) / determinant, -STEEPEST), STEEPEST)
        same, count = True, 0
        for i in range(len(points)):
            plane = z + total / n + sx * (points[i, 0] - x) + sy * (points[i, 1] - y)
            now = plane > points[i, 2]
            same = same and now == pressed[i]
            pressed[i] = now
            count += now
        if same or count == 0:
            break
    return sx, sy


@njit
def _plane_height(gaps: np.ndarray, total: float, stiffness: float) -> float:
    """Height z at which equal springs over these gaps carry the total load together."""
    gaps = np.sort(gaps)
    below = 0.0
    for i in range(len(gaps)):
        below += gaps[i]
        z = (total / stiffness + below) / (i + 1)
        if i + 1 == len(gaps) or z <= gaps[i + 1]:
            break
    return z


@njit
def _strength(pile: Pile, corner: np.ndarray, velocity: np.ndarray) -> float:
    """Energy per swept area that a leading edge meets at this corner, in [N/m]."""
    speed = np.hypot(velocity[0], velocity[1]) + 0.02
    with_nap = (velocity[0] * pile.plough[2] + velocity[1] * pile.plough[3]) / speed
    nap = 1.0 - pile.plough[1] * with_nap
    density = _cell(pile.density_field, corner[0], corner[1])
    return pile.plough[0] * density * nap * _energy(pile.law, corner[2])


@njit
def _plough(
    pile: Pile,
    footprint: Footprint,
    corners: np.ndarray,
    rotation: np.ndarray,
    centre: np.ndarray,
    velocity: np.ndarray,
    spin: np.ndarray,
    dt: float,
    wrench: np.ndarray,
) -> None:
    """Adds the force of the pile on the leading edges and its torque about the centre of mass."""
    height, cap, stiffest = pile.law[0], pile.plough[4], pile.plough[5]
    for c in range(4):
        along = 1.0 if c >= 2 else -1.0
        across = 1.0 if c % 2 else -1.0
        arm = corners[c] - centre
        vx = velocity[0] + spin[1] * arm[2] - spin[2] * arm[1]
        vy = velocity[1] + spin[2] * arm[0] - spin[0] * arm[2]
        strength = _strength(pile, corners[c], velocity) if corners[c, 2] < height else 0.0
        softness = 0.25 * (height - corners[c, 2]) + 2e-3
        for edge in range(2):
            j = 2 * c + edge
            side = along if edge == 0 else across
            nx, ny = side * rotation[0, edge], side * rotation[1, edge]
            largest = min(strength * pile.size[1 - edge] / 2.0, cap)
            stiffness = min(largest / softness, stiffest) if largest > 0.0 else 0.0
            force = footprint.force[j]
            if footprint.stiffness[j] > stiffness:
                force *= stiffness / footprint.stiffness[j]
            force = min(max(force + stiffness * (vx * nx + vy * ny) * dt, 0.0), largest)
            footprint.force[j], footprint.stiffness[j] = force, stiffness
            fx, fy = -force * nx, -force * ny
            wrench[0] += fx
            wrench[1] += fy
            wrench[2] -= arm[2] * fy
            wrench[3] += arm[2] * fx
            wrench[4] += arm[0] * fy - arm[1] * fx


@njit
def _forget(footprint: Footprint) -> None:
    footprint.hysteresis[:] = 0.0
    footprint.gap[:] = np.nan
    footprint.force[:] = 0.0
    footprint.stiffness[:] = 0.0


_UPRIGHT = (0.0, 0.0, 0.0, 1.0)
_AWAY = (0.0, 0.0, -1.0)
_NOTHING = (0.0, 0.0)
_LIFTED = Support(False, _AWAY, _UPRIGHT, 1.0, 0.0, _NOTHING, _NOTHING, (0.0, 0.0, 0.0))


@njit
def stand(
    pile: Pile,
    footprint: Footprint,
    origin: tuple[float, float, float],
    quaternion: tuple[float, float, float, float],
) -> float:
    """Let a foot have stood here for long, its blades at rest; returns what they carry, in [N].

    Blades at rest hold back neither way. A foot that is put into the pile as if it had just come
    down would be pushed up by friction that nothing has paid for.

    Args:
        pile: Pile and sole.
        footprint: Memory of this foot, changed in place.
        origin: Foot link frame, world frame, in [m].
        quaternion: Its orientation, xyzw.
    """
    points = np.empty((len(pile.supports), 3))
    _turn(rotation_of(quaternion), pile.supports, points)
    points += np.array(origin)
    _forget(footprint)
    area, total = pile.size[0] * pile.size[1] / len(points), 0.0
    for i in range(len(points)):
        height = pile.law[0] * (1.0 + _cell(pile.height_field, points[i, 0], points[i, 1]))
        if points[i, 2] < height:
            footprint.gap[i] = points[i, 2]
            total += area * _pressure(pile.law, points[i, 2], height)[0]
    return total


@njit
def press(
    pile: Pile,
    footprint: Footprint,
    origin: tuple[float, float, float],
    quaternion: tuple[float, float, float, float],
    centre: tuple[float, float, float],
    velocity: tuple[float, float, float],
    spin: tuple[float, float, float],
    dt: float,
) -> Support:
    """What the pile does to one foot in this tick; advances the footprint.

    Args:
        pile: Pile and sole.
        footprint: Memory of this foot, changed in place.
        origin: Foot link frame, world frame, in [m].
        quaternion: Its orientation, xyzw.
        centre: Centre of mass of the foot link, world frame, in [m].
        velocity: Velocity of that centre, in [m/s].
        spin: Angular velocity of the foot, world frame, in [rad/s].
        dt: Time step, in [s].
    """
    rotation = rotation_of(quaternion)
    base = np.array(origin)
    points = np.empty((len(pile.supports), 3))
    _turn(rotation, pile.supports, points)
    points += base
    if np.min(points[:, 2]) > CLEAR * pile.law[0] + 2e-3:
        _forget(footprint)
        return _LIFTED
    corners = np.empty((4, 3))
    _turn(rotation, pile.corners, corners)
    corners += base
    wrench = np.zeros(5)
    _plough(
        pile, footprint, corners, rotation, np.array(centre), np.array(velocity), np.array(spin),
        dt, wrench,
    )  # fmt: skip
    load = np.empty(len(points))
    total, stiffness = _loads(pile, footprint, points, load)
    plough, torque = (wrench[0], wrench[1]), (wrench[2], wrench[3], wrench[4])
    if total <= 0.0:
        return Support(True, _AWAY, _UPRIGHT, 1.0, 0.0, plough, plough, torque)
    # Bullet's springs stand on the balls of which the supports are the lowest points.
    balls = points + pile.ball * rotation[:, 2]
    x, y = float(np.mean(balls[:, 0])), float(np.mean(balls[:, 1]))
    sx, sy = _slopes(points, load, stiffness)
    steep = np.sqrt(1.0 + sx * sx + sy * sy)
    over = balls[:, 2] - pile.ball * steep - sx * (balls[:, 0] - x) - sy * (balls[:, 1] - y)
    z = _plane_height(over, total, stiffness)
    # What the law has beyond the plane: nothing sideways, and each load at its own support.
    px, py = total * sx, total * sy
    tx, ty, tz = torque
    for i in range(len(points)):
        spring = stiffness * max(z - over[i], 0.0)
        ax, ay, az = balls[i] - np.array(centre)
        tx += load[i] * (points[i, 1] - centre[1]) - spring * (ay + az * sy)
        ty -= load[i] * (points[i, 0] - centre[0]) - spring * (ax + az * sx)
        tz += spring * (ax * sy - ay * sx)
    turn = np.sqrt(2.0 * steep * (steep + 1.0))
    return Support(
        True,
        (x, y, z),
        (sy / turn, -sx / turn, 0.0, (steep + 1.0) / turn),
        stiffness * steep * steep,
        pile.relaxation_time * stiffness * steep * steep,
        plough,
        (plough[0] + px, plough[1] + py),
        (tx, ty, tz),
    )
