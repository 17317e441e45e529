"""How much the trunk rocks, as a root mean square."""

from __future__ import annotations

from math import nan

import numpy as np

from gaitlab.log import TrialLog

UNIT = "rad"
NEEDS = ("cycle",)
BETTER = "lower"


def pitch_rms(log: TrialLog) -> float:
    """Root mean square of the trunk pitch about its straight-line trend, in [rad].

    Over the cycles of `pitch_amplitude`. The plain RMS: a sine of amplitude A gives A / sqrt(2).
    NaN without a complete cycle. Defined here.
    """
    cycles = log.measured_cycles
    if not cycles:
        return nan
    pitch = log["pitch"][cycles[0].start : cycles[-1].stop]
    rows = np.arange(len(pitch)) - (len(pitch) - 1) / 2.0
    # 0.5 is two rows, one has no trend. Summed by numpy: BLAS may order a dot product as it likes.
    slope = np.sum(rows * pitch) / max(np.sum(rows**2), 0.5)
    return float(np.std(pitch - slope * rows))
