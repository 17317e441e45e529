"""Walks what a policy says, a network in an ONNX file that is fed what the robot feels.

The robot stands in the policy's default pose for `stand_time`. Then the policy takes over: at its
own rate it is fed what the declaration beside it lists, and its output becomes joint targets within
the joints' limits. The command grows from nothing in `start_time`, and from then on the walk is
measured. Where the declaration gives kp and kd, the servos are those, as strong and as late as the
robot's own. Joints are felt as they are, the trunk as the IMU tells it.

Nobody knows beforehand where the feet will be; those of the log are where its targets would put
them. Commanded distance is commanded speed times time.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from gaitlab.errors import WrongValue
from gaitlab.model import Robot
from gaitlab.model.forward import feet_of_joints
from gaitlab.model.gait import SHAPES, FeetPoses, changes
from gaitlab.model.imu import Attitude, Imu
from gaitlab.model.servo import Servo, driven_by_gains
from gaitlab.motions.declaration import (
    Declaration,
    Wiring,
    load_declaration,
    require_fitting,
    wired,
)
from gaitlab.motions.network import Network, load_network, read_network
from gaitlab.motions.pilot import Pilot
from gaitlab.parameters import parameter

ROUNDING = 1e-9  # s
UPRIGHT = Attitude(pitch=0.0, roll=0.0, pitch_rate=0.0, roll_rate=0.0)


@lru_cache(maxsize=64)
def _declaration(name: str, network: str, digest: str) -> Declaration:
    """That of a digest, asked for at every turn; whether it still is, the pilot finds out."""
    return load_declaration(name, Path(network))


@dataclass(frozen=True, kw_only=True)
class Gait:
    """A policy in the loop: an .onnx file, and beside it a declaration of what it is fed."""

    file: str = parameter(unit="file", doc="the network: ./walk.onnx")
    declaration: str = parameter(
        "",
        unit="file",
        doc="what it is fed: ./walk.yaml, a layout's name, or nothing for the file beside it",
    )
    forward_speed: float = parameter(
        0.0, unit="m/s", low=-5.0, high=5.0, doc="commanded, ahead", source="assumption"
    )
    side_speed: float = parameter(
        0.0, unit="m/s", low=-5.0, high=5.0, doc="commanded, to the left", source="assumption"
    )
    turn_speed: float = parameter(
        0.0, unit="rad/s", low=-5.0, high=5.0, doc="commanded, to the left", source="assumption"
    )
    stand_time: float = parameter(
        0.5,
        unit="s",
        low=0.0,
        high=10.0,
        doc="standing in the default pose before it takes over",
        source="assumption",
    )
    start_time: float = parameter(
        0.0,
        unit="s",
        low=0.0,
        high=60.0,
        doc="in which the command grows from nothing, before anything is measured",
        source="assumption",
    )
    period: float = parameter(
        0.0, unit="s", low=0.0, high=10.0, doc="a cycle, two steps; 0: as it is declared"
    )
    delay: float = parameter(
        0.0, unit="s", low=0.0, high=0.5, doc="further delay of targets, beside that declared"
    )
    kp_scale: float = parameter(
        1.0, unit="-", low=0.05, high=20.0, doc="of the declared stiffness of every joint"
    )
    kd_scale: float = parameter(
        1.0, unit="-", low=0.05, high=20.0, doc="of the declared damping of every joint"
    )
    digest: str = parameter(
        "",
        unit="-",
        doc="of the network and what it is fed; filled in",
        contents_of=("file", "declaration"),
    )
    imu: Imu = field(default_factory=Imu)

    def __post_init__(self) -> None:
        if not self.digest:
            object.__setattr__(self, "digest", self._found_digest())

    def _found_digest(self) -> str:
        raw, said = (
            read_network(Path(self.file)),
            load_declaration(self.declaration, Path(self.file)),
        )
        whole = f"{hashlib.sha256(raw).hexdigest()}:{said.digest}"
        return hashlib.sha256(whole.encode()).hexdigest()

    @property
    def _declared(self) -> Declaration:
        return _declaration(self.declaration, self.file, self.digest)

    @property
    def _network(self) -> Network:
        return load_network(Path(self.file))

    @property
    def gait_period(self) -> float:
        """A cycle of two steps, in [s]."""
        return self.period or self._declared.keys.period

    @property
    def step_length(self) -> float:
        """How far a step takes it at the commanded speed, in [m]."""
        return 0.5 * self.forward_speed * self.gait_period

    @property
    def side_step(self) -> float:
        """How far to the left a step takes it, in [m]."""
        return 0.5 * self.side_speed * self.gait_period

    @property
    def turn(self) -> float:
        """How far to the left a step turns it, in [rad]."""
        return 0.5 * self.turn_speed * self.gait_period

    @property
    def hip_height(self) -> float:
        """As it stands in the default pose, which its robot tells: 0, in [m]."""
        return 0.0

    @property
    def startup_time(self) -> float:
        """Until its command is all of it, in [s]."""
        return self.stand_time + self.start_time

    def feet_on(self, robot: Robot, t: np.ndarray) -> FeetPoses:
        """Standing in the default pose, at the instants t, in [s]; no more is known. Shape (n,)."""
        found = self.wiring(robot)
        none = np.zeros(len(t), dtype=int)
        return self._timed(robot, found.standing, none, np.tile(found.pose, (len(t), 1)), t)

    def feet_sent(self, robot: Robot, joints: np.ndarray, t: np.ndarray) -> FeetPoses:
        """Where targets that were sent would put the feet, with the phase of the policy.

        Args:
            robot: The robot.
            joints: Targets of all joints, in [rad]. Shape (n, joints).
            t: When they were sent, in [s]. Shape (n,).
        """
        held = changes(joints)
        return self._timed(robot, feet_of_joints(robot, joints[held.first]), held.of, joints, t)

    def _timed(
        self, robot: Robot, poses: FeetPoses, rows: np.ndarray, joints: np.ndarray, t: np.ndarray
    ) -> FeetPoses:
        """Rows of poses at instants, with the joints and the phase. Shape (n,)."""
        t = np.asarray(t, dtype=float) + ROUNDING
        walked, felt = t - self.startup_time, np.maximum(t - self.stand_time, 0.0)
        begun, rest = walked >= 0.0, np.mod(felt, self.gait_period)
        steps = np.floor(2.0 * np.maximum(walked, 0.0) / self.gait_period)
        return replace(
            FeetPoses(**{name: getattr(poses, name)[rows] for name in SHAPES}),
            phase=np.where(begun, rest / self.gait_period, np.nan),
            step_index=np.where(begun, steps, -1).astype(int),
            joints={joint.name: joints[:, k] for k, joint in enumerate(robot.tree.joints)},
        )

    def wiring(self, robot: Robot) -> Wiring:
        """What goes in and comes out on a robot.

        Raises:
            FileError: Everything in the declaration that the robot lacks.
            WrongValue: If the network is of another size than declared.
        """
        network = self._network
        found = wired(self._declared, robot, network.metadata)
        require_fitting(found, Path(self.file), network.inputs, network.outputs)
        return found

    def servos_of(self, robot: Robot, servos: Sequence[Servo]) -> tuple[Servo, ...]:
        """The robot's servos with the gains that the policy was made for, in the tree's order."""
        gains = self.wiring(robot).gains
        names = [joint.name for joint in robot.tree.joints if joint.servo is not None]
        return tuple(
            driven_by_gains(
                servo, kp=self.kp_scale * gains[name][0], kd=self.kd_scale * gains[name][1]
            )
            if name in gains
            else servo
            for name, servo in zip(names, servos, strict=True)
        )

    def pilot(self, robot: Robot) -> Pilot:
        """The policy, ready to take over.

        Raises:
            WrongValue: If its files are not those that the trial was planned with.
        """
        if self._found_digest() != self.digest:
            raise WrongValue(
                f"{self.file} or what says what it is fed has changed since the trial was planned; "
                "plan the experiment again"
            )
        found = self.wiring(robot)
        return Pilot(
            self._network,
            found,
            [robot.tree.joints[column].name for column in found.columns],
            command=(self.forward_speed, self.side_speed, self.turn_speed),
            ramp=self.start_time,
            period=self.gait_period,
            delay=self.delay + found.delay,
        )

    def require_playable(self, robot: Robot, servos: Sequence[Servo]) -> None:
        """Refuse a robot that it cannot drive, and a network that does not run.

        Raises:
            FileError: Everything in the declaration that the robot lacks.
            WrongValue: If the network is of another size than declared, or gives no numbers.
        """
        pilot = self.pilot(robot)
        rest = self.wiring(robot).pose[pilot.columns]
        try:
            pilot.act(0.0, UPRIGHT, 0.0, rest, np.zeros(len(rest)))
        except WrongValue as error:
            raise WrongValue(f"{self.file}: {error}") from error
        except Exception as error:  # onnxruntime raises classes of its own
            said = str(error).strip().splitlines()[0][:300]
            raise WrongValue(f"{self.file} does not run: {said}") from error
