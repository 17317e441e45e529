"""A pan-tilt head as a Denavit-Hartenberg chain; its zero looks straight up the neck.

Corrections to [Yanto]: the printed forward kinematics (5) to (7) has parallel axes, a wrong
sign in (6) and a factor 2 in (7) that no product of two rows gives; it describes no head that pans
and tilts. The printed inverse, (8) and (9), does, with atan2 and the horizontal range in (9).

References:
    Yanto: Yanto, Dewanto, Pramadihanto, Binugroho, Teen-Size Humanoid "FLoW" Complete
        Analytical Kinematics, Politeknik Elektronika Negeri Surabaya, no year printed.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import numpy as np

from gaitlab.kinematics.dh import DHRow, chain_pose


@dataclass(frozen=True, kw_only=True)
class DhHead:
    """Lengths of the chain, rows (pan, d, 0, -90 deg) and (tilt - 90 deg, 0, a, 0).

    Attributes:
        neck: d, neck base to the tilt axis, in [m].
        eyes: a, tilt axis to the point between the eyes, in [m].
    """

    neck: float
    eyes: float

    @property
    def rows(self) -> tuple[DHRow, DHRow]:
        """The chain's rows."""
        return DHRow(0.0, self.neck, 0.0, -pi / 2.0), DHRow(-pi / 2.0, 0.0, self.eyes, 0.0)

    def pose(self, joints: np.ndarray) -> np.ndarray:
        """Pose of the eyes in the neck base frame; joints pan, tilt. (..., 2) to (..., 4, 4)."""
        return chain_pose(self.rows, joints)

    def pointing(self, point: np.ndarray) -> np.ndarray:
        """Pan and tilt that turn the head's axis through a point, [Yanto] eqs. (8) and (9).

        The other branch is pan + pi, -tilt. Pan is undefined on the neck's axis and 0 there.

        Args:
            point: In the neck base frame, in [m]. Shape (..., 3).

        Returns:
            Pan and tilt >= 0, in [rad]. Shape (..., 2).
        """
        x, y, z = np.moveaxis(np.asarray(point, dtype=float), -1, 0)
        return np.stack([np.arctan2(y, x), np.arctan2(np.hypot(x, y), z - self.neck)], axis=-1)
