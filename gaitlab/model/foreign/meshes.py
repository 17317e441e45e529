"""Vertices of a foreign body: of its boxes and balls, and of the mesh files that its URDF names.

A mesh is looked for in the URDF's folder and in those above it, as far as the package that holds
it, and nowhere else: whatever the file says, nothing outside that tree is opened. Of a mesh the
convex hull is kept. A mesh that is missing or cannot be read is no error: masses and axes do not
depend on it, so what is known is given and the fault is noted.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, MutableSequence, Sequence
from functools import lru_cache
from pathlib import Path
from posixpath import normpath
from typing import NamedTuple

import numpy as np

from gaitlab.errors import GaitlabError
from gaitlab.model.foreign.reading import Bodies, Body, some
from gaitlab.model.foreign.sole import UP, corners

PARENTS = 4  # folders above the URDF's that may hold its meshes
PACKAGE_ROOTS = ("package.xml", ".git")  # what lies in the uppermost folder of a package
READABLE = (".stl", ".obj")
LARGEST = 200_000_000  # bytes of a mesh; scans and drawings are thinned before they are simulated
LFS = b"version https://git-lfs"
MOST_POINTS = 200_000  # of which a hull is made within seconds
GRID = 5e-4  # m; of more points, one in each cell of this size is kept
MOST_VERTICES = 2_000  # of a hull; 0.3 mm are lost on a ball of 0.1 m radius


class MeshFault(NamedTuple):
    """What is wrong with a mesh.

    Attributes:
        mesh: As the URDF calls it.
        why: What is wrong and what to do: a clause, equal for meshes with the same fault.
    """

    mesh: str
    why: str


class UnreadableMesh(GaitlabError):
    """A mesh file has no vertices to give; the message is a clause that says why."""

    exit_code = 3


def vertices_of_all(
    robot: Bodies, file: Path, faults: MutableSequence[MeshFault]
) -> list[np.ndarray]:
    """Vertices of every body in its own frame, in [m]. Shapes (n, 3).

    Args:
        robot: The bodies; their root's z is up.
        file: URDF that they stand in.
        faults: Takes what is wrong with their meshes.
    """
    ups = robot.at_zero[1][:, 2]  # the root's z in each body's frame
    return [vertices_of(b, file, faults, up) for b, up in zip(robot.bodies, ups, strict=True)]


def vertices_of(
    body: Body, file: Path, faults: MutableSequence[MeshFault], up: np.ndarray = UP
) -> np.ndarray:
    """Vertices of a body in its own frame, in [m]. Shape (n, 3), without any for want of geometry.

    What is there to be touched counts; what is there to be seen, if that gives nothing.

    Args:
        body: The body.
        file: URDF that it stands in.
        faults: Takes what is wrong with its meshes.
        up: What is up at zero angles, in the body's frame. Shape (3,).
    """
    for collision in (True, False):
        shapes = [shape for shape in body.shapes if shape.collision is collision]
        vertices = [corners(shapes, up)]
        for shape in shapes:
            if shape.kind != "mesh":
                continue
            path = find_mesh(shape.mesh, file, faults)
            if path is None:
                continue
            scale = (shape.size[0], shape.size[1], shape.size[2])
            try:
                hull = hull_of(path, scale)
            except UnreadableMesh as error:
                faults.append(MeshFault(shape.mesh, str(error)))
            else:
                vertices.append(shape.position + hull @ shape.rotation.T)
        found = np.concatenate(vertices)
        if len(found):
            return found
    return np.empty((0, 3))


def sentences(faults: Sequence[MeshFault]) -> tuple[str, ...]:
    """A sentence for each kind of fault, with the meshes that have it."""
    meshes: dict[str, dict[str, str]] = {}
    for mesh, why in faults:
        meshes.setdefault(why, {})[mesh] = mesh.replace("\\", "/").rpartition("/")[2]
    return tuple(
        f"{some([*names.values()], 'mesh', 'meshes')}: {why}" for why, names in meshes.items()
    )


def find_mesh(name: str, file: Path, faults: MutableSequence[MeshFault]) -> Path | None:
    """The file of a mesh, without links; None if it is not where it may be.

    Leading parts of the name are left out one by one, for a package is seldom where its author had
    it: `package://pkg/meshes/a.stl` may be `../meshes/a.stl`, and so may `/home/me/meshes/a.stl`.

    Args:
        name: As in the URDF: a path, or a URI of a package or a file.
        file: The URDF.
        faults: Takes what is wrong: not found, outside the tree, other letter case.
    """
    folders = _folders(file)
    parts = normpath(re.sub(r"^\w+://", "", name.replace("\\", "/"))).strip("/").split("/")
    above = sum(part == ".." for part in parts)  # only in front, in a normal path
    starts = [*folders[above : above + 1], *folders]
    places = [(folder, parts[k:]) for k in range(above, len(parts)) for folder in starts]
    outside = False
    for exactly in (True, False):
        for folder, rest in places:
            found = _inside(folder, rest, exactly)
            if found is None:
                continue
            if not found.is_relative_to(folders[-1]):
                outside = True
                continue
            if not exactly:
                why = "found in other letter case, which other computers do not find; rename one"
                faults.append(MeshFault(name, why))
            return found
    if outside:
        why = f"a link leads out of {folders[-1]}, where no mesh is read; copy the mesh there"
    else:
        why = f"not beside {file.name} nor in a folder above it; copy the folder of meshes there"
    faults.append(MeshFault(name, why))
    return None


def _folders(file: Path) -> list[Path]:
    """The URDF's folder and those above it that may hold its meshes; the last is the largest."""
    own = file.resolve().parent
    folders = [own]
    for parent in own.parents[:PARENTS]:
        if any((folders[-1] / root).exists() for root in PACKAGE_ROOTS):
            break
        if parent == Path(parent.anchor) or Path.home().resolve().is_relative_to(parent):
            break
        folders.append(parent)
    return folders


