"""Surfaces by name: `surfaces/*.yaml`, and a user's own files."""

from __future__ import annotations

from pathlib import Path

from gaitlab.documents import Node, build, load
from gaitlab.errors import FileError
from gaitlab.plugins import locate, suggestion
from gaitlab.surfaces.surface import SURFACE_TYPES, Surface


def load_surface(name: str, relative_to: Path | None = None) -> Surface:
    """Surface of a name or a file; every number checked for unit and range.

    Args:
        name: Name of a file in `surfaces/`, or a .yaml file of the user's own.
        relative_to: Folder that a relative file starts from; the working directory by default.

    Raises:
        UnknownName: If there is no such surface.
        FileError: If its file is wrong.
    """
    return surface_from(load(locate("surface", name, relative_to)))


def surface_from(node: Node) -> Surface:
    """Surface of a mapping whose `type` names the class and whose other keys are its fields."""
    kind = node.mapping.get("type")
    if kind is None:
        known = ", ".join(SURFACE_TYPES)
        raise FileError([node.problem(f"'type' is missing; add `type:` with one of: {known}")])
    if not isinstance(kind.value, str) or kind.value not in SURFACE_TYPES:
        hint = suggestion(str(kind.value), SURFACE_TYPES)
        raise FileError([kind.problem(f"type: found {kind.found()}{hint}")])
    surface: Surface = build(SURFACE_TYPES[kind.value], node, skip=("type", "description"))
    return surface
