"""Random streams of a trial, all from its seed."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class Randomness(NamedTuple):
    """Independent random streams of one trial, so that one more draw shifts no other."""

    terrain: np.random.Generator
    pose: np.random.Generator
    friction: np.random.Generator
    servo: np.random.Generator
    imu: np.random.Generator


def randomness(seed: int) -> Randomness:
    """The streams that belong to a trial's seed."""
    children = np.random.SeedSequence(seed).spawn(len(Randomness._fields))
    return Randomness(*(np.random.default_rng(child) for child in children))
