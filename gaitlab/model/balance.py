"""What a balance controller says: by how much joints leave the gait, from what the IMU tells."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from gaitlab.errors import WrongValue
from gaitlab.model import Robot
from gaitlab.model.gait import FeetPoses
from gaitlab.model.imu import Attitude, Imu


class Controller(Protocol):
    """A balance controller at work on one walk; it may remember what it was told."""

    def correction(self, tick: int, felt: Attitude) -> Sequence[float]:
        """What is added to the joint targets from this tick until the next reading.

        Args:
            tick: Index of the tick; the instants of the feet that it was made for.
            felt: The reading of the IMU that has just arrived.

        Returns:
            In the order of the controller's `joints`, in [rad]. What leads beyond a joint limit is
            cut there.
        """


class Balance(Protocol):
    """A balance controller: a frozen dataclass `Balance` in a file of its own in `gaitlab/balance`.

    It is a set of gains. What it needs while a robot walks is made by `controller`, anew for each
    trial.
    """

    @property
    def imu(self) -> Imu:
        """The IMU that it is told by."""

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the joints that it corrects; a robot without one of them cannot use it."""

    def controller(self, feet: FeetPoses, dt: float) -> Controller:
        """The controller of one walk.

        Args:
            feet: What the gait means, at every tick.
            dt: Time between two ticks, in [s]. Readings come in ticks that are
                `imu.due(tick, dt)`, `imu.spacing(dt)` apart on average.
        """


def require_joints(balance: Balance, robot: Robot) -> None:
    """Refuse a robot that lacks a joint to balance with.

    Raises:
        WrongValue: Names the joints that are missing or have no servo.
    """
    driven = {joint.name for joint in robot.tree.joints if joint.servo is not None}
    lacking = [name for name in balance.joints if name not in driven]
    if lacking:
        raise WrongValue(
            f"the balance controller moves {', '.join(lacking)}, for which the robot "
            f"{robot.name!r} has no servo; leave `balance:` out or take a robot with these joints"
        )
