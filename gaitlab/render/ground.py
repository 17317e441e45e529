"""The ground of a picture: a board, and on it blades drawn to height, pressed under the soles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gaitlab.render.camera import Camera
from gaitlab.render.raster import Triangles
from gaitlab.render.scene import SolePose, lit
from gaitlab.surfaces.surface import FibreMat, SoftLayer, Surface, TuftedPile

BOARD_COLOUR, MAT_COLOUR, LAYER_COLOUR = "#B9AE9C", "#3E7D4B", "#7DAA78"
THATCH = "#4A7530"  # what shows between the blades
DARK_GREEN, LIGHT_GREEN = np.array([0.16, 0.36, 0.13]), np.array([0.52, 0.72, 0.29])
TILE = 0.1  # m, what is light and dark in turns along the board
DARKER = 0.86  # brightness of every second tile
BOARD = 0.05  # thickness of the board over its width
BLADES_A_TUFT = 3
WIDER = 0.58  # power of the thinning by which blades widen; 1 would cover as much ground
BEND = np.array([0.0, 0.55, 1.0])  # where along a blade its drawn joints are
TIP = np.array([1.0, 0.75, 0.0])  # width of a blade there
PIECE_LIGHT = np.array([0.66, 0.66, 1.0])  # the lower piece of a blade stands in the shade


@dataclass(frozen=True, kw_only=True)
class Patch:
    """A piece of ground, edges along x and y, in [m]."""

    x: tuple[float, float]
    y: tuple[float, float]

    @property
    def centre(self) -> np.ndarray:
        """Its middle, in [m]. Shape (2,)."""
        return np.array([sum(self.x), sum(self.y)]) / 2.0

    @property
    def thickness(self) -> float:
        """Of the board below it, in [m]."""
        return BOARD * (self.y[1] - self.y[0])


@dataclass(frozen=True, kw_only=True, eq=False)
class Lawn:
    """A surface and the blades that grow on it, rooted in the world; a bare surface has none.

    Attributes:
        surface: What the ground is.
        patch: Where it is.
        roots: Feet of the blades, ordered along x, in [m]. Shape (n, 2).
        height: Of the blades, in [m]. Shape (n,).
        lean: Horizontal offset of their tips, in [m]. Shape (n, 2).
        shade: Of their green, dark 0 to light 1. Shape (n,).
        width: Of a drawn blade, in [m].
    """

    surface: Surface
    patch: Patch
    roots: np.ndarray
    height: np.ndarray
    lean: np.ndarray
    shade: np.ndarray
    width: float


def grown(surface: Surface, patch: Patch, densest: float) -> Lawn:
    """A lawn, deterministic: the same surface always grows the same blades.

    Args:
        surface: The ground.
        patch: Where it grows.
        densest: Blades that may be drawn on a square metre; beyond it the eye sees no single one.
    """
    generator = np.random.default_rng(7)
    roots, width = _roots(surface, patch, densest, generator)
    n = len(roots)
    height = surface.height * generator.uniform(0.82, 1.06, n)
    angle, amount = generator.uniform(-np.pi, np.pi, n), generator.uniform(0.05, 0.35, n)
    leans = amount[:, None] * np.column_stack([np.cos(angle), np.sin(angle)]) + nap_of(surface)
    lean = leans * height[:, None]
    shade = generator.uniform(0.0, 1.0, n) ** 1.5
    return Lawn(
        surface=surface,
        patch=patch,
        roots=roots,
        height=height,
        lean=lean,
        shade=shade,
        width=width,
    )


def pile_of(surface: Surface) -> tuple[float, float]:
    """Blades on a square metre and the width of one in [m], both 0 where nothing stands up."""
    if isinstance(surface, TuftedPile):
        return BLADES_A_TUFT / surface.spacing**2, surface.blade_width
    if isinstance(surface, FibreMat):
        return 1.0 / (0.75 * surface.height) ** 2, 0.3 * surface.height
    return 0.0, 0.0


def nap_of(surface: Surface) -> np.ndarray:
    """Horizontal offset of the tips over the height of a blade, common to all. Shape (2,)."""
    if not isinstance(surface, TuftedPile | FibreMat):
        return np.zeros(2)
    direction = surface.nap_direction
    return 2.0 * surface.nap * np.array([np.cos(direction), np.sin(direction)])


def _roots(
    surface: Surface, patch: Patch, densest: float, generator: np.random.Generator
) -> tuple[np.ndarray, float]:
    """Feet of the blades and the width to draw them, thinned to what the eye resolves."""
    density, width = pile_of(surface)
    if not density:
        return np.empty((0, 2)), 0.0
    thinner = max(1.0, density / densest)
    step = np.sqrt(thinner / density)
    x, y = (np.arange(low, high, step) for low, high in (patch.x, patch.y))
    grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    roots = grid + generator.uniform(-0.7, 0.7, grid.shape) * step
    roots[:, 1] = np.clip(roots[:, 1], *patch.y)
    return roots[np.argsort(roots[:, 0], kind="stable")], width * thinner**WIDER


def ground_triangles(
    lawn: Lawn, patch: Patch, soles: Sequence[SolePose], camera: Camera
) -> list[Triangles]:
    """Board and pile of a patch, on the screen."""
    surface = lawn.surface
    parts = [_slab(patch, -patch.thickness, 0.0, BOARD_COLOUR, camera)]
    if isinstance(surface, SoftLayer):
        parts.append(_slab(patch, 0.0, surface.height, LAYER_COLOUR, camera))
    elif isinstance(surface, FibreMat):
        parts.append(_slab(patch, 0.0, 0.5 * surface.height, MAT_COLOUR, camera))
    elif isinstance(surface, TuftedPile):
        parts.append(_slab(patch, 0.0, 0.002, THATCH, camera))
    if len(lawn.roots):
        spine, colours = blades(lawn, patch, soles)
        side = 0.5 * lawn.width * TIP[:, None] * camera.axes[0]
        left, right = camera.see(spine - side), camera.see(spine + side)
        lower = np.stack([left[:, 0], right[:, 0], right[:, 1]], axis=1)
        upper = np.stack([left[:, 0], right[:, 1], left[:, 1]], axis=1)
        tip = np.stack([left[:, 1], right[:, 1], left[:, 2]], axis=1)
        ribbons = np.stack([lower, upper, tip], axis=1).reshape(-1, 3, 3)
        corners = ribbons.astype(np.float32)
        light = (255.0 * PIECE_LIGHT[:, None] * colours[:, None]).reshape(-1, 3).astype(np.uint8)
        parts.append(Triangles(corners, light, np.zeros(len(corners), np.int32)))
    return parts


def _slab(patch: Patch, bottom: float, top: float, colour: str, camera: Camera) -> Triangles:
    """Top, right side and front end of a slab, in tiles that stay where they are in the world."""
    (x0, x1), (y0, y1) = patch.x, patch.y
    above, side, end = lit(colour, np.array([[0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]]))
    columns, rows = _tiles(x0, x1), _tiles(y0, y1)
    quads, light = [[(x1, y0, bottom), (x1, y1, bottom), (x1, y1, top), (x1, y0, top)]], [end]
    for a, b, column in columns:
        quads.append([(a, y0, bottom), (b, y0, bottom), (b, y0, top), (a, y0, top)])
        light.append(side * (DARKER if column else 1.0))
        for c, d, row in rows:
            quads.append([(a, c, top), (b, c, top), (b, d, top), (a, d, top)])
            light.append(above * (DARKER if column != row else 1.0))
    return camera.triangles(np.array(quads), 255.0 * np.array(light))


def _tiles(low: float, high: float) -> list[tuple[float, float, bool]]:
    """Both ends of each tile between two places, in [m], and whether its number is odd."""
    inner = np.arange(np.ceil(low / TILE), np.ceil(high / TILE)) * TILE
    edges = np.unique(np.clip([low, *inner, high], low, high))
    odd = np.floor(0.5 * (edges[1:] + edges[:-1]) / TILE) % 2 == 1
    return list(zip(edges[:-1].tolist(), edges[1:].tolist(), odd.tolist(), strict=True))


def blades(lawn: Lawn, patch: Patch, soles: Sequence[SolePose]) -> tuple[np.ndarray, np.ndarray]:
    """Blades of a patch, those below a sole bent down to it.

    Returns:
        Their joints from root to tip, in [m], and their colours in [0, 1].
            Shapes (n, joints, 3) and (n, 3).
    """
    part = np.arange(*np.searchsorted(lawn.roots[:, 0], patch.x))
    y = lawn.roots[part, 1]
    part = part[(y >= patch.y[0]) & (y <= patch.y[1])]
    roots, height = lawn.roots[part], lawn.height[part]
    gap, outward = _pressed(roots, soles)
    squeezed = gap < height
    top = np.where(squeezed, np.maximum(gap, 0.0), height)
    fold = 0.5 * np.sqrt(np.maximum(height**2 - top**2, 0.0))
    lean = np.where(squeezed[:, None], outward * fold[:, None], lawn.lean[part])
    spine = np.empty((len(roots), len(BEND), 3))
    spine[..., :2] = roots[:, None] + lean[:, None] * (BEND**2)[:, None]
    spine[..., 2] = top[:, None] * BEND
    shade = lawn.shade[part] * np.where(squeezed, 0.5, 1.0)
    return spine, DARK_GREEN + shade[:, None] * (LIGHT_GREEN - DARK_GREEN)


def _pressed(roots: np.ndarray, soles: Sequence[SolePose]) -> tuple[np.ndarray, np.ndarray]:
    """Height left below the soles over each root (inf beside them), and the way out from below."""
    gap, outward = np.full(len(roots), np.inf), np.zeros_like(roots)
    for sole in soles:
        offset = roots - sole.centre[:2]
        u, v = offset @ sole.rotation[:2, 0], offset @ sole.rotation[:2, 1]
        below = (np.abs(u) < 0.5 * sole.size[0]) & (np.abs(v) < 0.5 * sole.size[1])
        height = sole.centre[2] + u * sole.rotation[2, 0] + v * sole.rotation[2, 1]
        lower = below & (height < gap)
        gap[lower] = height[lower]
        outward[lower] = offset[lower] / np.linalg.norm(offset[lower] + 1e-9, axis=1)[:, None]
    return gap, outward
