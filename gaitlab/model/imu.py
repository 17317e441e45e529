"""What a robot's IMU tells of its trunk: pitch, roll and their rates, sampled, late and noisy.

Roll and pitch are those of a complementary filter and the rates those of a gyroscope, each true but
for noise and for a bias that a replicate keeps. That shocks of walking disturb the filter is not
modelled.

References:
    InvenSense2013: InvenSense, MPU-6000 and MPU-6050 Product Specification, revision 3.4, 2013,
        section 6.1, and Register Map and Descriptions, revision 4.2, register 26.
    Madgwick2011: Madgwick, Harrison and Vaidyanathan, Estimation of IMU and MARG orientation using
        a gradient descent algorithm, IEEE International Conference on Rehabilitation Robotics,
        2011.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from math import atan2, ceil, floor, hypot, radians
from typing import NamedTuple, TypeAlias

import numpy as np

from gaitlab.parameters import parameter

ROUNDING = 1e-6  # periods; forgives 0.01 / 0.002 being no whole number to the last bit

Quaternion: TypeAlias = tuple[float, float, float, float]
Vector: TypeAlias = tuple[float, float, float]


class Attitude(NamedTuple):
    """How a trunk is tilted and how it turns.

    Attributes:
        pitch: Positive leans forward, in [rad].
        roll: Positive leans right, in [rad].
        pitch_rate: Angular velocity about the trunk's lateral axis, in [rad/s].
        roll_rate: Angular velocity about the trunk's forward axis, in [rad/s].
    """

    pitch: float
    roll: float
    pitch_rate: float
    roll_rate: float


@dataclass(frozen=True, kw_only=True)
class Imu:
    """How good an IMU is; by default a cheap one of a gyroscope and an accelerometer."""

    period: float = parameter(
        0.01,
        unit="s",
        low=1e-4,
        high=0.2,
        doc="between two readings, on average; each comes with the next tick",
        source="assumption: the control period of EROS, an assumption itself",
    )
    delay: float = parameter(
        0.004,
        unit="s",
        low=0.0,
        high=0.2,
        doc="age of a reading when it is used, rounded to ticks",
        source="assumption: 2.8 ms of the gyroscope's filter at 98 Hz [InvenSense2013] and a bus",
    )
    rate_noise: float = parameter(
        radians(0.05),
        unit="rad/s",
        low=0.0,
        high=1.0,
        doc="standard deviation of a rate from one reading to the next",
        source="published: 0.05 degrees/s RMS, MPU-6050 [InvenSense2013]",
    )
    rate_bias: float = parameter(
        radians(0.2),
        unit="rad/s",
        low=0.0,
        high=1.0,
        doc="standard deviation between replicates of what a resting gyroscope says",
        source="assumption: up to 20 degrees/s [InvenSense2013], zeroing at rest leaves 1 %",
    )
    attitude_noise: float = parameter(
        radians(0.1),
        unit="rad",
        low=0.0,
        high=0.5,
        doc="standard deviation of pitch and of roll from one reading to the next",
        source="assumption",
    )
    attitude_bias: float = parameter(
        radians(0.8),
        unit="rad",
        low=0.0,
        high=0.5,
        doc="standard deviation between replicates of a constant error of pitch and of roll",
        source="published: below 0.8 degrees RMS at rest [Madgwick2011], all of it taken as bias",
    )

    def due(self, tick: int, dt: float) -> bool:
        """Whether a reading arrives in this tick of dt, in [s]: the first since another period."""
        return tick == 0 or self._periods(tick, dt) > self._periods(tick - 1, dt)

    def latest(self, tick: int, dt: float) -> int:
        """The tick, this one or before, in which the latest reading arrived."""
        return min(tick, ceil(self._periods(tick, dt) * self.period / dt - ROUNDING))

    def _periods(self, tick: int, dt: float) -> int:
        return floor(tick * dt / self.period + ROUNDING)

    def spacing(self, dt: float) -> float:
        """Mean time from one reading to the next in ticks of dt, in [s]; no less than a tick."""
        return max(self.period, dt)


class Readings:
    """An IMU at work on one trunk."""

    def __init__(
        self, imu: Imu, dt: float, rng: np.random.Generator, level: Quaternion | None = None
    ) -> None:
        """An IMU that has seen nothing yet.

        Args:
            imu: How good it is.
            dt: Time between two states that it sees, in [s].
            rng: The replicate's stream for bias and noise.
            level: From the world to a frame whose z is against gravity, xyzw; None where they are
                the same.
        """
        self._rng = rng
        self._seen: deque[tuple[Quaternion, Vector]] = deque(maxlen=round(imu.delay / dt) + 1)
        self._noise = np.array([imu.attitude_noise] * 2 + [imu.rate_noise] * 2)
        self._bias = rng.standard_normal(4) * ([imu.attitude_bias] * 2 + [imu.rate_bias] * 2)
        self._imu, self._level = imu, level
        self._yaw_bias: float | None = None

    def see(self, quaternion: Quaternion, spin: Vector) -> None:
        """Take in the trunk's orientation, xyzw, and angular velocity, world frame, in [rad/s]."""
        self._seen.append((quaternion, spin))

    def read(self) -> Attitude:
        """The latest reading that has arrived; the oldest state there is until one has."""
        return self.told(*self._seen[0])

    def told(self, quaternion: Quaternion, spin: Vector) -> Attitude:
        """What it says of a state; arguments as of `see`."""
        if self._level is not None:
            quaternion, spin = _product(self._level, quaternion), _turned(self._level, spin)
        error = (self._bias + self._noise * self._rng.standard_normal(4)).tolist()
        return Attitude(*map(float.__add__, attitude(quaternion, spin), error))

    def turning(self, quaternion: Quaternion, spin: Vector) -> float:
        """What it says of the yaw rate, about the trunk's upward axis, in [rad/s]; as `told`.

        Who never asks draws nothing for it.
        """
        if self._yaw_bias is None:
            self._yaw_bias = self._imu.rate_bias * float(self._rng.standard_normal())
        x, y, z, w = quaternion
        up = (2.0 * (x * z + y * w), 2.0 * (y * z - x * w), 1.0 - 2.0 * (x * x + y * y))
        rate = up[0] * spin[0] + up[1] * spin[1] + up[2] * spin[2]
        noise = self._imu.rate_noise * float(self._rng.standard_normal())
        return rate + self._yaw_bias + noise


def _product(a: Quaternion, b: Quaternion) -> Quaternion:
    """The turn b, then a; xyzw."""
    (ax, ay, az, aw), (bx, by, bz, bw) = a, b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )


def _turned(turn: Quaternion, vector: Vector) -> Vector:
    x, y, z, w = turn
    found = _product(_product(turn, (*vector, 0.0)), (-x, -y, -z, w))
    return found[:3]


def attitude(quaternion: Quaternion, spin: Vector) -> Attitude:
    """True attitude of a trunk.

    Args:
        quaternion: Orientation of the trunk, xyzw.
        spin: Its angular velocity, world frame, in [rad/s].
    """
    x, y, z, w = quaternion
    r00, r10 = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + z * w)
    r01, r11 = 2.0 * (x * y - z * w), 1.0 - 2.0 * (x * x + z * z)
    r20, r21, r22 = 2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)
    return Attitude(
        pitch=atan2(-r20, hypot(r00, r10)),
        roll=atan2(r21, r22),
        pitch_rate=r01 * spin[0] + r11 * spin[1] + r21 * spin[2],
        roll_rate=r00 * spin[0] + r10 * spin[1] + r20 * spin[2],
    )
