"""How late targets reach the servos.

A servo acts on a target its latency after it was sent; a target that was sent between two steps
lies on the line between theirs. What reaches whom in the coming steps depends on nothing that
happens in them, so it is found for many steps at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from gaitlab.model.servo import Servo

ROUNDING = 1e-6  # steps; forgives 0.014 / 0.002 being no whole number to the last bit


def unequally_late(
    servos: Sequence[Servo], spread: float, rng: np.random.Generator
) -> Sequence[Servo]:
    """Servos whose latencies are each moved by spread x U(-1, 1), in [s], never below 0.

    Nothing is drawn for a spread of 0.
    """
    if spread == 0.0:
        return servos
    moved = spread * rng.uniform(-1.0, 1.0, len(servos))
    return [
        replace(servo, latency=max(0.0, servo.latency + float(by)))
        for servo, by in zip(servos, moved, strict=True)
    ]


class Latency:
    """The targets that are on their way to the servos of one robot."""

    def __init__(self, servos: Sequence[Servo], dt: float, pose: np.ndarray) -> None:
        """Nothing has been sent yet.

        Args:
            servos: One per joint.
            dt: Duration of a step, in [s].
            pose: Targets until the first arrives, in [rad]. Shape (joints,).
        """
        late = np.array([servo.latency for servo in servos]) / dt
        self._delays, self._shares = _steps(late)
        self._between = (self._shares > 0.0).astype(int)
        self._longest = int((self._delays + self._between).max(initial=0))
        self._sent = np.tile(pose, (self._longest, 1))

    def arriving(self, sent: np.ndarray) -> np.ndarray:
        """What reaches each servo in the coming steps; remembers what was sent.

        Args:
            sent: Target that is sent in each step, in [rad]. Shape (steps, joints).

        Returns:
            In [rad]. Shape (steps, joints).
        """
        if not self._longest:
            return sent
        known = np.concatenate([self._sent, sent])
        self._sent = known[len(sent) :]
        joint, now = np.arange(sent.shape[1]), np.arange(self._longest, len(known))[:, None]
        later = known[now - self._delays, joint]
        if not self._between.any():
            return later
        earlier = known[now - self._delays - self._between, joint]
        return np.where(self._between, later + self._shares * (earlier - later), later)


def _steps(late: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Delays in whole steps, and the share of another step beyond them; no share of rounding."""
    nearest = np.rint(late)
    late = np.where(np.abs(late - nearest) < ROUNDING, nearest, late)
    whole = np.floor(late)
    return whole.astype(int), late - whole
