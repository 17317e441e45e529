"""Ground: what a surface is made of, and how it pushes back."""

from gaitlab.surfaces.pile import PileLaw
from gaitlab.surfaces.surface import (
    SURFACE_TYPES,
    FibreMat,
    RigidFloor,
    SoftLayer,
    Surface,
    TuftedPile,
)

__all__ = [
    "SURFACE_TYPES",
    "FibreMat",
    "PileLaw",
    "RigidFloor",
    "SoftLayer",
    "Surface",
    "TuftedPile",
]
