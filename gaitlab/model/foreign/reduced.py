"""A foreign robot reduced to what walks and is carried: links, legs as lines of axes, soles.

The trunk is the body that both legs hang on, with all that is rigid beside it: what lies above it,
fingers, branches of a leg that are not on the way to its foot. Its frame lies midway between the
hips, x forward, y left, z up; every link's frame is parallel to it at zero angles and lies on the
link's own axis, but for the feet, whose frames are their soles'. So a joint that a file draws
elsewhere on its axis, or a root that it turns, gives the same robot.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from gaitlab.errors import WrongValue
from gaitlab.kinematics.transforms import vector_rotation
from gaitlab.model.foreign.anatomy import LATERAL, Legs, roles
from gaitlab.model.foreign.leg import FoundLeg, limits_of, standing_angles
from gaitlab.model.foreign.reading import Bodies, BodyJoint
from gaitlab.model.foreign.sole import FoundSole, find_sole
from gaitlab.model.tree import Axis, Box, Joint, Link, Tree, Vector

SLIGHT = 0.003  # share of the mass; what turns less than that is rigid, a finger or a camera
ON_AXIS = 1e-9  # by which an axis may differ from a coordinate axis and still be it
THINNEST = 0.005  # m, edge of a link's box
BAR = 0.15  # edge of the bar that stands for a body without geometry, as a share of its length
OWN_SIDE = 5e-4  # m from the mirror plane, beyond which no leg's box reaches
CROSS = 0.01  # m, edge of what stands for the bodies between shank and foot, which touch nothing
UNEQUAL = 0.005  # m by which soles may differ before a user is told


SOLE_LENGTHS = {  # of a sole: what each is, and from where to where it may be, in [m]
    "length": ("sole along x of the foot", 0.01, 1.0),
    "width": ("sole along y of the foot", 0.01, 1.0),
    "heel": ("ankle axis to the heel edge", -0.5, 1.0),
    "height": ("ankle axis over the sole", 0.002, 0.5),
    "outward": ("sole's centre outside the ankle", -0.5, 0.5),
}


class SoleSize(NamedTuple):
    """A left sole in its foot's frame, in [m], as `gaitlab.model.soles.Sole` has it."""

    length: float
    width: float
    heel: float
    outward: float
    height: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Reduced:
    """What a foreign robot is for gaitlab.

    Attributes:
        tree: Its links, the trunk first, then the left leg, the right leg and all else.
        feet: Names of the left and the right foot link.
        legs: The left and the right leg.
        sole: Of the left foot.
        tilt: Of the soles at zero angles, in [rad].
        held: Joints that no leg has and the angle each is held at, in [rad].
        rigid: Names of joints that are taken for rigid.
        notes: What a user should know, a sentence each.
    """

    tree: Tree
    feet: tuple[str, str]
    legs: tuple[FoundLeg, FoundLeg]
    sole: SoleSize
    tilt: float
    held: Mapping[str, float]
    rigid: tuple[str, ...]
    notes: tuple[str, ...]


class Overrides(NamedTuple):
    """What a robot file says beside its URDF.

    Attributes:
        posture: Angle at which a joint of no leg is held, by its name, in [rad]; None to leave it
            at zero, or as near to that as its limits allow.
        servo: Name of a joint's servo.
        sole: Lengths of the sole by name, in [m], where they are not to be found in the geometry.
    """

    posture: Callable[[str], float | None]
    servo: Callable[[str], str]
    sole: Mapping[str, float]


def reduced(
    robot: Bodies, legs: Legs, vertices: Sequence[np.ndarray], overrides: Overrides
) -> Reduced:
    """The robot that walks.

    Args:
        robot: Bodies of the file.
        legs: Its legs.
        vertices: Of each body's geometry in the body's frame, in [m]; none where it has none.
        overrides: What the user says.

    Raises:
        WrongValue: If no sole is to be found, or a leg lacks a hip, knee or ankle that pitches.
    """
    return _Reduction(robot, legs, vertices, overrides).made()


def plain(name: str) -> str:
    """A joint's or link's name as columns of a log and paths of parameters can have it."""
    return "".join(c if c.isascii() and c.isalnum() else "_" for c in name)


