"""Standing on both feet, with a lean."""

from dataclasses import dataclass

import numpy as np

from gaitlab.model.gait import FeetPoses
from gaitlab.parameters import parameter

LEAN = 0.0  # m; the feet move so far behind the trunk


@dataclass(frozen=True, kw_only=True)
class Gait:
    """No step at all."""

    gait_period: float = parameter(1.0, unit="s", low=0.2, high=5.0, doc="one cycle")
    hip_height: float = parameter(0.224, unit="m", low=0.1, high=0.24, doc="hips over the soles")

    step_length = 0.0
    startup_time = 0.1

    def feet(self, t: np.ndarray) -> FeetPoses:
        """Feet at the instants t, in [s]."""
        still = np.zeros((len(t), 2))
        x = still + LEAN * np.minimum(t / 0.3, 1.0)[:, None]
        y = still + np.array([0.042, -0.042])
        return FeetPoses(
            position=np.stack([x, y, still - self.hip_height], axis=-1),
            heading=still,
            trunk_pitch=np.zeros_like(t),
            ankle_pitch=still,
            knee_only=still,
            swing=still > 0.0,
            phase=np.where(t >= 0.1, (t - 0.1) % 1.0, np.nan),
            step_index=np.where(t >= 0.1, np.floor(2.0 * (t - 0.1)), -1).astype(int),
        )
