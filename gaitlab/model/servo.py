"""A position servo as a DC motor behind a proportional controller.

References:
    ROBOTIS-eManual: e-Manual of the Dynamixel AX and MX series, ROBOTIS Co., Ltd.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from gaitlab.parameters import Former, parameter

FORMER_TICKS = Former("ticks of 2 ms", 0.002, "seconds")  # what latencies were counted in


@dataclass(frozen=True, kw_only=True)
class Servo:
    """One servo type; the torque-speed line holds at `voltage` and scales with `supply`.

    Duty u = clip(position_gain error / no_load_speed, -1, 1); torque = stall_torque (u - speed /
    no_load_speed), bounded by torque_limit stall_torque.
    """

    stall_torque: float = parameter(
        unit="N m", low=0.01, high=500.0, doc="torque at rest at full voltage"
    )
    no_load_speed: float = parameter(
        unit="rad/s", low=0.1, high=100.0, doc="speed without load at full voltage"
    )
    voltage: float = parameter(
        unit="V", low=1.0, high=60.0, doc="voltage at which the two figures hold"
    )
    supply: float = parameter(
        unit="V", low=1.0, high=60.0, doc="voltage of the battery; scales torque and speed"
    )
    torque_limit: float = parameter(
        unit="-", low=0.05, high=1.0, doc="share of the stall torque that is used"
    )
    position_gain: float = parameter(
        unit="1/s", low=1.0, high=500.0, doc="commanded speed over position error, below full duty"
    )
    latency: float = parameter(
        unit="s",
        low=0.0,
        high=0.2,
        doc="time from a command to its effect",
        former=FORMER_TICKS,
    )
    resolution: float = parameter(
        unit="rad", low=0.0, high=0.1, doc="smallest step of target and encoder"
    )
    backlash: float = parameter(
        unit="rad", low=0.0, high=0.1, doc="play of the gear train, full width"
    )
    mass: float = parameter(unit="kg", low=0.0, high=5.0, doc="mass of the servo, for reference")

    @property
    def largest_torque(self) -> float:
        """At the supply's voltage, in [N m]."""
        return self.torque_limit * self.stall_torque * self.supply / self.voltage

    @property
    def largest_speed(self) -> float:
        """Without load at the supply's voltage, in [rad/s]."""
        return self.no_load_speed * self.supply / self.voltage


def driven_by_gains(servo: Servo, *, kp: float, kd: float) -> Servo:
    """A servo of the same motor under a PD controller: torque = kp error - kd velocity.

    It is as late and as strong, within the same torque. The law of servos has one line of torque
    over speed, so the no-load speed stands as far as kd leaves the motor its torque at rest: with a
    kd below limit over no-load speed, the speed at which the torque ends is limit over kd.

    Args:
        servo: The servo.
        kp: Stiffness, in [N m/rad].
        kd: Damping, in [N m s/rad].
    """
    full, limit = servo.supply / servo.voltage, servo.largest_torque
    speed = max(servo.largest_speed, limit / kd)
    return replace(
        servo,
        position_gain=kp / kd,
        no_load_speed=speed / full,
        stall_torque=kd * speed / full,
        torque_limit=limit / (kd * speed),
    )
