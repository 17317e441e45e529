"""What a limb cannot reach is refused, by its name and the first instant."""

from __future__ import annotations

import numpy as np

from gaitlab.errors import Infeasible

ROUNDING = 1e-9  # m, the only distance by which a reach is forgiven


def require(possible: np.ndarray, found: np.ndarray, limb: str, reason: str) -> None:
    """Refuse targets of a limb unless all are possible.

    Args:
        possible: Which are. Shape (n, ...), or () for a single one.
        found: What stands in the way. The same shape.
        limb: Name for the message, `left_leg` for instance.
        reason: The message, with `{found}` where that number belongs.

    Raises:
        Infeasible: Names the first instant that is not.
    """
    if np.all(possible):
        return
    first = tuple(np.argwhere(~np.asarray(possible))[0])
    reason = reason.format(found=np.asarray(found)[first])
    raise Infeasible(limb=limb, tick=int(first[0]) if first else 0, reason=reason)
