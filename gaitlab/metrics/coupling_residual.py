"""How far gears and belts of the simulation give way."""

from __future__ import annotations

from math import nan

import numpy as np

from gaitlab.log import TrialLog
from gaitlab.model import GANTRY_PITCH

UNIT = "rad"
NEEDS = ("couplings",)


def coupling_residual(log: TrialLog) -> float:
    """Largest angle between a coupled joint and where its leader turns it, in [rad].

    A figure of the simulation, not of the robot: belts are rigid. Over the walk before a fall. NaN
    for a robot without couplings or when nothing was walked. Defined here.
    """
    limits = dict(zip(log.header.joints, log.header.torque_limits, strict=True))
    coupled = [name for name, limit in limits.items() if limit == 0.0 and name != GANTRY_PITCH]
    errors = [(log[f"{j}_position"] - log[f"{j}_target"])[log.walking] for j in coupled]
    return float(np.abs(errors).max()) if errors and errors[0].size else nan
