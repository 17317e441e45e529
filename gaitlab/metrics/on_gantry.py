"""Whether the robot was held up by something other than its legs."""

from __future__ import annotations

from gaitlab.log import TrialLog
from gaitlab.model import GANTRY_PITCH

UNIT = "-"


def on_gantry(log: TrialLog) -> bool:
    """Whether the robot hung on a gantry, so that staying up says nothing of its balance.

    Which motions the gantry holds is the robot's parameter `gantry`. Defined here.
    """
    return GANTRY_PITCH in log.header.joints
