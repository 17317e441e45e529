"""A motion: its keyframes as numbers, each with its place in the file."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from gaitlab.documents import Node
from gaitlab.errors import WrongValue

Point = tuple[float, float, float]
SIDEWAYS = ("roll", "yaw", "pan")  # joints about x and z, which turn the other way in a mirror


@dataclass(frozen=True, kw_only=True)
class Keyframe:
    """One pose and the way to it.

    Attributes:
        name: What it is called.
        move_time: On the way to it, in [s].
        pause_time: Rest in it, in [s].
        feet: Points of level soles in the hip frame, left and right, in [m].
        trunk_pitch: Forward lean of the trunk, in [rad].
        joints: Angles of all joints that the motion sets, in [rad].
        node: Its place in the file.
        places: Places of the joints that the frame itself names.
    """

    name: str
    move_time: float
    pause_time: float
    feet: tuple[Point, Point]
    trunk_pitch: float
    joints: Mapping[str, float]
    node: Node = field(compare=False, repr=False)
    places: Mapping[str, Node] = field(compare=False, repr=False)

    def place(self, joint: str) -> Node:
        """Where a mistake about a joint is reported."""
        return self.places.get(joint, self.node)

    def mirrored(self) -> Keyframe:
        """The same pose with left and right exchanged.

        Raises:
            WrongValue: If a joint is set on one side only.
        """
        left, right = ((x, -y, z) for x, y, z in self.feet)
        return replace(self, feet=(right, left), joints=_mirrored(self.joints))


@dataclass(frozen=True, kw_only=True)
class Motion:
    """Keyframes in the order of play; the last leads back to the first.

    Attributes:
        file: File it was read from.
        description: What it is.
        tempo: Speed of play; 2 halves every time.
        frames: At least two; all set the same joints.
    """

    file: Path
    description: str
    tempo: float
    frames: tuple[Keyframe, ...]

    @property
    def joints(self) -> tuple[str, ...]:
        """Joints that it sets."""
        return tuple(self.frames[0].joints)

    @property
    def digest(self) -> str:
        """SHA-256 of its numbers; names of frames and comments apart. 64 hex digits."""
        numbers = [
            (f.move_time, f.pause_time, f.feet, f.trunk_pitch, sorted(f.joints.items()))
            for f in self.frames
        ]
        return hashlib.sha256(repr((self.tempo, numbers)).encode()).hexdigest()

    def mirrored(self) -> Motion:
        """The same motion with left and right exchanged.

        Raises:
            WrongValue: If a joint is set on one side only.
        """
        return replace(self, frames=tuple(frame.mirrored() for frame in self.frames))

    def faster(self, factor: float) -> Motion:
        """The same motion at so many times its tempo."""
        return replace(self, tempo=self.tempo * factor)


def mirror_joint(name: str) -> str:
    """The joint on the other side; a joint in the middle is its own."""
    for side, other in (("left_", "right_"), ("right_", "left_")):
        if name.startswith(side):
            return other + name.removeprefix(side)
    return name


def _mirrored(joints: Mapping[str, float]) -> dict[str, float]:
    alone = [name for name in joints if mirror_joint(name) not in joints]
    if alone:
        raise WrongValue(
            f"{alone[0]} is set and {mirror_joint(alone[0])} is not, so the motion has no mirror "
            "image; set both in the first frame"
        )
    return {name: _turned(name, joints[mirror_joint(name)]) for name in joints}


def _turned(name: str, angle: float) -> float:
    return -angle if any(word in name for word in SIDEWAYS) else angle
