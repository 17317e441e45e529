"""Which way the robot fell."""

from __future__ import annotations

import numpy as np

from gaitlab.log import TrialLog
from gaitlab.log.fall import UPRIGHT_LIMIT

UNIT = "-"


def fall_direction(log: TrialLog) -> str | None:
    """`forward`, `backward`, `left` or `right`: where the trunk's upward axis leans at the fall.

    Seen from the heading the trunk had when it was last tilted by less than 45 degrees, because yaw
    flips in a trunk that lies on its face. None without a fall. Defined here.
    """
    if log.fall_index is None:
        return None
    x, y, z, w = log.vector("trunk_q", "xyzw")[: log.fall_index + 1].T
    upright = np.flatnonzero(1.0 - 2.0 * (x**2 + y**2) >= UPRIGHT_LIMIT)
    heading = log["yaw"][upright[-1] if len(upright) else 0]
    lean_x, lean_y = 2.0 * (x * z + w * y)[-1], 2.0 * (y * z - w * x)[-1]
    ahead = lean_x * np.cos(heading) + lean_y * np.sin(heading)
    aside = lean_y * np.cos(heading) - lean_x * np.sin(heading)
    if abs(ahead) >= abs(aside):
        return "forward" if ahead >= 0.0 else "backward"
    return "left" if aside > 0.0 else "right"
