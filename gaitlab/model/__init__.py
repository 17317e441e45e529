"""What a robot, a gait, a sole, a servo and a balance controller are.

A robot is a tree of rigid links with soles and limits of its joints. Protocols and shared parts
only: each robot of a team is a file in `gaitlab.robots`, each gait one in `gaitlab.gaits`.
"""

from gaitlab.model.link_table import SIDES, Shape, Side
from gaitlab.model.robot import (
    GANTRY_PITCH,
    Gantry,
    Robot,
    Start,
    couplings_of,
    gantry_of,
    self_collision_of,
    standing,
)
from gaitlab.model.targets import ROUNDING, require_limits
from gaitlab.model.tree import Axis, Box, Coupling, Joint, Link, LinkPoses, Tree, Vector

__all__ = [
    "GANTRY_PITCH",
    "ROUNDING",
    "SIDES",
    "Axis",
    "Box",
    "Coupling",
    "Gantry",
    "Joint",
    "Link",
    "LinkPoses",
    "Robot",
    "Shape",
    "Side",
    "Start",
    "Tree",
    "Vector",
    "couplings_of",
    "gantry_of",
    "require_limits",
    "self_collision_of",
    "standing",
]
