"""The ground of a film: a lane that the robot walks along, its blades rooted in the world."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gaitlab.render.lawn import (
    BLADES_A_TUFT,
    BOARD_COLOUR,
    DARK_GREEN,
    LAYER_COLOUR,
    LIGHT_GREEN,
    MAT_COLOUR,
    Patch,
    PressingSole,
    pressed,
)
from gaitlab.render.lens import Lens
from gaitlab.render.raster import Triangles
from gaitlab.render.scene import lit
from gaitlab.surfaces.surface import FibreMat, SoftLayer, Surface, TuftedPile

THATCH = "#4A7530"  # what shows between the blades
TILE = 0.1  # m, what is light and dark in turns along the board
DARKER = 0.86  # brightness of every second tile
BOARD = 0.05  # thickness of the board over the width of the lane
WIDER = 0.58  # power of the thinning by which blades widen; 1 would cover as much ground
BEND = np.array([0.0, 0.55, 1.0])  # where along a blade its drawn joints are
TIP = np.array([1.0, 0.75, 0.0])  # width of a blade there
PIECE_LIGHT = np.array([0.66, 0.66, 1.0])  # the lower piece of a blade stands in the shade


@dataclass(frozen=True, kw_only=True, eq=False)
class Turf:
    """A lane of ground.

    Attributes:
        surface: What it is.
        y: Its edges, in [m].
        roots: Feet of the blades, ordered along x, in [m]. Shape (n, 2).
        height: Of the blades, in [m]. Shape (n,).
        lean: Horizontal offset of their tips, in [m]. Shape (n, 2).
        shade: Of their green, dark 0 to light 1. Shape (n,).
        width: Of a drawn blade, in [m].
    """

    surface: Surface
    y: tuple[float, float]
    roots: np.ndarray
    height: np.ndarray
    lean: np.ndarray
    shade: np.ndarray
    width: float


def grown(surface: Surface, patch: Patch, seen: float, most: float) -> Turf:
    """A lane, deterministic: the same surface always grows the same blades.

    Args:
        surface: The ground.
        patch: Its edges.
        seen: Length of the lane that a picture shows, in [m].
        most: Blades that a picture may show; beyond it the eye sees no single one.
    """
    generator = np.random.default_rng(7)
    roots, width = _roots(surface, patch, most / min(seen, patch.size[0]), generator)
    n = len(roots)
    height = surface.height * generator.uniform(0.82, 1.06, n)
    lean = _leans(surface, generator, n) * height[:, None]
    shade = generator.uniform(0.0, 1.0, n) ** 1.5
    return Turf(
        surface=surface,
        y=patch.y,
        roots=roots,
        height=height,
        lean=lean,
        shade=shade,
        width=width,
    )


def _roots(
    surface: Surface, patch: Patch, most: float, generator: np.random.Generator
) -> tuple[np.ndarray, float]:
    """Feet of the blades and the width to draw them, thinned to so many on a metre of lane."""
    if not isinstance(surface, TuftedPile | FibreMat):
        return np.empty((0, 2)), 0.0
    tufted = isinstance(surface, TuftedPile)
    spacing = surface.spacing if isinstance(surface, TuftedPile) else 0.75 * surface.height
    width = surface.blade_width if isinstance(surface, TuftedPile) else 0.3 * surface.height
    density = (BLADES_A_TUFT if tufted else 1) / spacing**2
    thinner = max(1.0, density * patch.size[1] / most)
    step = np.sqrt(thinner / density)
    x, y = (np.arange(low, high, step) for low, high in (patch.x, patch.y))
    grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    roots = grid + generator.uniform(-0.7, 0.7, grid.shape) * step
    roots[:, 1] = np.clip(roots[:, 1], *patch.y)
    return roots[np.argsort(roots[:, 0], kind="stable")], width * thinner**WIDER


def _leans(surface: Surface, generator: np.random.Generator, n: int) -> np.ndarray:
    """Offset of the tips over the height: in all directions, and along the nap."""
    angle, amount = generator.uniform(-np.pi, np.pi, n), generator.uniform(0.05, 0.35, n)
    nap = np.zeros(2)
    if isinstance(surface, TuftedPile | FibreMat):
        direction = surface.nap_direction
        nap = 2.0 * surface.nap * np.array([np.cos(direction), np.sin(direction)])
    return amount[:, None] * np.column_stack([np.cos(angle), np.sin(angle)]) + nap


def ground(
    turf: Turf, x: tuple[float, float], soles: Sequence[PressingSole], lens: Lens
) -> list[Triangles]:
    """Board and pile between two places along the lane, in [m]."""
    thickness = BOARD * (turf.y[1] - turf.y[0])
    parts = [_slab(x, turf.y, (-thickness, 0.0), BOARD_COLOUR, lens)]
    if isinstance(turf.surface, SoftLayer):
        parts.append(_slab(x, turf.y, (0.0, turf.surface.height), LAYER_COLOUR, lens))
    elif isinstance(turf.surface, FibreMat):
        parts.append(_slab(x, turf.y, (0.0, 0.5 * turf.surface.height), MAT_COLOUR, lens))
    elif isinstance(turf.surface, TuftedPile):
        parts.append(_slab(x, turf.y, (0.0, 0.002), THATCH, lens))
    if len(turf.roots):
        parts.append(_blades(turf, x, soles, lens))
    return parts


def _slab(
    x: tuple[float, float],
    y: tuple[float, float],
    z: tuple[float, float],
    colour: str,
    lens: Lens,
) -> Triangles:
    """Top, right side and front end of a slab, in tiles that stay where they are in the world."""
    inner = np.arange(np.ceil(x[0] / TILE), np.ceil(x[1] / TILE)) * TILE
    edges = np.unique(np.clip(np.concatenate([[x[0]], inner, [x[1]]]), *x))
    odd = np.floor(0.5 * (edges[1:] + edges[:-1]) / TILE) % 2
    rows = np.unique(np.clip(np.arange(np.floor(y[0] / TILE), y[1] / TILE + 1) * TILE, *y))
    row_odd = np.floor(0.5 * (rows[1:] + rows[:-1]) / TILE) % 2
    quads, light = [], []
    normals = np.array([[0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]])
    top, side, end = lit(colour, normals) * 255.0
    for a, b, tile in zip(edges[:-1], edges[1:], odd, strict=True):
        quads.append([(a, y[0], z[0]), (b, y[0], z[0]), (b, y[0], z[1]), (a, y[0], z[1])])
        light.append(side * (DARKER if tile else 1.0))
        for c, d, row in zip(rows[:-1], rows[1:], row_odd, strict=True):
            quads.append([(a, c, z[1]), (b, c, z[1]), (b, d, z[1]), (a, d, z[1])])
            light.append(top * (DARKER if tile != row else 1.0))
    quads.append([(x[1], y[0], z[0]), (x[1], y[1], z[0]), (x[1], y[1], z[1]), (x[1], y[0], z[1])])
    light.append(end)
    return fans(np.array(quads), np.array(light), lens)


def fans(polygons: np.ndarray, colours: np.ndarray, lens: Lens, first: int = 0) -> Triangles:
    """Convex polygons as triangles on the screen.

    Args:
        polygons: World frame, in [m]. Shape (n, corners, 3).
        colours: In 0 to 255. Shape (n, 3).
        lens: Where to look from.
        first: Number of the first face.
    """
    seen = lens.see(polygons)
    ears = seen.shape[1] - 2
    corners = np.stack([np.repeat(seen[:, :1], ears, axis=1), seen[:, 1:-1], seen[:, 2:]], axis=2)
    return Triangles(
        corners.reshape(-1, 3, 3).astype(np.float32),
        np.repeat(colours, ears, axis=0).astype(np.uint8),
        np.repeat(np.arange(first, first + len(polygons), dtype=np.int32), ears),
    )


def _blades(
    turf: Turf, x: tuple[float, float], soles: Sequence[PressingSole], lens: Lens
) -> Triangles:
    """Blades as ribbons of two pieces that face the camera and end in a tip."""
    seen = slice(*np.searchsorted(turf.roots[:, 0], x))
    roots, height = turf.roots[seen], turf.height[seen]
    gap, outward = pressed(roots, soles)
    squeezed = gap < height
    top = np.where(squeezed, np.maximum(gap, 0.0), height)
    fold = 0.5 * np.sqrt(np.maximum(height**2 - top**2, 0.0))
    lean = np.where(squeezed[:, None], outward * fold[:, None], turf.lean[seen])
    shade = turf.shade[seen] * np.where(squeezed, 0.5, 1.0)
    green = 255.0 * (DARK_GREEN + shade[:, None] * (LIGHT_GREEN - DARK_GREEN))
    return Triangles(
        _ribbons(roots, lean, top, turf.width, lens).astype(np.float32),
        (PIECE_LIGHT[:, None] * green[:, None]).reshape(-1, 3).astype(np.uint8),
        np.zeros(3 * len(roots), np.int32),
    )


def _ribbons(
    roots: np.ndarray, lean: np.ndarray, top: np.ndarray, width: float, lens: Lens
) -> np.ndarray:
    """Three triangles a blade on the screen. Shape (3 n, 3, 3)."""
    spine = np.empty((len(roots), len(BEND), 3))
    spine[..., :2] = roots[:, None] + lean[:, None] * (BEND**2)[:, None]
    spine[..., 2] = top[:, None] * BEND
    side = 0.5 * width * TIP[:, None] * lens.camera.axes[0]
    left, right = lens.see(spine - side), lens.see(spine + side)
    lower = np.stack([left[:, 0], right[:, 0], right[:, 1]], axis=1)
    upper = np.stack([left[:, 0], right[:, 1], left[:, 1]], axis=1)
    tip = np.stack([left[:, 1], right[:, 1], left[:, 2]], axis=1)
    return np.stack([lower, upper, tip], axis=1).reshape(-1, 3, 3)
