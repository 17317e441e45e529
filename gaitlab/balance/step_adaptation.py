"""Ankle, hip and stepping strategy, and steps shorter and higher while the walk is uneasy.

What the strategies of `gaitlab.model.strategies` do, and beside it two things that people do who
trip: they lift the foot that was caught [Eng1994], and they go more carefully for a while. How
uneasy the walk is

    u = weight of tilt |(e_pitch, e_roll)| + weight of rate |(e'_pitch, e'_roll)| - start

cut to [0, 1], with the filtered errors and rates of the strategies. It rises at once and falls with
a time constant. While it lasts the share `shortening` u of a leg's way ahead is taken back by hip
and ankle of both legs, so that at 1 the robot steps in place. A foot that the gait raises above the
other one is raised more: hip and ankle bend by `lifting` u times its share of the gait's greatest
height, the knee by twice that, which keeps the sole as level as the gait means it.

A robot that steps in place stays up without getting anywhere: the strict score counts that as
failed, and so should whoever chooses gains.

References:
    Eng1994: Eng, Winter and Patla, Strategies for recovery from a trip in early and late swing
        during human walking, Experimental Brain Research 102, 1994.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import exp, hypot

import numpy as np

from gaitlab.model.gait import FeetPoses
from gaitlab.model.imu import Attitude
from gaitlab.model.strategies import JOINTS, AnkleHip, StrategyGains
from gaitlab.parameters import parameter

_OPEN = "assumption: found by a search"
SMALLEST = 1e-6  # m; a foot that is never raised more is never lifted
HIPS, ANKLES = (0, 2), (1, 3)  # of pitch, left and right, in the order of the joints


@dataclass(frozen=True, kw_only=True)
class Balance(StrategyGains):
    """Gains of the strategies; a walk is uneasy from `start` on and wholly so 1 above it."""

    tilt_weight: float = parameter(
        5.0,
        unit="1/rad",
        low=0.0,
        high=100.0,
        doc="of the angle off what the gait means",
        source=_OPEN,
    )
    rate_weight: float = parameter(
        0.5, unit="s/rad", low=0.0, high=20.0, doc="of the rate of that angle", source=_OPEN
    )
    start: float = parameter(
        0.5, unit="-", low=0.0, high=5.0, doc="unease that nothing is done about", source=_OPEN
    )
    calm_time: float = parameter(
        0.5, unit="s", low=0.01, high=10.0, doc="time constant with which it falls", source=_OPEN
    )
    shortening: float = parameter(
        0.5, unit="-", low=0.0, high=1.0, doc="share of the step taken back at most", source=_OPEN
    )
    lifting: float = parameter(
        0.0, unit="rad", low=0.0, high=0.6, doc="a raised leg bends more at most", source=_OPEN
    )

    joints = (*JOINTS, "left_knee", "right_knee")

    def controller(self, feet: FeetPoses, dt: float) -> StepAdaptation:
        """The controller of one walk over the instants of `feet`, dt apart in [s]."""
        return StepAdaptation(self, feet, dt)


class StepAdaptation(AnkleHip):
    """The controller at work: the strategies, and how uneasy the walk is."""

    def __init__(self, gains: Balance, feet: FeetPoses, dt: float) -> None:
        """A controller of a walk that is at ease; see `Balance.controller`."""
        super().__init__(gains, feet, dt)
        self._gains = gains
        self._keeps = exp(-gains.imu.spacing(dt) / gains.calm_time)
        ahead = feet.position[:, :, 0] - feet.position[0, :, 0]
        height = feet.position[:, :, 2]
        self._leg = np.arctan2(ahead, -height).tolist()
        raised = height - height.min(axis=1, keepdims=True)
        self._raised = (raised / max(raised.max(), SMALLEST)).tolist()
        self._uneasy = 0.0

    def correction(self, tick: int, felt: Attitude) -> Sequence[float]:
        """Corrections in the order of `Balance.joints`, in [rad]."""
        turns = list(super().correction(tick, felt))
        uneasy = self._unease()
        knees = []
        for leg, (hip, ankle) in enumerate(zip(HIPS, ANKLES, strict=True)):
            back = self._gains.shortening * uneasy * self._leg[tick][leg]
            bend = self._gains.lifting * uneasy * self._raised[tick][leg]
            turns[hip] += back - bend
            turns[ankle] -= back + bend
            knees.append(2.0 * bend)
        return [*turns, *knees]

    def _unease(self) -> float:
        """How uneasy the walk is in [0, 1], from the errors that were smoothed last."""
        gains, error = self._gains, self._error
        assert error is not None
        now = (
            gains.tilt_weight * hypot(error.pitch, error.roll)
            + gains.rate_weight * hypot(error.pitch_rate, error.roll_rate)
            - gains.start
        )
        self._uneasy = min(1.0, max(now, self._keeps * self._uneasy, 0.0))
        return self._uneasy
