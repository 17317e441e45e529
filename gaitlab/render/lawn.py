"""The ground of a picture: a board, and on it blades drawn to height, pressed under the soles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gaitlab.render.scene import Camera, Faces, box_faces, lit
from gaitlab.surfaces.surface import FibreMat, SoftLayer, Surface, TuftedPile

BOARD = 0.018  # m, thickness of the board below the pile
BOARD_COLOUR, EARTH, MAT_COLOUR, LAYER_COLOUR = "#B9AE9C", "#6B7A3F", "#3E7D4B", "#7DAA78"
MOST_BLADES = 9000  # in one picture; beyond it the eye sees no single blade
BLADES_A_TUFT = 3
JOINTS = 4  # of a drawn blade, root and tip included
DARK_GREEN, LIGHT_GREEN = np.array([0.16, 0.36, 0.13]), np.array([0.52, 0.72, 0.29])


@dataclass(frozen=True, kw_only=True)
class Patch:
    """A piece of ground, edges along x and y, in [m]."""

    x: tuple[float, float]
    y: tuple[float, float]

    @property
    def centre(self) -> tuple[float, float]:
        """Its middle."""
        return (sum(self.x) / 2.0, sum(self.y) / 2.0)

    @property
    def size(self) -> tuple[float, float]:
        """Lengths of its edges."""
        return (self.x[1] - self.x[0], self.y[1] - self.y[0])


@dataclass(frozen=True, kw_only=True, eq=False)
class PressingSole:
    """A sole that may press the pile.

    Attributes:
        centre: Centre of the sole, world frame, in [m]. Shape (3,).
        rotation: Of the foot in the world frame. Shape (3, 3).
        size: Length and width, in [m].
    """

    centre: np.ndarray
    rotation: np.ndarray
    size: tuple[float, float]


def ground_faces(
    surface: Surface, patch: Patch, soles: Sequence[PressingSole], camera: Camera
) -> list[Faces]:
    """Board and pile, deterministic: the same surface always grows the same blades."""
    board = _slab(patch, -BOARD, 0.0, BOARD_COLOUR)
    if isinstance(surface, SoftLayer):
        return [board, _slab(patch, 0.0, surface.height, LAYER_COLOUR)]
    if isinstance(surface, FibreMat):
        backing = _slab(patch, 0.0, 0.5 * surface.height, MAT_COLOUR)
        return [board, backing, _blades(surface, patch, soles, camera)]
    if isinstance(surface, TuftedPile):
        backing = _slab(patch, 0.0, 0.002, EARTH)
        return [board, backing, _blades(surface, patch, soles, camera)]
    return [board]


def _slab(patch: Patch, bottom: float, top: float, colour: str) -> Faces:
    centre = np.array([*patch.centre, 0.5 * (bottom + top)])
    faces = box_faces((*patch.size, top - bottom), centre, np.eye(3), colour)
    # A slab is sorted by its own middle, and everything else stands on top of it.
    return Faces(corners=faces.corners, colours=faces.colours, nearer=-10.0 + top, edge=0.4)


def _blades(
    surface: TuftedPile | FibreMat, patch: Patch, soles: Sequence[PressingSole], camera: Camera
) -> Faces:
    generator = np.random.default_rng(7)
    roots, width = _roots(surface, patch, generator)
    n = len(roots)
    height = surface.height * generator.uniform(0.82, 1.06, n)
    lean = _leans(surface, generator, n)
    gap, outward = pressed(roots, soles)
    squeezed = gap < height
    top = np.where(squeezed, np.maximum(gap, 0.0), height)
    fold = np.sqrt(np.maximum(height**2 - top**2, 0.0)) * 0.5
    lean = np.where(squeezed[:, None], outward * fold[:, None], lean * height[:, None])
    corners = _ribbons(roots, lean, top, width, camera)
    shade = generator.uniform(0.0, 1.0, n) ** 1.5 * np.where(squeezed, 0.5, 1.0)
    colours = DARK_GREEN + shade[:, None] * (LIGHT_GREEN - DARK_GREEN)
    return Faces(corners=corners, colours=colours * lit("white", np.array([[0, 0, 1.0]])))


def _roots(
    surface: TuftedPile | FibreMat, patch: Patch, generator: np.random.Generator
) -> tuple[np.ndarray, float]:
    """Feet of the blades (n, 2) and the width to draw them, thinned to what the eye resolves."""
    spacing = surface.spacing if isinstance(surface, TuftedPile) else 0.75 * surface.height
    a_tuft = BLADES_A_TUFT if isinstance(surface, TuftedPile) else 1
    x, y = (np.arange(low, high, spacing) for low, high in (patch.x, patch.y))
    tufts = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    roots = np.repeat(tufts, a_tuft, axis=0)
    roots = roots + generator.uniform(-0.4, 0.4, roots.shape) * spacing
    width = surface.blade_width if isinstance(surface, TuftedPile) else 0.3 * surface.height
    kept = min(1.0, MOST_BLADES / len(roots))
    chosen = generator.uniform(size=len(roots)) < kept
    return roots[chosen], width / np.sqrt(kept)


def _leans(surface: TuftedPile | FibreMat, generator: np.random.Generator, n: int) -> np.ndarray:
    """Horizontal offset of the tips over the height, more and in all directions on rough grass."""
    angle = generator.uniform(-np.pi, np.pi, n)
    amount = generator.uniform(0.05, 0.35, n)
    nap = surface.nap * np.array([np.cos(surface.nap_direction), np.sin(surface.nap_direction)])
    return amount[:, None] * np.column_stack([np.cos(angle), np.sin(angle)]) + 2.0 * nap


def pressed(roots: np.ndarray, soles: Sequence[PressingSole]) -> tuple[np.ndarray, np.ndarray]:
    """Height left below the soles over each root (inf beside them), and the way out from below."""
    gap, outward = np.full(len(roots), np.inf), np.zeros_like(roots)
    for sole in soles:
        ahead, across = sole.rotation[:2, 0], sole.rotation[:2, 1]
        offset = roots - sole.centre[:2]
        u, v = offset @ ahead, offset @ across
        below = (np.abs(u) < 0.5 * sole.size[0]) & (np.abs(v) < 0.5 * sole.size[1])
        height = sole.centre[2] + u * sole.rotation[2, 0] + v * sole.rotation[2, 1]
        lower = below & (height < gap)
        gap[lower] = height[lower]
        outward[lower] = offset[lower] / np.linalg.norm(offset[lower] + 1e-9, axis=1)[:, None]
    return gap, outward


def _ribbons(
    roots: np.ndarray, lean: np.ndarray, top: np.ndarray, width: float, camera: Camera
) -> np.ndarray:
    """Blades as curved ribbons that face the camera and end in a tip. Shape (n, corners, 3)."""
    s = np.linspace(0.0, 1.0, JOINTS)
    spine = np.empty((len(roots), JOINTS, 3))
    spine[..., :2] = roots[:, None] + lean[:, None] * (s**2)[:, None]
    spine[..., 2] = top[:, None] * s
    side = 0.5 * width * (1.0 - 0.85 * s**2)[:, None] * camera.axes[0]
    return np.concatenate([spine - side, (spine + side)[:, ::-1]], axis=1)
