"""Whether and when the robot fell, and whether it went where it was told.

References:
    EROS2018: Pristovani et al., Walking Trajectory Optimization Algorithm for Robot Humanoid on
        Synthetic Grass, EMITTER Int. J. of Engineering Technology, 2018.
    Royston2013: Royston and Parmar, Restricted mean survival time, BMC Medical Research
        Methodology 13:152, 2013.
"""

from __future__ import annotations

from math import nan

import numpy as np

from gaitlab.log import TrialLog
from gaitlab.log.fall import CAUSES, UPRIGHT_LIMIT
from gaitlab.metrics.metric import metric


@metric(unit="-", better="higher")
def stable(log: TrialLog) -> bool:
    """Whether the robot did not fall within the horizon, the literal score of [EROS2018].

    The rule is that of `gaitlab.log.fall`. A robot that marks time counts as stable, see
    `stable_strict`.
    """
    return log.fall_index is None


@metric(unit="-", better="higher")
def stable_strict(log: TrialLog) -> bool:
    """Whether the robot neither fell nor stalled.

    A robot that is told to step on the spot only has to stay up. Defined here.
    """
    return log.fall_index is None and not log.stalled


@metric(unit="-", better="lower")
def stalled(log: TrialLog) -> bool:
    """Whether the robot did not fall but covered less than half of the commanded distance.

    Never when no distance is commanded. Defined here.
    """
    return log.stalled


@metric(unit="-", better="lower")
def fell(log: TrialLog) -> bool:
    """Whether the robot fell within the horizon, in the start-up or later.

    The rule is that of `gaitlab.log.fall`.
    """
    return log.fall_index is not None


@metric(unit="-", better="lower")
def fell_standing(log: TrialLog) -> bool:
    """Whether the robot fell before its first commanded step, so that no walk was tried.

    The step begins as the gait first means a foot to be in the air; a motion that never does begins
    with its first movement, and who only stands has every fall counted here. Never in a log that
    does not know the instant. Defined here.
    """
    return log.fell_standing


@metric(unit="s", better="higher", counts_falls=True)
def time_to_fall(log: TrialLog) -> float:
    """Time from the end of the start-up to the fall, in [s]; negative for a fall in the start-up.

    The fall is the tick that establishes it. NaN without a fall. Defined here.
    """
    if log.fall_index is None:
        return nan
    return float(log["time"][log.fall_index]) - log.header.startup_time


@metric(unit="s", better="higher", counts_falls=True)
def upright_time(log: TrialLog) -> float:
    """Time from the end of the start-up to the fall, at most the horizon's `time`, in [s].

    A robot that did not fall counts as on its feet for the whole of the horizon's `time`, however
    soon its cycles or its distance ended the trial; its mean over trials is the restricted mean
    survival time of [Royston2013]. Zero for a fall in the start-up.
    """
    longest = log.header.horizon_time
    return longest if log.fall_index is None else min(log.walked_time, longest)


@metric(unit="-")
def fall_cause(log: TrialLog) -> str | None:
    """`tilt`, `body_contact` or `low_trunk`: the part of the fall rule that came true first.

    The rule is that of `gaitlab.log.fall`. None without a fall.
    """
    return None if log.fall_index is None else CAUSES[int(log["fall_cause"][log.fall_index])]


@metric(unit="-")
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


@metric(unit="-")
def fall_phase(log: TrialLog) -> float:
    """Gait phase in [0, 1) at the tick that establishes the fall.

    NaN without a fall and for a fall in the start-up, which has no phase. Defined here.
    """
    return nan if log.fall_index is None else float(log["gait_phase"][log.fall_index])
