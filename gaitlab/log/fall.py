"""When a robot has fallen: the numbers of the one rule, `gaitlab.simulation.ending.ended`.

A robot has fallen when its trunk was tilted beyond 45 degrees for 0.1 s, when a link other than a
foot lay on the ground for 0.05 s, or when the trunk is below 0.6 of its standing height. The
numbers are gaitlab's own and told from the ground, also where that slopes: who stands at a right
angle to it has not fallen. [EROS2018] calls a walk unstable when the robot falls and does not say
when that is.

References:
    EROS2018: Pristovani et al., Walking Trajectory Optimization Algorithm for Robot Humanoid on
        Synthetic Grass, EMITTER Int. J. of Engineering Technology, 2018.
"""

from __future__ import annotations

from math import cos, radians
from typing import Final

UPRIGHT_LIMIT: Final = cos(radians(45.0))  # -, R33 below it is a tilt no open-loop walk leaves
TILT_TIME: Final = 0.1  # s, longer than the rocking of a heel strike
BODY_CONTACT_TIME: Final = 0.05  # s, longer than a hand or a knee that brushes the ground
HEIGHT_RATIO: Final = 0.6  # of standing height; legs that gave way, far below a walking squat

CAUSES: Final = ("none", "tilt", "body_contact", "low_trunk")  # by the log's code
TILT, BODY_CONTACT, LOW_TRUNK = 1, 2, 3
