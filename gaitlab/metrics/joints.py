"""What servos, couplings and a gantry have to hold."""

from __future__ import annotations

from math import nan, sqrt

import numpy as np

from gaitlab.log import TrialLog
from gaitlab.metrics.metric import metric
from gaitlab.model import GANTRY_PITCH

NEAR_LIMIT = 0.98  # of the limit; what quantised targets and float32 leave of it


@metric(unit="N m", better="lower")
def peak_torque(log: TrialLog) -> float:
    """Largest torque of any servo, either way, in [N m].

    Over the walk before a fall. NaN when nothing was walked. Defined here.
    """
    torque = np.abs(log.driven_table("torque")[log.walking])
    return float(torque.max()) if torque.size else nan


@metric(unit="N m", better="lower")
def rms_torque(log: TrialLog) -> float:
    """Root mean square of the torque over all joints and ticks, in [N m]; what heats the motors.

    Over the walk before a fall. NaN when nothing was walked. Defined here.
    """
    torque = log.driven_table("torque")[log.walking]
    return float(np.sqrt(np.mean(torque**2))) if torque.size else nan


@metric(unit="-", better="lower")
def saturation_share(log: TrialLog) -> float:
    """Share of joints and ticks in which the torque reaches its limit.

    Over the walk before a fall. NaN when nothing was walked. Defined here.
    """
    torque = np.abs(log.driven_table("torque")[log.walking])
    limits = np.array([limit for limit in log.header.torque_limits if limit > 0.0])
    reached = torque >= NEAR_LIMIT * limits
    return float(np.mean(reached)) if reached.size else nan


@metric(unit="rad", better="lower")
def tracking_error(log: TrialLog) -> float:
    """Root mean square of target less position over all joints with a servo, in [rad].

    The target is what was sent, so the servo's lag and latency count as much as the load does. Over
    the walk before a fall. NaN when nothing was walked. Defined here.
    """
    errors = (log.driven_table("target") - log.driven_table("position"))[log.walking]
    return sqrt(float(np.mean(errors**2))) if errors.size else nan


@metric(unit="rad", needs=("couplings",))
def coupling_residual(log: TrialLog) -> float:
    """Largest angle between a coupled joint and where its leader turns it, in [rad].

    A figure of the simulation, not of the robot: belts are rigid. Over the walk before a fall. NaN
    for a robot without couplings or when nothing was walked. Defined here.
    """
    limits = dict(zip(log.header.joints, log.header.torque_limits, strict=True))
    coupled = [name for name, limit in limits.items() if limit == 0.0 and name != GANTRY_PITCH]
    errors = [(log[f"{j}_position"] - log[f"{j}_target"])[log.walking] for j in coupled]
    return float(np.abs(errors).max()) if errors and errors[0].size else nan


@metric(unit="-")
def on_gantry(log: TrialLog) -> bool:
    """Whether the robot hung on a gantry, so that staying up says nothing of its balance.

    Which motions the gantry holds is the robot's parameter `gantry`. Defined here.
    """
    return GANTRY_PITCH in log.header.joints


@metric(unit="N m", better="lower", needs=("gantry",))
def peak_balancing_moment(log: TrialLog) -> float:
    """Largest pitching moment of the gantry, either way, in [N m].

    What a balancing mechanism would have to supply in its place, impacts included. Over the walk
    before a fall. NaN for a robot on its own or when nothing was walked. Defined here.
    """
    if GANTRY_PITCH not in log.header.joints:
        return nan
    moment = log[f"{GANTRY_PITCH}_torque"][log.walking]
    return float(np.abs(moment).max()) if moment.size else nan


@metric(unit="N m", better="lower", needs=("gantry",))
def rms_balancing_moment(log: TrialLog) -> float:
    """Root mean square of the pitching moment of the gantry, in [N m].

    What a balancing mechanism would have to supply in its place. Over the walk before a fall. NaN
    for a robot on its own or when nothing was walked. Defined here.
    """
    if GANTRY_PITCH not in log.header.joints:
        return nan
    moment = log[f"{GANTRY_PITCH}_torque"][log.walking]
    return float(np.sqrt(np.mean(moment**2))) if moment.size else nan
