"""Which part of the fall rule the robot broke."""

from __future__ import annotations

from gaitlab.log import TrialLog
from gaitlab.log.fall import CAUSES

UNIT = "-"


def fall_cause(log: TrialLog) -> str | None:
    """`tilt`, `body_contact` or `low_trunk`: the part of the fall rule that came true first.

    The rule is that of `gaitlab.log.fall`. None without a fall.
    """
    return None if log.fall_index is None else CAUSES[int(log["fall_cause"][log.fall_index])]
