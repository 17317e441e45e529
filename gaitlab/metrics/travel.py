"""How far, how fast and how straight the robot walked.

References:
    EROS2018: Pristovani et al., Walking Trajectory Optimization Algorithm for Robot Humanoid on
        Synthetic Grass, EMITTER Int. J. of Engineering Technology, 2018.
"""

from __future__ import annotations

from math import nan

import numpy as np

from gaitlab.log import TrialLog
from gaitlab.metrics.metric import metric

LONGEST = 6.0  # m, length of a run in [EROS2018]


@metric(unit="m", better="higher", counts_falls=True)
def distance(log: TrialLog) -> float:
    """How far the trunk came from the end of the start-up to the fall or the end, in [m].

    Measured along the commanded way, a straight line or an arc from where the trunk is at the end
    of the start-up; so a robot that walks backwards or sideways as commanded scores positive.
    Toppling moves the trunk, too, and counts until the fall is established. NaN when nothing was
    walked. Defined here.
    """
    return log.distance


@metric(unit="m", better="higher", counts_falls=True)
def distance_before_fall(log: TrialLog) -> float:
    """Largest distance reached before the fall or the end, clipped to [0, 6] m, in [m].

    Six metres is the run of [EROS2018]. Zero for a fall in the start-up; NaN when the trial ended
    in the start-up without a fall.
    """
    walked = log.displacement[log.walking, 0]
    if not len(walked):
        return nan if log.fall_index is None else 0.0
    return float(np.clip(walked.max(), 0.0, LONGEST))


@metric(unit="s", better="higher", counts_falls=True)
def walked_time(log: TrialLog) -> float:
    """Time from the end of the start-up to the fall or the end of the trial, in [s].

    Zero for a trial that ended in the start-up.
    """
    return log.walked_time


@metric(unit="m/s", better="higher")
def walking_speed(log: TrialLog) -> float:
    """Distance over walked time, in [m/s]; positive in the commanded direction.

    NaN when nothing was walked. Defined here.
    """
    return log.distance / log.walked_time if log.walked_time else nan


@metric(unit="-", better="higher", needs=("distance",))
def slip_ratio(log: TrialLog) -> float:
    """Distance over the distance commanded in the walked time: 1 without slip, 0 for marking time.

    Negative when the robot went the wrong way. NaN when no distance is commanded or nothing was
    walked. Defined here.
    """
    return log.distance / log.commanded_distance if log.commanded_distance else nan


@metric(unit="-")
def footsteps(log: TrialLog) -> int:
    """Footsteps completed between the end of the start-up and the fall or the end of the trial.

    Counted by the gait's clock: two a gait period. A foot that never left the ground counts.
    """
    # A trial may end on the last row before a step's end.
    time = log.walked_time + 1.1 * log.header.dt if log.walked_time else 0.0
    return int(2.0 * time / log.header.gait_period)


@metric(unit="rad")
def heading_drift(log: TrialLog) -> float:
    """Change of the trunk's yaw over the walk, whole turns included, in [rad]; left is positive.

    The end is the last tick before a fall. NaN when nothing was walked. Defined here.
    """
    yaw = np.unwrap(log["yaw"][log.walking])
    return float(yaw[-1] - yaw[0]) if len(yaw) else nan


@metric(unit="rad")
def heading_error(log: TrialLog) -> float:
    """Change of the trunk's yaw over the walk less what was commanded, in [rad]; left is positive.

    As `heading_drift`, which it is for a walk that is not to turn. NaN when nothing was walked.
    Defined here.
    """
    yaw = np.unwrap(log["yaw"][log.walking])
    commanded = log.header.course.rate * log.walked_time
    return float(yaw[-1] - yaw[0]) - commanded if len(yaw) else nan


@metric(unit="m")
def lateral_drift(log: TrialLog) -> float:
    """Trunk position across the commanded way at the end, in [m]; left is positive.

    The way begins along the heading at the end of the start-up; the end is the last tick before a
    fall. NaN when nothing was walked. Defined here.
    """
    across = log.displacement[log.walking, 1]
    return float(across[-1]) if len(across) else nan
