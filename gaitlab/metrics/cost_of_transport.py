"""What a metre costs, whatever the robot weighs."""

from __future__ import annotations

from math import nan

from gaitlab.log import TrialLog

UNIT = "-"
NEEDS = ("distance",)
BETTER = "lower"


def cost_of_transport(log: TrialLog) -> float:
    """Positive mechanical work of the servos over weight times distance, E / (m g d).

    The work is that of `energy`, without the heat of the motors. NaN when no distance is commanded
    or the robot did not get ahead. Defined here.
    """
    if not log.commanded_distance or not log.distance > 0.0:
        return nan
    return log.work / (log.header.weight * log.distance)
