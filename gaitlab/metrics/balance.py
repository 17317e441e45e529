"""How much the trunk rocks, and how far the ZMP and the load are from the edges.

References:
    EROS2018: Pristovani et al., Walking Trajectory Optimization Algorithm for Robot Humanoid on
        Synthetic Grass, EMITTER Int. J. of Engineering Technology, 2018.
"""

from __future__ import annotations

from math import nan

import numpy as np

from gaitlab.kinematics.fsr import crossings, fluctuation
from gaitlab.log import TrialLog
from gaitlab.log.sensing import exchanges, load_index_signal, normalised_zmp_signal
from gaitlab.metrics.metric import metric

EDGE = 0.001  # m, closer is on the edge, which rounded supports blur by as much
ROUNDING = 1e-6  # one foot in the air gives 1, up to the digits of the log


@metric(unit="rad", better="lower", needs=("cycle",))
def pitch_amplitude(log: TrialLog) -> float:
    """Mean over gait cycles of half the range of the trunk pitch, in [rad]; a mean lean cancels.

    The cycles are the steady ones: from the third on and, before a fall, those that end a period
    ahead of it, so that the fall itself is not measured. With fewer than two of them the first two
    count as well, with none the last before a fall; then `pitch_settled` is False. NaN without a
    complete cycle. Meant to be the pitch vibration of [EROS2018], which leaves it undefined.
    """
    pitch = log["pitch"]
    ranges = [np.ptp(pitch[cycle]) for cycle in log.measured_cycles]
    return float(np.mean(ranges)) / 2.0 if ranges else nan


@metric(unit="rad", better="lower", needs=("cycle",))
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


@metric(unit="-")
def pitch_cycles(log: TrialLog) -> int:
    """Gait cycles that `pitch_amplitude`, `roll_amplitude` and `pitch_rms` use."""
    return len(log.measured_cycles)


@metric(unit="-")
def pitch_settled(log: TrialLog) -> bool:
    """Whether `pitch_amplitude` and its like rest on two steady cycles or more.

    Otherwise they use whatever complete cycles there are, those of the first swing-in and the last
    before a fall included, and compare badly with others.
    """
    return len(log.steady_cycles) >= 2


@metric(unit="rad", better="lower", needs=("cycle",))
def roll_amplitude(log: TrialLog) -> float:
    """Mean over gait cycles of half the range of the trunk roll, in [rad]; a mean lean cancels.

    The cycles are the steady ones: from the third on and, before a fall, those that end a period
    ahead of it, so that the fall itself is not measured. With fewer than two of them the first two
    count as well, with none the last before a fall; then `pitch_settled` is False. NaN without a
    complete cycle. Companion of `pitch_amplitude`.
    """
    roll = log["roll"]
    ranges = [np.ptp(roll[cycle]) for cycle in log.measured_cycles]
    return float(np.mean(ranges)) / 2.0 if ranges else nan


@metric(unit="m", better="higher")
def zmp_margin_min(log: TrialLog) -> float:
    """Smallest margin of the ZMP to the edge of the support polygon, in [m]; positive inside.

    Over the walk before a fall; ticks in flight do not count. NaN without any tick on the ground.
    Defined here.
    """
    margin = log["zmp_margin"][log.walking]
    margin = margin[np.isfinite(margin)]
    return float(margin.min()) if len(margin) else nan


@metric(unit="m", better="higher")
def zmp_margin_p5(log: TrialLog) -> float:
    """5th percentile of the margin of the ZMP to the edge of the support polygon, in [m].

    Over the walk before a fall; ticks in flight do not count. NaN without any tick on the ground.
    Defined here.
    """
    margin = log["zmp_margin"][log.walking]
    margin = margin[np.isfinite(margin)]
    return float(np.percentile(margin, 5.0)) if len(margin) else nan


@metric(unit="-", better="higher")
def zmp_inside_share(log: TrialLog) -> float:
    """Share of the ticks with a foot on the ground in which the ZMP lies clear of every edge.

    Forces that only push cannot bring the ZMP out of the polygon: a robot that rocks over an edge
    has its ZMP on it. Over the walk before a fall; ticks in flight do not count. NaN without any
    tick on the ground. Defined here.
    """
    margin = log["zmp_margin"][log.walking]
    margin = margin[np.isfinite(margin)]
    return float(np.mean(margin > EDGE)) if len(margin) else nan


@metric(unit="-", better="lower", needs=("cycle",))
def load_index_crossings(log: TrialLog) -> float:
    """Sign changes of the load index an exchange of support, less one: 0 if each is a clean one.

    The load index is (left - right) / (left + right) of the vertical forces on the feet, each
    averaged over 10 ms as sensors are read. From the first mid-step to the last of the cycles that
    `roll_amplitude` uses; NaN without any. Defined here.
    """
    rows, count = exchanges(log)
    return crossings(load_index_signal(log, rows)) / count - 1.0 if count else nan


@metric(unit="-", better="lower", needs=("cycle",))
def load_index_fluctuation(log: TrialLog) -> float:
    """Total variation of the load index over twice the exchanges of support, less one.

    The load index is (left - right) / (left + right) of the vertical forces on the feet, each
    averaged over 10 ms as sensors are read. 0 if every exchange carries all load from one foot to
    the other once; a load that goes half over, back and over again counts 0.5. From the first
    mid-step to the last of the cycles that `roll_amplitude` uses; NaN without any. Defined here.
    """
    rows, count = exchanges(log)
    return fluctuation(load_index_signal(log, rows), count) if count else nan


@metric(unit="-", better="lower", needs=("force sensors", "cycle"))
def zmp_normalised_fluctuation(log: TrialLog) -> float:
    """Total variation of the normalised x of the ZMP over twice the exchanges, less one.

    The index is that of Shaari et al., as printed, from sensors averaged over 10 ms; its values
    beyond [-1, 1], which come from a division by almost nothing, count as they are. From the first
    mid-step to the last of the cycles that `roll_amplitude` uses; NaN without sensors or without
    a cycle. The measure of fluctuation is defined here.
    """
    rows, count = exchanges(log)
    if not count or log.header.sensors is None:
        return nan
    return fluctuation(normalised_zmp_signal(log, rows)[:, 0], count)


@metric(unit="-", better="lower", needs=("force sensors",))
def zmp_normalised_outside(log: TrialLog) -> float:
    """Share of the readings at which the normalised x of the ZMP leaves [-1, 1].

    The index is that of Shaari et al., (left - right) / (left + right) of what the force sensors
    of the two feet give, as printed; they call a robot stable inside. Sensors are averaged over
    10 ms. Over the walk before a fall; readings at which the index is not defined do not count.
    NaN without sensors or without a walk.
    """
    x = normalised_zmp_signal(log, log.walking)[:, 0]
    x = x[np.isfinite(x)]
    return float(np.mean(np.abs(x) > 1.0 + ROUNDING)) if len(x) else nan
