"""Whether the rocking was measured over steady cycles."""

from __future__ import annotations

from gaitlab.log import TrialLog

UNIT = "-"


def pitch_settled(log: TrialLog) -> bool:
    """Whether `pitch_amplitude` and its like rest on two steady cycles or more.

    Otherwise they use whatever complete cycles there are, those of the first swing-in and the last
    before a fall included, and compare badly with others.
    """
    return len(log.steady_cycles) >= 2