def _inside(folder: Path, parts: Sequence[str], exactly: bool) -> Path | None:
    """A file below a folder, without links; None if there is none."""
    path = folder
    for part in parts:
        step = path / part
        if not exactly and not os.path.lexists(step):
            step = next(_same_name(path, part), step)
        path = step
    return path.resolve() if os.path.isfile(path) else None


def _same_name(folder: Path, name: str) -> Iterator[Path]:
    try:
        entries = sorted(os.listdir(folder))
    except OSError:
        return
    yield from (folder / entry for entry in entries if entry.casefold() == name.casefold())


def hull_of(path: Path, scale: tuple[float, float, float] = (1.0, 1.0, 1.0)) -> np.ndarray:
    """Vertices of the convex hull of an STL or OBJ file, in [m]. Shape (n, 3), not to be written.

    All of them up to `MOST_VERTICES`; beyond, those that lie farthest in as many directions. A mesh
    that is flat has no hull; its own vertices come back.

    Args:
        path: The mesh.
        scale: By which its coordinates are multiplied to be in [m].

    Raises:
        UnreadableMesh: If it is empty, broken, too large, fetched by halves, or of another kind.
    """
    try:
        state = path.stat()
        return _hull(path, scale, state.st_mtime_ns, state.st_size)
    except OSError as error:
        raise UnreadableMesh(f"cannot be opened ({error.strerror}); see to its rights") from error


@lru_cache(maxsize=256)
def _hull(
    path: Path, scale: tuple[float, float, float], _modified: int, size: int
) -> np.ndarray:  # what has changed on the disk is read again
    from scipy.spatial import ConvexHull, QhullError

    points = _thinned(_points(path, size) * scale)
    try:
        points = points[ConvexHull(points).vertices]
    except (QhullError, ValueError):  # fewer than four, or all in a plane
        points = np.unique(points, axis=0)
    points = _outermost(points) if len(points) > MOST_VERTICES else points
    points.setflags(write=False)
    return points


def _points(path: Path, size: int) -> np.ndarray:
    """Vertices of the faces of a mesh, in its own unit. Shape (n, 3)."""
    kind = path.suffix.lower()
    if kind not in READABLE:
        raise UnreadableMesh(f"a {kind or 'nameless'} file is not read; convert it to STL")
    if size > LARGEST:
        raise UnreadableMesh(
            f"larger than {LARGEST / 1e6:g} MB; thin it out, one of 10 000 triangles will do"
        )
    with path.open("rb") as stream:
        if stream.read(len(LFS)) == LFS:
            raise UnreadableMesh("a Git LFS pointer and not the mesh; fetch it by `git lfs pull`")
        stream.seek(0)
        import trimesh

        try:
            mesh = trimesh.load_mesh(stream, file_type=kind[1:], process=False, skip_materials=True)
            used = np.zeros(len(mesh.vertices), dtype=bool)
            used[mesh.faces] = True
            points = np.asarray(mesh.vertices, dtype=float)[used]
        except Exception as error:  # a reader may stumble over anything in a broken file
            raise UnreadableMesh(f"broken, no {kind[1:].upper()}; export it again") from error
    if not len(points) or not np.isfinite(points).all():
        raise UnreadableMesh("without triangles, or with points at no place; export it again")
    return points


def _thinned(points: np.ndarray) -> np.ndarray:
    """At most `MOST_POINTS` of the points: one in each cell of a grid that is fine enough."""
    low, extent = points.min(axis=0), float(np.ptp(points, axis=0).max())
    if extent == 0.0:
        return points[:1]
    cell = extent / 2**20  # equal points alone, at first
    while len(points) > MOST_POINTS:
        cells = ((points - low) / cell).astype(np.int64) @ np.array([1, 2**21, 2**42])
        points = points[np.unique(cells, return_index=True)[1]]
        cell = max(GRID, 2.0 * cell)
    return points


def _outermost(points: np.ndarray) -> np.ndarray:
    """The points that lie farthest in each of many directions, evenly over the sphere."""
    k = np.arange(MOST_VERTICES) + 0.5
    turn, z = k * np.pi * (3.0 - np.sqrt(5.0)), 1.0 - 2.0 * k / MOST_VERTICES
    across = np.sqrt(1.0 - z**2)
    directions = np.column_stack([across * np.cos(turn), across * np.sin(turn), z])
    farthest = [np.argmax(part @ points.T, axis=1) for part in np.split(directions, 100)]
    return points[np.unique(np.concatenate(farthest))]
