"""The rig that holds a robot against falling out of its sagittal plane, in Bullet.

It is a chain of joints and not a constraint, so that what it holds is held exactly; its slides are
massless and free. Pitch is a joint of its own, which a rig that keeps the trunk level holds by a
motor: the torque of that motor is the balancing moment.
"""

from __future__ import annotations

from gaitlab.model import GANTRY_PITCH, Gantry
from gaitlab.simulation.bullet.world import POSITION_CONTROL, BulletClient, Indices

STRENGTH = 1e4  # N m, more than any of these robots can ask for

Vector = tuple[float, float, float]
TrunkState = tuple[Vector, tuple[float, float, float, float], Vector, Vector]


class Rig:
    """A robot's gantry: where its trunk hangs.

    Attributes:
        pitch: Bullet's index of the joint that pitches the trunk; its link is the trunk.
        pitches: Whether the trunk may pitch.
    """

    def __init__(self, client: BulletClient, body: int, found: Indices, kind: Gantry) -> None:
        """Takes the rig as it was loaded, `planar` or `level`."""
        self._client, self._body, self.pitches = client, body, kind == "planar"
        self._slides = found.joint["gantry_x"], found.joint["gantry_z"]
        self.pitch = found.joint[GANTRY_PITCH]
        if not self.pitches:
            client.setJointMotorControl2(
                body, self.pitch, POSITION_CONTROL, targetPosition=0.0, force=STRENGTH
            )

    def place(self, x: float, height: float, pitch: float) -> None:
        """Put the trunk link frame there, in [m]; a level rig keeps it level, in [rad]."""
        for joint, at in zip(self._slides, (x, height), strict=True):
            self._client.resetJointState(self._body, joint, at)
        self._client.resetJointState(self._body, self.pitch, pitch if self.pitches else 0.0)

    def trunk(self) -> TrunkState:
        """Trunk: centre of mass [m], quaternion xyzw, velocity [m/s], angular velocity [rad/s]."""
        state = self._client.getLinkState(self._body, self.pitch, 1, 1)
        return state[0], state[1], state[6], state[7]
