"""Four force sensors under each foot: what they read, the ZMP they give, and two indices of it.

Sensors are ordered front left, front right, rear left, rear right; positions are signed
coordinates in the frame of the foot's ankle, x forward, y left.

Corrections to [Shaari2015]: (2.13) holds if its rear arm is a positive distance, (2.15) needs
F3 (y1 - y) - F4 (y2 + y) = 0 as its middle line, and one lateral arm a foot is not exact because
the rear sensors stand closer together than the front ones. The signed sums below are exact.

References:
    Shaari2015: Shaari, Razali, Miskon and Isa, parameter study of NAO's walking gait by ZMP.
"""

from __future__ import annotations

import numpy as np

SINGULAR = 1e-6  # m, smallest sum of two coordinates that a ratio is taken of
NEWTON_STEPS = 4  # the sensors' quadrilateral is nearly a rectangle: two steps give all digits


def sensor_loads(force: np.ndarray, centre: np.ndarray, sensors: np.ndarray) -> np.ndarray:
    """Loads of four sensors that carry a force with its centre there, derived here.

    The four shares are those of the bilinear map of the sensors' quadrilateral, so that they are
    positive, sum to one and have the centre of pressure as their centre. A centre outside the
    quadrilateral is drawn to its edge: the sensors there have no load left to give.

    Args:
        force: Vertical force on the foot, in [N]. Shape (n,).
        centre: Its centre in the ankle frame, in [m]; anything where there is no force. (n, 2).
        sensors: In the ankle frame, in [m]. Shape (4, 2).

    Returns:
        In [N]. Shape (n, 4).
    """
    loaded = np.flatnonzero(force > 0.0)
    target = centre[loaded]
    u, v = np.full(len(loaded), 0.5), np.full(len(loaded), 0.5)
    for _ in range(NEWTON_STEPS):
        u, v = _newton_step(u, v, target, sensors)
    share = _shares(np.clip(u, 0.0, 1.0), np.clip(v, 0.0, 1.0))
    loads = np.zeros((len(force), 4))
    loads[loaded] = force[loaded, None] * share
    return loads


def _shares(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Bilinear weights at u from rear to front and v from right to left. Shape (n, 4)."""
    return np.stack([u * v, u * (1.0 - v), (1.0 - u) * v, (1.0 - u) * (1.0 - v)], axis=-1)


def _newton_step(
    u: np.ndarray, v: np.ndarray, target: np.ndarray, sensors: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    left, right = sensors[0] - sensors[2], sensors[1] - sensors[3]
    front, rear = sensors[0] - sensors[1], sensors[2] - sensors[3]
    missing_x, missing_y = (target - _shares(u, v) @ sensors).T
    along_x, along_y = (v * a + (1.0 - v) * b for a, b in zip(left, right, strict=True))
    across_x, across_y = (u * a + (1.0 - u) * b for a, b in zip(front, rear, strict=True))
    determinant = along_x * across_y - along_y * across_x
    du = (missing_x * across_y - missing_y * across_x) / determinant
    dv = (along_x * missing_y - along_y * missing_x) / determinant
    # A centre far outside would send the shares to where the map folds over.
    return np.clip(u + du, -0.5, 1.5), np.clip(v + dv, -0.5, 1.5)


def foot_zmp(loads: np.ndarray, sensors: np.ndarray) -> np.ndarray:
    """ZMP of a foot from its sensors, [Shaari2015] eqs. (2.13) to (2.16) in signed form.

    Args:
        loads: In [N]. Shape (..., 4).
        sensors: In the ankle frame, in [m]. Shape (4, 2).

    Returns:
        In the ankle frame, in [m]; NaN without load. Shape (..., 2).
    """
    total = loads.sum(axis=-1, keepdims=True)
    return loads @ sensors / np.where(total > 0.0, total, np.nan)


def normalised(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """(left - right) / (left + right) of two ZMP coordinates as printed, [Shaari2015] (2.17).

    A foot in the air counts as 0, so the value is then +1 or -1 and says which foot carries the
    load. It lies in [-1, 1] only if both coordinates have the same sign. NaN where their sum is
    below 1 um: quiet standing makes it singular in y, where the two feet's readings cancel.

    Args:
        left: Coordinate of the left foot's ZMP, in [m], NaN in the air. Shape (...).
        right: Of the right foot's. Shape (...).
    """
    left, right = np.nan_to_num(left), np.nan_to_num(right)
    total = left + right
    singular = np.abs(total) < SINGULAR
    return np.where(singular, np.nan, (left - right) / np.where(singular, 1.0, total))


def load_index(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """(left - right) / (left + right) of two vertical forces, in [-1, 1]; NaN in flight."""
    total = left + right
    return (left - right) / np.where(total > 0.0, total, np.nan)


def averaged(loads: np.ndarray, ticks: int) -> np.ndarray:
    """Means over so many ticks, as a robot's sensors are read; a rest at the end is left out.

    Args:
        loads: Over time. Shape (n, ...).
        ticks: Between two readings, at least 1.

    Returns:
        Shape (n // ticks, ...).
    """
    count = len(loads) // ticks
    return loads[: count * ticks].reshape(count, ticks, *loads.shape[1:]).mean(axis=1)


def fluctuation(signal: np.ndarray, exchanges: float) -> float:
    """Total variation over twice the exchanges of support, less one.

    0 if the signal goes from -1 to 1 or back once an exchange and never turns; [Shaari2015] says
    that its signal "fluctuates" and not how that was judged, so this measure is ours.

    Args:
        signal: Over time; instants where it is not defined are left out. Shape (n,).
        exchanges: Exchanges of support in that time, more than 0.
    """
    defined = signal[np.isfinite(signal)]
    return float(np.abs(np.diff(defined)).sum()) / (2.0 * exchanges) - 1.0


def crossings(signal: np.ndarray) -> int:
    """How often a signal changes its sign; zeros and undefined instants are left out."""
    sign = np.sign(signal[np.isfinite(signal) & (signal != 0.0)])
    return int(np.count_nonzero(np.diff(sign)))


def normalised_zmp(left: np.ndarray, right: np.ndarray, sensors: np.ndarray) -> np.ndarray:
    """Normalised ZMP x and y of both feet's sensor loads, [Shaari2015] eqs. (2.13) to (2.17).

    Args:
        left: Loads of the left foot's sensors, in [N]. Shape (n, 4).
        right: Of the right foot's. Shape (n, 4).
        sensors: Of the left and the right foot, ankle frames, in [m]. Shape (2, 4, 2).

    Returns:
        As printed, signed ankle coordinates in both axes. Shape (n, 2).
    """
    return normalised(foot_zmp(left, sensors[0]), foot_zmp(right, sensors[1]))
