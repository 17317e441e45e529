"""Ground: what a surface is made of, and how it pushes back.

The laws of pile, mat and layer as functions, and the types that `surfaces/*.yaml` fill. Contacts
of the engine are in `gaitlab.simulation`.
"""

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
