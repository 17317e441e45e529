"""Joint positions that a limb cannot take are refused, by its name and the first instant."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from gaitlab.errors import Infeasible
from gaitlab.model.links import Joint

ROUNDING = 1e-9  # rad, the only angle by which a joint limit is forgiven


def require_limits(limb: str, joints: Sequence[Joint], position: np.ndarray) -> None:
    """Refuse joint positions beyond their limits.

    Args:
        limb: Name for the message, `left_leg` for instance.
        joints: Joints of the limb.
        position: In [rad]. Shape (n, joints of the limb).

    Raises:
        Infeasible: Names the first such instant, its joint, the angle found and those allowed.
    """
    low = np.array([joint.lower for joint in joints]) - ROUNDING
    high = np.array([joint.upper for joint in joints]) + ROUNDING
    outside = np.argwhere(~((position >= low) & (position <= high)))
    if not len(outside):
        return
    tick, index = (int(i) for i in outside[0])
    joint = joints[index]
    reason = (
        f"{joint.name} would have to turn to {_angles(position[tick, index])}, its limits are "
        f"{_angles(joint.lower, joint.upper)}; shorten step_length or step_height, or change "
        "hip_height"
    )
    raise Infeasible(limb=limb, tick=tick, reason=reason)


def both_legs(targets: Callable[[int], np.ndarray]) -> list[np.ndarray]:
    """What `targets` gives for the left leg, 0, and the right one, 1.

    Raises:
        Infeasible: Of both legs the one that fails first.
    """
    found, problems = [], []
    for index in (0, 1):
        try:
            found.append(targets(index))
        except Infeasible as problem:
            problems.append(problem)
    if problems:
        raise min(problems, key=lambda problem: problem.tick)
    return found


def _angles(*angles: float) -> str:
    in_radians = " and ".join(f"{angle:.3f}" for angle in angles)
    in_degrees = " and ".join(f"{angle:.1f}" for angle in np.degrees(angles))
    return f"{in_radians} rad ({in_degrees} degrees)"