def _require_unlike(what: str, names: Sequence[str]) -> None:
    """Refuse names that only signs told apart which no column and no path can have."""
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise WrongValue(
            f"two {what} are called {twice[0]!r} once other signs than letters and digits are "
            "replaced by _; rename one of them"
        )


class _Reduction:
    """The steps of a reduction, with what they share: places of everything in the trunk's frame."""

    def __init__(
        self, robot: Bodies, legs: Legs, vertices: Sequence[np.ndarray], overrides: Overrides
    ) -> None:
        self.robot, self.legs, self.overrides = robot, legs, overrides
        self.notes: list[str] = []
        self.above = _path(robot, legs.pelvis)
        self.rigid = self._rigid()
        self.angles = [self._rest(k) if k in self.rigid else 0.0 for k in range(len(robot.bodies))]
        self.position, self.rotation = self._placed()
        self.heads = self._heads()
        self.chains = tuple(
            [k for k in chain if k not in self.rigid] for chain in (legs.left, legs.right)
        )
        self.position = self.position - self._hips()
        self.cloud = [
            points @ turn.T + at
            for points, turn, at in zip(vertices, self.rotation, self.position, strict=True)
        ]

    def made(self) -> Reduced:
        """The robot."""
        foot_soles = self._soles()
        left, right = (self._leg(side, sole) for side, sole in enumerate(foot_soles))
        order = [self.legs.pelvis, *self.chains[0], *self.chains[1]]
        order += [k for k in self.heads if self.heads[k] == k and k not in order]
        frames = {k: (self._on_axis(k), np.eye(3)) for k in order}
        for side, leg in enumerate((left, right)):
            frames |= {k: (leg.points[i], np.eye(3)) for i, k in enumerate(self.chains[side])}
            frames[self.chains[side][-1]] = (leg.ankle, leg.rotation)
        links = tuple(self._link(k, frames) for k in order)
        _require_unlike("links", [link.name for link in links])
        _require_unlike("joints", [link.joint.name for link in links if link.joint])
        held = {plain(self._joint(k).name): self._rest(k) for k in order if self._is_held(k)}
        sole, tilt = self._size(foot_soles[0], left), foot_soles[0].tilt
        other = self._size(foot_soles[1], right, side=1)
        if max(abs(a - b) for a, b in zip(sole, other, strict=True)) > UNEQUAL:
            self.notes.append(
                f"the soles differ: left {1e3 * sole.length:.0f} x {1e3 * sole.width:.0f} mm, "
                f"right {1e3 * other.length:.0f} x {1e3 * other.width:.0f} mm; both are taken as "
                "the left"
            )
        names = [plain(self.robot.bodies[chain[-1]].name) for chain in self.chains]
        return Reduced(
            tree=Tree(links),
            feet=(names[0], names[1]),
            legs=(left, right),
            sole=sole,
            tilt=tilt,
            held=held,
            rigid=tuple(self._joint(k).name for k in sorted(self.rigid)),
            notes=tuple(self.notes),
        )

    def _joint(self, body: int) -> BodyJoint:
        joint = self.robot.bodies[body].joint
        assert joint is not None  # only the root has none
        return joint

    def _rest(self, body: int) -> float:
        """Angle at which a joint that does not walk is held, in [rad]."""
        joint = self._joint(body)
        wished = self.overrides.posture(joint.name)
        low, high = limits_of(joint.lower, joint.upper)
        return float(np.clip(0.0 if wished is None else wished, low, high))

    def _rigid(self) -> set[int]:
        """Bodies that do not move against their parent here."""
        bodies, walking = self.robot.bodies, {*self.legs.left, *self.legs.right}
        carried = [body.mass for body in bodies]
        for k in range(len(bodies) - 1, 0, -1):
            carried[bodies[k].parent] += carried[k]
        mimicked = {joint.mimics[0] for b in bodies if (joint := b.joint) and joint.mimics}
        rigid = set[int]()
        for k in range(1, len(bodies)):
            joint = self._joint(k)
            if k in walking:
                fixed = joint.mimics is not None or joint.name in mimicked
            else:
                slight = carried[k] < SLIGHT * self.robot.mass
                fixed = slight or joint.mimics is not None or bool(_path(self.robot, k) & walking)
            if fixed or k in self.above:
                rigid.add(k)
        frozen = [self._joint(k).name for k in sorted(rigid & walking)]
        if frozen:
            self.notes.append(
                f"{', '.join(frozen)} turn with others by one motor or a linkage; they are held"
            )
        return rigid

    def _placed(self) -> tuple[np.ndarray, np.ndarray]:
        """Frames of all bodies, rigid joints at rest, the others at zero, as the base has axes."""
        bodies = self.robot.bodies
        position, rotation = np.zeros((len(bodies), 3)), np.tile(np.eye(3), (len(bodies), 1, 1))
        for k, body in enumerate(bodies[1:], start=1):
            at, above = position[body.parent], rotation[body.parent]
            position[k] = at + above @ body.position
            turn = vector_rotation(tuple(self._joint(k).axis), np.array(self.angles[k]))
            rotation[k] = above @ body.rotation @ turn
        pelvis = self.legs.pelvis
        zero = self.robot.at_zero
        # The base is the pelvis', however a waist above it is held.
        to_base = self.legs.base @ zero[1][pelvis] @ rotation[pelvis].T
        middle = zero[1][pelvis].T @ (self.legs.middle - zero[0][pelvis])
        origin = position[pelvis] + rotation[pelvis] @ middle
        return (position - origin) @ to_base.T, to_base @ rotation

    def _heads(self) -> dict[int, int]:
        """The body whose joint carries each, once what is rigid has been merged."""
        pelvis = self.legs.pelvis
        heads = {k: pelvis for k in (*self.above, pelvis, 0)}
        for k, body in enumerate(self.robot.bodies[1:], start=1):
            if k not in heads:
                heads[k] = heads[body.parent] if k in self.rigid else k
        return heads

    def _carrier(self, head: int) -> int:
        """The link that another one but the trunk hangs on."""
        return self.heads[self.robot.bodies[head].parent]

    def _is_held(self, body: int) -> bool:
        return body != self.legs.pelvis and not any(body in chain for chain in self.chains)

    def _lines(self, side: int) -> tuple[np.ndarray, np.ndarray]:
        chain = self.chains[side]
        axes = [self.rotation[k] @ self._joint(k).axis for k in chain]
        return np.array(axes), self.position[chain]

    def _pitches(self, side: int) -> tuple[int, int, int]:
        """Places of hip, knee and ankle in a leg."""
        axes, _ = self._lines(side)
        found = np.flatnonzero(np.abs(axes[:, 1]) > LATERAL)
        if len(found) < 3:
            which = ("left", "right")[side]
            raise WrongValue(
                f"the {which} leg turns as {roles(axes)}: a hip, a knee and an ankle that pitch "
                "are needed. If these are no legs, name the feet: `legs: {left: LINK, right: LINK}`"
            )
        hip, knee, ankle = (int(k) for k in found[-3:])
        return hip, knee, ankle

    def _hips(self) -> np.ndarray:
        """Midway between the hips, in the frame whose origin is in the mirror plane, in [m]."""
        at = np.mean([self._lines(side)[1][self._pitches(side)[0]] for side in (0, 1)], axis=0)
        return np.array([at[0], 0.0, at[2]])

    def _aside(self) -> float:
        """Lateral place of the left leg, its first axis that is not lateral, in [m]."""
        places = []
        for side in (0, 1):
            axes, points = self._lines(side)
            hip = points[self._pitches(side)[0]]
            k = next((i for i, axis in enumerate(axes) if abs(axis[1]) < LATERAL), None)
            if k is not None:
                flat = axes[k, [0, 2]]
                along = flat @ (hip - points[k])[[0, 2]] / (flat @ flat)
                places.append(abs(points[k, 1] + along * axes[k, 1]))
        return float(np.mean(places)) if places else abs(float(self._lines(0)[1][-1, 1]))

    def _soles(self) -> tuple[FoundSole, FoundSole]:
        """Both soles in the trunk's frame; one foot without geometry has the other's mirrored."""
        found = []
        for chain in self.chains:
            parts = [self.cloud[k] for k, head in self.heads.items() if head == chain[-1]]
            found.append(find_sole(np.concatenate(parts), np.eye(3)))
        left, right = found
        if left is None and right is None:
            left = self._asked()
        if left is None:
            assert right is not None
            left = _mirrored(right)
        return left, right if right is not None else _mirrored(left)

    def _asked(self) -> FoundSole:
        """The sole that the robot file gives in place of geometry."""
        wanted = self.overrides.sole
        lacking = [name for name in ("length", "width", "height") if name not in wanted]
        if lacking:
            reach = float(np.linalg.norm(self._lines(0)[1][-1] - self._lines(0)[1][0]))
            raise WrongValue(
                "no geometry of a foot can be read, so that its sole is unknown; measure it and "
                f"write, with your numbers, `sole: {{length: {0.35 * reach:.3f}, width: "
                f"{0.14 * reach:.3f}, heel: {0.14 * reach:.3f}, height: {0.1 * reach:.3f}}}` into "
                "the robot file"
            )
        _, points = self._lines(0)
        ankle = points[self._pitches(0)[2]]
        heel = wanted.get("heel", 0.4 * wanted["length"])
        centre = np.array(
            [ankle[0] + wanted["length"] / 2 - heel, self._aside(), ankle[2] - wanted["height"]]
        )
        return FoundSole(centre, np.eye(3), wanted["length"], wanted["width"], 0.0)

    def _leg(self, side: int, sole: FoundSole) -> FoundLeg:
        axes, points = self._lines(side)
        pitch = self._pitches(side)
        aside = self._aside() * (1.0, -1.0)[side]
        hip, knee, ankle = (np.array([points[k, 0], aside, points[k, 2]]) for k in pitch)
        references = [
            hip if k < pitch[1] else knee if k == pitch[1] else ankle for k in range(len(axes))
        ]
        on_line = (
            points + axes * np.einsum("ij,ij->i", axes, np.array(references) - points)[:, None]
        )
        joints = [self._joint(k) for k in self.chains[side]]
        limits = np.array([limits_of(joint.lower, joint.upper) for joint in joints])
        letters = roles(axes).upper()
        holds = (letters.count("R") > 1, True, "Y" in letters)
        if len(axes) >= 6:
            holds = (True, True, True)
        return FoundLeg(
            joints=tuple(plain(joint.name) for joint in joints),
            axes=axes,
            points=on_line,
            limits=limits,
            pitch=pitch,
            ankle=on_line[-1],
            rotation=sole.rotation,
            holds=holds,
            standing=standing_angles(axes, on_line, limits, pitch, sole.rotation),
            drawn=points[-1],
        )

    def _size(self, sole: FoundSole, leg: FoundLeg, side: int = 0) -> SoleSize:
        x, y, z = leg.rotation.T @ (sole.centre - leg.ankle)
        found = SoleSize(
            length=sole.length,
            width=sole.width,
            heel=sole.length / 2.0 - float(x),
            outward=float(y) * (1.0, -1.0)[side],
            height=-float(z),
        )
        return found._replace(
            **{k: v for k, v in self.overrides.sole.items() if k in found._fields}
        )

    def _sum(self, head: int) -> tuple[float, np.ndarray, np.ndarray]:
        """Mass, centre of mass and inertia about it of a link, in the trunk's axes."""
        parts = [k for k, own in self.heads.items() if own == head]
        masses = np.array([self.robot.bodies[k].mass for k in parts])
        centres = np.array(
            [self.position[k] + self.rotation[k] @ self.robot.bodies[k].centre for k in parts]
        )
        mass = float(masses.sum())
        centre = masses @ centres / mass if mass > 0.0 else centres.mean(axis=0)
        tensor = np.zeros((3, 3))
        for k, m, at in zip(parts, masses, centres, strict=True):
            arm, turn = at - centre, self.rotation[k]
            tensor += turn @ self.robot.bodies[k].inertia @ turn.T
            tensor += m * (arm @ arm * np.eye(3) - np.outer(arm, arm))
        return mass, centre, tensor

    def _on_axis(self, head: int) -> np.ndarray:
        """Where a link's frame lies: on its axis beside its centre of mass; the trunk's at 0."""
        if head == self.legs.pelvis:
            return np.zeros(3)
        axis = self.rotation[head] @ self._joint(head).axis
        return self.position[head] + axis * (axis @ (self._sum(head)[1] - self.position[head]))

    def _link(self, head: int, frames: Mapping[int, tuple[np.ndarray, np.ndarray]]) -> Link:
        body, (at, turn) = self.robot.bodies[head], frames[head]
        mass, centre, tensor = self._sum(head)
        local = turn.T @ tensor @ turn
        trunk = head == self.legs.pelvis
        above = None if trunk else self._carrier(head)
        origin, turned = np.zeros(3), np.eye(3)
        if above is not None:
            origin = frames[above][1].T @ (at - frames[above][0])
            turned = frames[above][1].T @ turn
        return Link(
            name=plain(body.name),
            parent=None if above is None else plain(self.robot.bodies[above].name),
            origin=_vector(origin),
            joint=None if trunk else self._made_joint(head, turn),
            mass=mass,
            box=self._box(head, at, turn),
            inertia=(*_vector(np.diag(local)), *_vector([local[0, 1], local[0, 2], local[1, 2]])),
            com=_vector(turn.T @ (centre - at)),
            turn=None if np.array_equal(turned, np.eye(3)) else tuple(map(float, turned.ravel())),
        )

    def _made_joint(self, head: int, turn: np.ndarray) -> Joint:
        joint = self._joint(head)
        low, high = limits_of(joint.lower, joint.upper)
        return Joint(
            name=plain(joint.name),
            axis=_axis(turn.T @ self.rotation[head] @ joint.axis),
            lower=low,
            upper=high,
            servo=self.overrides.servo(joint.name),
        )

    def _box(self, head: int, at: np.ndarray, turn: np.ndarray) -> Box:
        """The box around a link's geometry, or a bar between its joints where there is none."""
        cloud = np.concatenate([self.cloud[k] for k, own in self.heads.items() if own == head])
        side = next((s for s, chain in enumerate(self.chains) if head in chain), None)
        if side is not None and head != self.chains[side][-1]:
            chain, pitch = self.chains[side], self._pitches(side)
            if chain.index(head) > pitch[1]:  # between shank and foot
                return Box(size=(CROSS, CROSS, CROSS), centre=(0.0, 0.0, 0.0))
            if chain.index(head) == pitch[1]:
                ankle = self.position[chain[pitch[2]], 2]
                cloud = cloud[cloud[:, 2] >= ankle]
        if len(cloud) < 4:
            cloud = self._bar(head)
        if side is not None:
            sign = (1.0, -1.0)[side]
            cloud[:, 1] = sign * np.maximum(sign * cloud[:, 1], OWN_SIDE)
        local = (cloud - at) @ turn
        low, high = local.min(axis=0), local.max(axis=0)
        return Box(
            size=_vector(np.maximum(high - low, THINNEST)), centre=_vector((low + high) / 2.0)
        )

    def _bar(self, head: int) -> np.ndarray:
        """Corners of a bar from a link's joint to the next ones and to its centre of mass."""
        ends = [self.position[head], self._sum(head)[1]]
        ends += [
            self.position[k]
            for k, own in self.heads.items()
            if own == k and k != self.legs.pelvis and self._carrier(k) == head
        ]
        half = max(0.5 * BAR * float(np.ptp(ends, axis=0).max()), THINNEST)
        offsets = half * np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, -1).T
        return np.concatenate([end + offsets for end in ends])


def _path(robot: Bodies, body: int) -> set[int]:
    """A body and all that it hangs on, without the root."""
    path = set[int]()
    while body > 0:
        path.add(body)
        body = robot.bodies[body].parent
    return path


def _mirrored(sole: FoundSole) -> FoundSole:
    flip = np.diag([1.0, -1.0, 1.0])
    return sole._replace(centre=flip @ sole.centre, rotation=flip @ sole.rotation @ flip)


def _axis(axis: np.ndarray) -> Axis:
    """A coordinate axis by its name, any other as it is."""
    for name, unit in zip("xyz", np.eye(3), strict=True):
        for sign in ("", "-"):
            if np.abs(axis - (-unit if sign else unit)).max() < ON_AXIS:
                return f"{sign}{name}"  # type: ignore[return-value]
    return _vector(axis / np.linalg.norm(axis))


def _vector(values: Iterable[float]) -> Vector:
    x, y, z = (float(value) + 0.0 for value in values)
    return x, y, z
