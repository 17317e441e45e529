"""Standing still: what every walk starts from, and what must hold before any walk is judged.

With `walk`, an experiment names a walking gait and the robot stands in the pose that it starts
from, so that no number of it is written twice; a walker that includes a gait and says `gait: stand`
means that gait. Parameters given beside it win.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gaitlab.errors import WrongValue
from gaitlab.kinematics.transforms import axis_rotation
from gaitlab.model.gait import FeetPoses
from gaitlab.model.gait import Gait as Walk
from gaitlab.parameters import parameter

LEVEL = 1e-9  # m and rad; a pose that is farther from standing on both soles is none of these
DIGITS = 12  # after the point, of what is taken from a walk
_OF_WALK = "assumption: bent knees; `walk: GAIT` takes it from that gait's first pose"


@dataclass(frozen=True, kw_only=True)
class Gait:
    """Both feet side by side on level soles, for as long as the trial takes."""

    hip_height: float = parameter(
        0.225, unit="m", low=0.05, high=2.0, doc="hips over the soles", source=_OF_WALK
    )
    step_width: float = parameter(
        0.084, unit="m", low=0.0, high=0.8, doc="between the feet", source=_OF_WALK
    )
    com_offset: float = parameter(
        0.0, unit="m", low=-0.2, high=0.2, doc="hips ahead of the ankles", source=_OF_WALK
    )
    trunk_pitch: float = parameter(
        0.0, unit="rad", low=-0.5, high=0.6, doc="lean about the hips", source=_OF_WALK
    )
    gait_period: float = parameter(
        1.0, unit="s", low=0.1, high=60.0, doc="a cycle of the horizon", source="assumption"
    )

    @property
    def step_length(self) -> float:
        """Nowhere, in [m]."""
        return 0.0

    @property
    def startup_time(self) -> float:
        """All of it is measured, in [s]."""
        return 0.0

    def feet(self, t: np.ndarray) -> FeetPoses:
        """The same foot poses at all instants t, in [s]. Shape (n,)."""
        n = len(np.asarray(t))
        across = np.array([[0.5], [-0.5]]) * [0.0, self.step_width, 0.0]
        stand = across - [self.com_offset, 0.0, self.hip_height]
        level = np.zeros((n, 2))
        return FeetPoses(
            position=np.tile(stand @ _lean(-self.trunk_pitch).T, (n, 1, 1)),
            heading=level,
            trunk_pitch=np.full(n, self.trunk_pitch),
            ankle_pitch=level,
            knee_only=level,
            swing=np.zeros((n, 2), dtype=bool),
            phase=np.full(n, np.nan),
            step_index=np.full(n, -1),
        )

    @classmethod
    def of(cls, walk: Walk) -> dict[str, float]:
        """Parameters with which this gait holds the first pose of a walk.

        Raises:
            WrongValue: If the walk does not start from both feet side by side on level soles.
        """
        if not hasattr(walk, "feet"):
            raise WrongValue(
                "the walk says where joints are and not feet; give hip_height, step_width, "
                "com_offset and trunk_pitch instead of `walk`"
            )
        feet = walk.feet(np.zeros(1))
        lean = float(feet.trunk_pitch[0])
        left, right = feet.position[0] @ _lean(lean).T
        apart = left - right
        others = (feet.heading, feet.ankle_pitch, [apart[0], apart[2], left[1] + right[1]])
        if max(float(np.abs(part).max()) for part in others) > LEVEL:
            raise WrongValue(
                "the walk does not start from both feet side by side on level soles; give "
                "hip_height, step_width, com_offset and trunk_pitch instead of `walk`"
            )
        pose = {
            "hip_height": -left[2],
            "step_width": apart[1],
            "com_offset": -left[0],
            "trunk_pitch": lean,
        }
        # Turned back the numbers end in rounding that no two processors share.
        return {name: round(float(value), DIGITS) + 0.0 for name, value in pose.items()}


def _lean(angle: float) -> np.ndarray:
    return axis_rotation("y", np.array(angle))
