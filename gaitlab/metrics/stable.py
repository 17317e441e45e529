"""Whether the robot stayed on its feet.

References:
    EROS2018: Pristovani et al., Walking Trajectory Optimization Algorithm for Robot Humanoid on
        Synthetic Grass, EMITTER Int. J. of Engineering Technology, 2018.
"""

from __future__ import annotations

from gaitlab.log import TrialLog

UNIT = "-"
BETTER = "higher"


def stable(log: TrialLog) -> bool:
    """Whether the robot did not fall within the horizon, the literal score of [EROS2018].

    The rule is that of `gaitlab.log.fall`. A robot that marks time counts as stable, see
    `stable_strict`.
    """
    return log.fall_index is None
