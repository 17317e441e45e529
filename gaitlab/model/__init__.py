"""What a robot, a gait, a sole, a servo and a balance controller are.

A robot is a tree of rigid links with soles and limits of its joints. Protocols and shared parts
only: each robot of a team is a file in `gaitlab.robots`, each gait one in `gaitlab.gaits`.
"""

from gaitlab.model.limits import ROUNDING, both_legs, require_limits
from gaitlab.model.links import Axis, Box, Coupling, Joint, Link, Part, limb
from gaitlab.model.robot import (
    GANTRY_PITCH,
    Gantry,
    Robot,
    couplings_of,
    gantry_of,
    self_collision_of,
)
from gaitlab.model.start import Start, standing
from gaitlab.model.tree import LinkPoses, Tree

__all__ = [
    "GANTRY_PITCH",
    "ROUNDING",
    "Axis",
    "Box",
    "Coupling",
    "Gantry",
    "Joint",
    "Link",
    "LinkPoses",
    "Part",
    "Robot",
    "Start",
    "Tree",
    "both_legs",
    "couplings_of",
    "gantry_of",
    "limb",
    "require_limits",
    "self_collision_of",
    "standing",
]
