"""Linear segments with quartic blends: a joint that starts and stops without a jerk of its motor.

A segment leaves rest, reaches a constant speed w after a blend of duration t_b, and comes to rest
again; position, velocity and acceleration are continuous. Written for a segment of duration 1 that
covers the angle 1, so that w is the ratio k of cruise speed to mean speed and t_b = 1 - 1/k.

Corrections to [Siswoyo2008]: the fourth power of the first blend carries a minus sign, the linear
part runs from t_b on, and the duration is that of the segment, which is not always t_f. Which
speeds are possible follows from 0 < t_b <= T/2 and is derived here.

References:
    Siswoyo2008: H. Siswoyo Jo, N. Mir-Nasiri and E. Jayamani, Design and Trajectory Planning of
        Bipedal Walking Robot with Minimum Sufficient Actuation System.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gaitlab.errors import WrongValue

SLOWEST_RATIO, FASTEST_RATIO = 1.0, 2.0  # of cruise to mean speed; no blend, and nothing but blends


class JointMotion(NamedTuple):
    """Motion of joints: position [rad], velocity [rad/s], acceleration [rad/s^2]; equal shapes."""

    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray


def require_speed(change: float, duration: float, speed: float) -> float:
    """Ratio of a cruise speed to the mean speed of a segment.

    Args:
        change: Angle that the segment covers, in [rad].
        duration: Duration T of the segment, in [s].
        speed: Cruise speed w, in [rad/s].

    Raises:
        WrongValue: If no blend reaches that speed; names the speeds that can be.
    """
    if change == 0.0:
        return FASTEST_RATIO
    mean = change / duration
    ratio = speed / mean
    if not SLOWEST_RATIO < ratio <= FASTEST_RATIO:
        raise WrongValue(
            f"a cruise speed of {speed:.6g} rad/s does not cover {change:.6g} rad in "
            f"{duration:.6g} s; it must have the sign of the angle and lie above "
            f"{abs(mean):.6g} and not over {abs(2.0 * mean):.6g} rad/s: choose one in between"
        )
    return ratio


def blend_share(share: np.ndarray, ratio: np.ndarray) -> JointMotion:
    """Share of a segment covered, with its two derivatives by the share of time.

    Args:
        share: Share of the duration that has passed, in [0, 1]. Shape (...).
        ratio: Cruise over mean speed k, in (1, 2]. Shape (...).
    """
    blend = 1.0 - 1.0 / ratio
    late = share > 0.5
    since = np.where(late, 1.0 - share, share)  # the second half mirrors the first
    u = np.minimum(since / blend, 1.0)
    covered = ratio * (blend * (u**3 - 0.5 * u**4) + np.maximum(since - blend, 0.0))
    speed = ratio * (3.0 * u**2 - 2.0 * u**3)
    gain = 6.0 * ratio / blend * (u - u**2)
    position = np.where(late, 1.0 - covered, covered)
    return JointMotion(position, speed, np.where(late, -gain, gain))


def blended_segment(
    t: np.ndarray, start: float, end: float, duration: float, speed: float
) -> JointMotion:
    """One segment, [Siswoyo2008] section III.B.

    Args:
        t: Time since its start, in [s]; held before 0 and after the duration. Shape (n,).
        start: First position, in [rad].
        end: Last position, in [rad].
        duration: Its duration T, in [s].
        speed: Cruise speed w, in [rad/s].

    Raises:
        WrongValue: If the segment cannot be covered at that speed.
    """
    ratio = require_speed(end - start, duration, speed)
    times, values = np.array([0.0, duration]), np.array([start, end])
    return blended_path(t, times, values, np.array([ratio]))


def blended_path(
    t: np.ndarray, times: np.ndarray, values: np.ndarray, ratios: np.ndarray
) -> JointMotion:
    """A joint that comes to rest at every via point.

    Args:
        t: Instants, in [s]; the ends are held. Shape (n,).
        times: Instants of the via points, rising, in [s]. Shape (m + 1,).
        values: Positions there, in [rad]. Shape (m + 1,).
        ratios: Cruise over mean speed of each segment, in (1, 2]. Shape (m,).

    Raises:
        ValueError: If a ratio lies outside (1, 2].
    """
    if np.any(ratios <= SLOWEST_RATIO) or np.any(ratios > FASTEST_RATIO):
        raise ValueError("the ratio of cruise to mean speed lies in (1, 2]")
    index = np.clip(np.searchsorted(times, t, side="right") - 1, 0, len(ratios) - 1)
    duration, change = np.diff(times)[index], np.diff(values)[index]
    share = np.clip((t - times[index]) / duration, 0.0, 1.0)
    moved = blend_share(share, ratios[index])
    return JointMotion(
        values[index] + change * moved.position,
        change / duration * moved.velocity,
        change / duration**2 * moved.acceleration,
    )
