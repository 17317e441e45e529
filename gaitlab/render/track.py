"""A trial as numbers that a page plays: what moves, sampled and packed, and what does not."""

from __future__ import annotations

import base64
import zlib
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from gaitlab.kinematics.transforms import quaternion_of
from gaitlab.log import TrialLog
from gaitlab.model import Robot, Tree
from gaitlab.model.tree import unit_axis
from gaitlab.render.ground import (
    BOARD_COLOUR,
    DARK_GREEN,
    DARKER,
    LAYER_COLOUR,
    LIGHT_GREEN,
    MAT_COLOUR,
    THATCH,
    TILE,
    nap_of,
    pile_of,
)
from gaitlab.render.overlay import REACH, UNLOADED
from gaitlab.render.scene import Recorded, Scene, joints_of, link_shapes, scene_of, ticks_at
from gaitlab.surfaces.surface import FibreMat, SoftLayer, Surface, TuftedPile

ROUNDED = 5  # decimals of a length in m, a hundredth of a millimetre
ANGLES = 6  # decimals of a part of a unit vector or quaternion
LEVELS = 65534  # steps of a packed number between its least and its greatest
ABSENT = 65535  # stands for what is not a number
ASIDE, ALONG = 0.9, 1.2  # robot heights of ground beside and beyond all footprints
MOST_BLADES = 9000  # that a phone draws smoothly


class Channel(NamedTuple):
    """One number over time, packed.

    Attributes:
        name: What it is.
        low: Its least value.
        step: From one of its levels to the next.
    """

    name: str
    low: float
    step: float


def track_of(shown: Recorded, instants: np.ndarray) -> dict[str, Any]:
    """A trial at instants, as JSON data.

    Args:
        shown: The trial.
        instants: On the clock of the walk, in [s]. Shape (n,).

    Returns:
        `data` holds all channels one after another: differences of unsigned 16-bit levels, least
        significant byte first, deflated, in base64. The other keys are read by `viewer/scene.js`.
    """
    scene = scene_of(shown, instants)
    channels, data = packed(_moving(shown, scene, ticks_at(shown.log, instants)))
    return {
        "id": shown.trial_id,
        "title": scene.title,
        "cell": shown.cell,
        "caption": scene.caption,
        "verdict": verdict_of(shown.log, scene),
        "fell": scene.fall,
        "size": _rounded(scene.size),
        "weight": _rounded(scene.weight),
        "reach": REACH,
        "unloaded": UNLOADED,
        "ground": _ground(scene),
        "joints": len(scene.tree.joints),
        "count": len(instants),
        "channels": [list(channel) for channel in channels],
        "data": data,
    }


def body_of(robot: Robot) -> dict[str, Any]:
    """Links, shapes and soles of a robot, as JSON data; the same for all of its trials."""
    tree, feet = robot.tree, robot.feet
    soles = [robot.sole.corners(side)[[0, 1, 3, 2]] for side in range(len(feet))]
    return {
        "links": [_link(tree, number, feet) for number in range(len(tree.links))],
        "feet": [tree.index(foot) for foot in feet],
        "soles": [_rounded(corners) for corners in soles],
    }


def verdict_of(log: TrialLog, scene: Scene) -> str:
    """What became of a trial, in a few words."""
    if scene.fall is None:
        return "stalled" if log.stalled else "stayed up"
    standing = " standing, before its first step," if log.fell_standing else ""
    return f"fell{standing} at {scene.fall:.2f} s: {scene.fall_cause}"


def packed(table: dict[str, np.ndarray]) -> tuple[list[Channel], str]:
    """Numbers over time, each in 65 535 levels between its least and greatest value.

    Args:
        table: Name to numbers; infinite ones count as not numbers. Shape (n,) each.
    """
    channels, levels = [], []
    for name, values in table.items():
        known = np.isfinite(values)
        low = float(values[known].min()) if known.any() else 0.0
        step = (float(values[known].max()) - low) / LEVELS if known.any() else 0.0
        level = np.rint((np.where(known, values, low) - low) / (step or 1.0))
        levels.append(np.where(known, level, ABSENT).astype(np.uint16))
        channels.append(Channel(name, low, step))
    differences = np.diff(np.array(levels), axis=1, prepend=np.uint16(0)).astype("<u2")
    # Low and high bytes apart: the high ones are nearly all alike, and deflate to little.
    apart = differences.view(np.uint8).reshape(-1, 2).T.tobytes()
    return channels, base64.b64encode(zlib.compress(apart, 9)).decode()


