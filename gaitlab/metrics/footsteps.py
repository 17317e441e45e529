"""How many footsteps the robot took."""

from __future__ import annotations

from gaitlab.log import TrialLog

UNIT = "-"


def footsteps(log: TrialLog) -> int:
    """Footsteps completed between the end of the start-up and the fall or the end of the trial.

    Counted by the gait's clock: two a gait period. A foot that never left the ground counts.
    """
    # A trial may end on the last row before a step's end.
    time = log.walked_time + 1.1 * log.header.dt if log.walked_time else 0.0
    return int(2.0 * time / log.header.gait_period)
