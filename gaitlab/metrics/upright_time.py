"""How long the robot stayed on its feet, comparable between trials that fell and that did not.

References:
    Royston2013: Royston and Parmar, Restricted mean survival time, BMC Medical Research
        Methodology 13:152, 2013.
"""

from __future__ import annotations

from gaitlab.log import TrialLog

UNIT = "s"
BETTER = "higher"
COUNTS_FALLS = True


def upright_time(log: TrialLog) -> float:
    """Time from the end of the start-up to the fall, at most the horizon's `time`, in [s].

    A robot that did not fall counts as on its feet for the whole of the horizon's `time`, however
    soon its cycles or its distance ended the trial; its mean over trials is the restricted mean
    survival time of [Royston2013]. Zero for a fall in the start-up.
    """
    longest = log.header.horizon_time
    return longest if log.fall_index is None else min(log.walked_time, longest)