def _moving(shown: Recorded, scene: Scene, ticks: np.ndarray) -> dict[str, np.ndarray]:
    """Everything of a trial that changes, by the names that the page asks for."""
    log, tree = shown.log, scene.tree
    joints = joints_of(tree, log)[ticks]
    targets = log.joint_table("target")[ticks, : len(tree.joints)]
    turned = _steady(quaternion_of(scene.poses.rotation[:, 0]))
    groups = {
        "time": scene.time,
        "trunk": scene.poses.position[:, 0],
        "turn": turned,
        "joint": joints,
        "target": np.where(np.isfinite(targets), targets, joints),
        "load": scene.forces.reshape(len(ticks), -1),
        "contact": scene.contact.astype(float),
        "zmp": scene.zmp,
        "margin": log["zmp_margin"][ticks],
        "phase": scene.phase,
        "focus": scene.focus,
    }
    table = {}
    for name, values in groups.items():
        for number, column in enumerate(np.reshape(values, (len(ticks), -1)).T):
            table[f"{name}{number}"] = np.asarray(column, dtype=float)
    return table


def _steady(quaternions: np.ndarray) -> np.ndarray:
    """The same rotations, none far from the one before: q and -q are one. Shape (n, 4)."""
    along = (quaternions[1:] * quaternions[:-1]).sum(axis=1)
    signs = np.cumprod(np.append(1.0, np.where(along < 0.0, -1.0, 1.0)))
    return quaternions * signs[:, None]


def _link(tree: Tree, number: int, feet: tuple[str, str]) -> dict[str, Any]:
    link = tree.links[number]
    turn = None if link.turn is None else quaternion_of(np.reshape(link.turn, (3, 3)))
    return {
        "name": link.name,
        "parent": -1 if link.parent is None else tree.index(link.parent),
        "origin": _rounded(link.origin),
        "turn": None if turn is None else _rounded(turn, ANGLES),
        "axis": None if link.joint is None else _rounded(unit_axis(link.joint.axis), ANGLES),
        "shapes": [
            {"colour": shape.colour, "polygons": _rounded(shape.corners)}
            for shape in link_shapes(link, feet)
        ],
    }


def _ground(scene: Scene) -> dict[str, Any]:
    """Board, layer and pile; what lies on the lane and around a robot that falls from it."""
    surface, size = scene.surface, scene.size
    (x0, y0), (x1, y1) = scene.lane
    x, y = [x0 - ALONG * size, x1 + ALONG * size], [y0 - ASIDE * size, y1 + ASIDE * size]
    density, width = pile_of(surface)
    drawn = min(density, MOST_BLADES / ((x[1] - x[0]) * (y[1] - y[0])))
    colour, thickness = _bottom(surface)
    return {
        "x": _rounded(x),
        "y": _rounded(y),
        "height": surface.height,
        "tile": TILE,
        "darker": DARKER,
        "board": BOARD_COLOUR,
        "bottom": {"colour": colour, "height": thickness},
        "layer": isinstance(surface, SoftLayer),
        "blades": {
            "density": drawn,
            "thinner": density / drawn if density else 1.0,
            "width": width,
            "nap": _rounded(nap_of(surface)),
            "dark": _rounded(DARK_GREEN),
            "light": _rounded(LIGHT_GREEN),
        },
    }


def _bottom(surface: Surface) -> tuple[str, float]:
    """What covers the board below the blades: its colour and height in [m]."""
    if isinstance(surface, SoftLayer):
        return LAYER_COLOUR, surface.height
    if isinstance(surface, FibreMat):
        return MAT_COLOUR, 0.5 * surface.height
    if isinstance(surface, TuftedPile):
        return THATCH, 0.002
    return BOARD_COLOUR, 0.0


def _rounded(values: float | Sequence[float] | np.ndarray, decimals: int = ROUNDED) -> Any:
    return np.round(np.asarray(values, dtype=float), decimals).tolist()
