"""What legs of parallelograms cannot do: pitch a sole against the trunk."""

from __future__ import annotations

import numpy as np

from gaitlab.errors import Infeasible
from gaitlab.motion import FeetPoses


def require_parallel(feet: FeetPoses) -> None:
    """Refuse a sole that is to pitch against the trunk, which parallelogram legs do not allow.

    Raises:
        Infeasible: Names the first such foot and instant, and what the gait asks for.
    """
    turned = {
        "trunk_pitch": np.abs(feet.trunk_pitch)[:, None] * np.ones((1, 2)),
        "ankle_pitch": np.abs(feet.ankle_pitch),
        "knee_only": np.abs(feet.knee_only),
    }
    for name, amount in turned.items():
        if np.any(amount > 0.0):
            tick, foot = (int(i) for i in np.argwhere(amount > 0.0)[0])
            reason = (
                f"the gait asks for {name} {amount[tick, foot]:.4f}; parallelograms keep the "
                "sole parallel to the pelvis, so it must be 0"
            )
            raise Infeasible(limb=f"{('left', 'right')[foot]}_leg", tick=tick, reason=reason)
