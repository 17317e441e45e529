"""Ankle, hip and stepping strategy from the trunk's pitch and roll and their rates.

For each of the two axes the error e is the felt angle less the one that the gait means, e' is the
felt rate, both behind a low-pass filter. A strategy turns a joint by gain e + damping e', within a
limit:

    stance ankle = ankle                       presses the sole's edge on the side of the fall
    stance hip   = hip                         turns the trunk back over the leg
    swing hip    = -step                       swings the foot to where the robot falls
    swing ankle  = -swing_level (e + swing hip)      keeps the sole as level as the gait means it

The three strategies are those of people who are pushed [Horak1986]. Small robots know them too: the
walk of [DARwIn-OP] turns hip roll, knees and both ankle joints in proportion to the rates of a
gyroscope. Angles, the weighting by the gait's clock and the swing foot are our own. A gain of zero
switches a strategy off.

A robot without sensors in its feet knows them to be on the ground only by its gait. So each leg is
weighted by the share of time around an instant in which the gait means it to stand.

References:
    Horak1986: Horak and Nashner, Central programming of postural movements: adaptation to altered
        support-surface configurations, Journal of Neurophysiology 55(6), 1986.
    DARwIn-OP: ROBOTIS, DARwIn-OP Framework, Walking.cpp, the part headed "adjust balance offset".
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from math import exp
from typing import NamedTuple

import numpy as np

from gaitlab.model.gait import FeetPoses
from gaitlab.model.imu import Attitude, Imu
from gaitlab.parameters import parameter

_TRIED = "assumption: tried by hand on 30 and 50 mm of grass"
_OFF = "assumption: off"
JOINTS = tuple(
    f"{side}_{joint}_{axis}"
    for axis in ("pitch", "roll")
    for side in ("left", "right")
    for joint in ("hip", "ankle")
)


@dataclass(frozen=True, kw_only=True)
class StrategyGains:
    """Gains of three strategies in pitch and roll; positive ones act against a fall."""

    ankle_pitch_gain: float = parameter(
        0.5, unit="-", low=-3.0, high=3.0, doc="stance ankle pitch per lean", source=_TRIED
    )
    ankle_pitch_damping: float = parameter(
        0.05, unit="s", low=-0.5, high=0.5, doc="stance ankle pitch per rate", source=_TRIED
    )
    ankle_roll_gain: float = parameter(
        0.5, unit="-", low=-3.0, high=3.0, doc="stance ankle roll per lean", source=_TRIED
    )
    ankle_roll_damping: float = parameter(
        0.05, unit="s", low=-0.5, high=0.5, doc="stance ankle roll per rate", source=_TRIED
    )
    hip_pitch_gain: float = parameter(
        0.0, unit="-", low=-3.0, high=3.0, doc="stance hip pitch per lean", source=_OFF
    )
    hip_pitch_damping: float = parameter(
        0.0, unit="s", low=-0.5, high=0.5, doc="stance hip pitch per rate", source=_OFF
    )
    hip_roll_gain: float = parameter(
        0.0, unit="-", low=-3.0, high=3.0, doc="stance hip roll per lean", source=_OFF
    )
    hip_roll_damping: float = parameter(
        0.0, unit="s", low=-0.5, high=0.5, doc="stance hip roll per rate", source=_OFF
    )
    step_pitch_gain: float = parameter(
        0.0, unit="-", low=-3.0, high=3.0, doc="swing hip pitch per lean", source=_OFF
    )
    step_pitch_damping: float = parameter(
        0.0, unit="s", low=-0.5, high=0.5, doc="swing hip pitch per rate", source=_OFF
    )
    step_roll_gain: float = parameter(
        0.0, unit="-", low=-3.0, high=3.0, doc="swing hip roll per lean", source=_OFF
    )
    step_roll_damping: float = parameter(
        0.0, unit="s", low=-0.5, high=0.5, doc="swing hip roll per rate", source=_OFF
    )
    ankle_limit: float = parameter(
        0.25, unit="rad", low=0.0, high=1.0, doc="largest correction of an ankle", source=_TRIED
    )
    hip_limit: float = parameter(
        0.25, unit="rad", low=0.0, high=1.0, doc="largest correction of a hip", source=_TRIED
    )
    swing_level: float = parameter(
        0.0,
        unit="-",
        low=-1.0,
        high=1.0,
        doc="share of its tilt that is taken from the swing sole; negative adds to it",
        source=_OFF,
    )
    filter_time: float = parameter(
        0.01,
        unit="s",
        low=0.0,
        high=1.0,
        doc="time constant of the low-pass filter of angles and rates",
        source="assumption: one reading",
    )
    blend_time: float = parameter(
        0.04,
        unit="s",
        low=0.0,
        high=0.5,
        doc="in which a leg passes from stance to swing and back",
        source="assumption: a tenth of a step",
    )
    imu: Imu = field(default_factory=Imu)

    joints = JOINTS

    def controller(self, feet: FeetPoses, dt: float) -> AnkleHip:
        """The controller of one walk over the instants of `feet`, dt apart in [s]."""
        return AnkleHip(self, feet, dt)


class Strategies(NamedTuple):
    """What the strategies ask for about one axis.

    Attributes:
        ankle: (gain, damping in [s]) of the stance ankle.
        hip: The same of the stance hip.
        step: The same of the swing hip.
    """

    ankle: tuple[float, float]
    hip: tuple[float, float]
    step: tuple[float, float]


class AnkleHip:
    """The controller at work: two filtered errors and two filtered rates."""

    def __init__(self, gains: StrategyGains, feet: FeetPoses, dt: float) -> None:
        """A controller that has felt nothing yet; see `StrategyGains.controller`."""
        self._level = gains.swing_level
        self._most = gains.hip_limit, gains.ankle_limit
        self._axes = (_strategies(gains, "pitch"), _strategies(gains, "roll"))
        self._lean = feet.trunk_pitch.tolist()
        self._stance = stance_weights(feet.swing, round(gains.blend_time / dt)).tolist()
        ratio = gains.imu.spacing(dt) / gains.filter_time if gains.filter_time else np.inf
        self._new = 1.0 - exp(-ratio)
        self._error: Attitude | None = None

    def correction(self, tick: int, felt: Attitude) -> Sequence[float]:
        """Corrections in the order of `JOINTS`, in [rad]."""
        error = self._smooth(felt._replace(pitch=felt.pitch - self._lean[tick]))
        stance, (pitch, roll) = self._stance[tick], self._axes
        return [
            *self._turned(pitch, error.pitch, error.pitch_rate, stance),
            *self._turned(roll, error.roll, error.roll_rate, stance),
        ]

    def _smooth(self, error: Attitude) -> Attitude:
        """The error behind the low-pass filter, which starts at the first one."""
        before = self._error or error
        parts = zip(before, error, strict=True)
        self._error = Attitude(*(old + self._new * (now - old) for old, now in parts))
        return self._error

    def _turned(
        self, wanted: Strategies, error: float, rate: float, stance: Sequence[float]
    ) -> Iterator[float]:
        """Hip and ankle of the left leg, then of the right one, about one axis."""
        (ka, da), (kh, dh), (ks, ds) = wanted
        ankle, hip, step = ka * error + da * rate, kh * error + dh * rate, ks * error + ds * rate
        for share in stance:
            turn = _within(share * hip - (1.0 - share) * step, self._most[0])
            sole = share * ankle - (1.0 - share) * self._level * (error + turn)
            yield turn
            yield _within(sole, self._most[1])


def _strategies(gains: StrategyGains, axis: str) -> Strategies:
    return Strategies(
        *(
            (getattr(gains, f"{joint}_{axis}_gain"), getattr(gains, f"{joint}_{axis}_damping"))
            for joint in Strategies._fields
        )
    )


def _within(angle: float, most: float) -> float:
    return max(-most, min(most, angle))


def stance_weights(swing: np.ndarray, blend: int) -> np.ndarray:
    """Share of the ticks around each in which a foot is meant to stand. Shape (n, 2).

    Args:
        swing: Where the gait means a foot to be in the air. Shape (n, 2).
        blend: Ticks that are looked at around each one.
    """
    half = blend // 2
    padded = np.pad(~swing, ((half + 1, half), (0, 0)), mode="edge").astype(float)
    sums = np.cumsum(padded, axis=0)
    width = 2 * half + 1
    weights: np.ndarray = (sums[width:] - sums[:-width]) / width
    return weights
