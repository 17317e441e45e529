"""Meshes of a foreign robot: found where they may be and nowhere else, read as their hulls."""

from __future__ import annotations

import os
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gaitlab.kinematics.transforms import axis_rotation
from gaitlab.model.foreign.meshes import (
    MOST_VERTICES,
    MeshFault,
    UnreadableMesh,
    find_mesh,
    hull_of,
    sentences,
    vertices_of,
)  # fmt: skip
from gaitlab.model.foreign.reading import Body, Geometry, read_urdf
from gaitlab.model.urdf import urdf
from gaitlab.robots import eros

CUBE = np.array(np.meshgrid([-1.0, 1.0], [-2.0, 2.0], [-3.0, 3.0])).reshape(3, -1).T
FACES = np.array(
    [[0, 1, 3], [0, 3, 2], [4, 7, 5], [4, 6, 7], [0, 4, 5], [0, 5, 1],
     [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]
)  # fmt: skip
TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def binary_stl(triangles: np.ndarray) -> bytes:
    data = np.zeros(len(triangles), dtype=TRIANGLE)
    data["corners"] = triangles
    return bytes(80) + np.uint32(len(triangles)).tobytes() + data.tobytes()


def ascii_stl(triangles: np.ndarray) -> bytes:
    facets = "".join(
        "facet normal 0 0 0\nouter loop\n"
        + "".join("vertex {} {} {}\n".format(*corner) for corner in triangle)
        + "endloop\nendfacet\n"
        for triangle in triangles
    )
    return f"solid cube\n{facets}endsolid cube\n".encode()


def obj(corners: np.ndarray, faces: np.ndarray) -> bytes:
    rows = [*("v {} {} {}".format(*c) for c in corners), "mtllib ../../secret.mtl"]
    return "\n".join([*rows, *("f {} {} {}".format(*face) for face in faces + 1)]).encode()


FILES = {
    "binary.stl": binary_stl(CUBE[FACES]),
    "ascii.STL": ascii_stl(CUBE[FACES]),
    "text.obj": obj(np.vstack([CUBE, [[9.0, 9.0, 9.0]]]), FACES),  # the last is in no face
}


def put(path: Path, data: bytes = FILES["binary.stl"]) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(data)
    return path


def ordered(points: np.ndarray) -> np.ndarray:
    return points[np.lexsort(np.round(points, 9).T)]


def cut(shapes: list[Geometry]) -> Body:
    """A body of these shapes."""
    trunk = read_urdf(urdf(eros.Robot().tree, eros.Robot().sole, eros.Robot().feet), Path("r"))
    return replace(trunk.bodies[0], shapes=tuple(shapes))


def mesh(name: str, collision: bool = True, **changes) -> Geometry:
    shape = Geometry("mesh", (1.0, 1.0, 1.0), name, np.zeros(3), np.eye(3), collision)
    return shape._replace(**changes)


NAMES = [
    ("package://pkg/meshes/a.stl", "pkg/meshes/a.stl"),
    ("package://other/meshes/a.stl", "pkg/meshes/a.stl"),
    ("package:///a.stl", "pkg/urdf/a.stl"),
    ("package://meshes/../parts/a.stl", "pkg/parts/a.stl"),
    ("package://meshes/a.stl", "pkg/meshes/a.stl"),
    ("file:///home/me/src/pkg/meshes/a.stl", "pkg/meshes/a.stl"),
    ("/home/me/src/pkg/meshes/a.stl", "pkg/meshes/a.stl"),
    ("file://$(find pkg)/meshes/a.stl", "pkg/meshes/a.stl"),
    ("../meshes/a.stl", "pkg/meshes/a.stl"),
    ("..\\meshes\\a.stl", "pkg/meshes/a.stl"),
    ("./parts/a.stl", "pkg/urdf/parts/a.stl"),
    ("a.stl", "pkg/urdf/a.stl"),
]


@pytest.mark.parametrize(("name", "place"), NAMES)
def test_a_mesh_is_found_beside_the_urdf_or_above(tmp_path: Path, name: str, place: str) -> None:
    there = put(tmp_path / place)
    file = put(tmp_path / "pkg/urdf/robot.urdf", b"")
    faults: list[MeshFault] = []
    assert find_mesh(name, file, faults) == there.resolve()
    assert faults == []


def test_the_folder_that_a_name_steps_up_to_comes_first(tmp_path: Path) -> None:
    put(tmp_path / "pkg/urdf/meshes/a.stl")
    meant = put(tmp_path / "pkg/meshes/a.stl")
    assert find_mesh("../meshes/a.stl", tmp_path / "pkg/urdf/robot.urdf", []) == meant.resolve()


@pytest.mark.parametrize("mark", ["package.xml", ".git"])
@pytest.mark.parametrize("name", ["a.stl", "../../a.stl", "package://pkg/../../a.stl", "ABSOLUTE"])
def test_nothing_outside_the_package_is_a_mesh(tmp_path: Path, name: str, mark: str) -> None:
    secret = put(tmp_path / "a.stl")
    put(tmp_path / "pkg" / mark, b"")
    faults: list[MeshFault] = []
    name = str(secret) if name == "ABSOLUTE" else name
    assert find_mesh(name, tmp_path / "pkg/urdf/robot.urdf", faults) is None
    assert [fault.mesh for fault in faults] == [name]


def test_no_more_than_four_folders_above_are_looked_into(tmp_path: Path) -> None:
    put(tmp_path / "a.stl")
    assert find_mesh("a.stl", tmp_path / "1/2/3/4/robot.urdf", []) is not None
    assert find_mesh("a.stl", tmp_path / "1/2/3/4/5/robot.urdf", []) is None


def test_the_home_folder_is_not_looked_into_from_below(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HOME", str(tmp_path / "me"))
    put(tmp_path / "me/a.stl")
    put(tmp_path / "b.stl")
    for name in ("a.stl", "b.stl", "../a.stl", str(tmp_path / "me/a.stl")):
        assert find_mesh(name, tmp_path / "me/robot/robot.urdf", []) is None
    assert find_mesh("a.stl", tmp_path / "me/robot.urdf", []) is not None


def test_a_link_is_followed_inside_the_tree_alone(tmp_path: Path) -> None:
    put(tmp_path / "pkg/package.xml", b"")
    (tmp_path / "pkg/urdf").mkdir()
    inside, outside = put(tmp_path / "pkg/meshes/a.stl"), put(tmp_path / "secret.stl")
    os.symlink(inside, tmp_path / "pkg/urdf/in.stl")
    os.symlink(outside, tmp_path / "pkg/urdf/out.stl")
    os.symlink(tmp_path, tmp_path / "pkg/urdf/up")
    file, faults = tmp_path / "pkg/urdf/robot.urdf", list[MeshFault]()
    assert find_mesh("in.stl", file, faults) == inside.resolve()
    assert faults == []
    assert find_mesh("out.stl", file, faults) is None
    assert find_mesh("up/secret.stl", file, faults) is None
    assert [fault.mesh for fault in faults] == ["out.stl", "up/secret.stl"]
    assert str((tmp_path / "pkg").resolve()) in faults[0].why


def test_a_urdf_that_is_a_link_has_its_meshes_where_it_is(tmp_path: Path) -> None:
    there = put(tmp_path / "source/pkg/meshes/a.stl")
    real = put(tmp_path / "source/pkg/urdf/robot.urdf", b"")
    (tmp_path / "install").mkdir()
    os.symlink(real, tmp_path / "install/robot.urdf")
    assert find_mesh("package://pkg/meshes/a.stl", tmp_path / "install/robot.urdf", []) == there


def test_other_letter_case_is_found_and_said(tmp_path: Path) -> None:
    there = put(tmp_path / "Meshes/l_foot.STL")
    faults: list[MeshFault] = []
    assert find_mesh("package://p/meshes/L_Foot.stl", tmp_path / "r.urdf", faults) == there
    assert "case" in faults[0].why
    exact = put(tmp_path / "Meshes/L_FOOT.stl")
    faults.clear()
    assert find_mesh("Meshes/L_FOOT.stl", tmp_path / "r.urdf", faults) == exact
    assert faults == []


@pytest.mark.parametrize(
    "name", ["", "/", "..", "package://", "a" * 5000, "x\0.stl", "http://h/a.stl"]
)
def test_what_names_no_file_is_missing(tmp_path: Path, name: str) -> None:
    faults: list[MeshFault] = []
    assert find_mesh(name, tmp_path / "robot.urdf", faults) is None
    assert len(faults) == 1


@pytest.mark.parametrize("name", FILES)
@pytest.mark.parametrize("scale", [(1.0, 1.0, 1.0), (0.001, 0.001, 0.001), (1.0, -0.5, 2.0)])
def test_a_mesh_is_its_hull_by_scale(tmp_path: Path, name: str, scale) -> None:
    inner = 0.5 * CUBE[FACES]
    data = binary_stl(np.concatenate([CUBE[FACES], inner])) if name == "binary.stl" else FILES[name]
    hull = hull_of(put(tmp_path / name, data), scale)
    assert np.allclose(ordered(hull), ordered(CUBE * scale), atol=1e-9)
    with pytest.raises(ValueError, match="read-only"):
        hull[0] = 0.0


def test_a_flat_mesh_is_its_own_corners(tmp_path: Path) -> None:
    flat = CUBE[FACES] * [1.0, 1.0, 0.0]
    hull = hull_of(put(tmp_path / "flat.stl", binary_stl(flat)))
    assert {tuple(np.abs(point)) for point in hull} == {(1.0, 2.0, 0.0)}


def test_a_mesh_that_has_changed_is_read_again(tmp_path: Path) -> None:
    path = put(tmp_path / "a.stl")
    assert np.ptp(hull_of(path), axis=0)[2] == pytest.approx(6.0)
    os.utime(put(path, binary_stl(2.0 * CUBE[FACES])), ns=(1, 1))
    assert np.ptp(hull_of(path), axis=0)[2] == pytest.approx(12.0)
    assert hull_of(path) is hull_of(path)


UNREADABLE = [
    ("a.stl", b"version https://git-lfs.github.com/spec/v1\noid sha256:12\nsize 1\n", "git lfs"),
    ("a.obj", b"version https://git-lfs.github.com/spec/v1\noid sha256:12\nsize 1\n", "git lfs"),
    ("a.stl", b"", "without triangles"),
    ("a.stl", b"solid nothing\nendsolid nothing\n", "without triangles"),
    ("a.stl", bytes(84), "without triangles"),
    ("a.stl", FILES["binary.stl"][:-7], "broken"),
    ("a.stl", b"\x00\xff" * 500, "broken"),
    ("a.obj", b"v 1 2 3\nf 1 2 99\n", "broken"),
    ("a.obj", b"", "without triangles"),
    ("a.obj", b"nothing", "without triangles"),
    ("a.stl", binary_stl(np.full((4, 3, 3), np.nan)), "no place"),
    ("a.dae", b"<COLLADA/>", "convert"),
    ("a", b"", "convert"),
]


@pytest.mark.parametrize(("name", "data", "words"), UNREADABLE)
def test_a_mesh_without_vertices_says_why(tmp_path: Path, name: str, data: bytes, words) -> None:
    with pytest.raises(UnreadableMesh, match=words):
        hull_of(put(tmp_path / name, data))


def test_a_mesh_is_not_read_if_it_is_huge(tmp_path: Path) -> None:
    path = put(tmp_path / "a.stl")
    os.truncate(path, 201_000_000)  # nothing is written: the file has a hole
    with pytest.raises(UnreadableMesh, match="200 MB"):
        hull_of(path)


def test_a_million_triangles_are_a_hull_within_seconds(tmp_path: Path) -> None:
    radius, n = 0.1, 1000
    turn, down = np.meshgrid(np.linspace(0, 2 * np.pi, n + 1), np.linspace(0, np.pi, n // 2 + 1))
    at = radius * np.stack(
        [np.cos(turn) * np.sin(down), np.sin(turn) * np.sin(down), np.cos(down)], axis=-1
    )
    corners = at[:-1, :-1], at[:-1, 1:], at[1:, 1:], at[1:, :-1]
    halves = [np.stack([corners[0], corners[k], corners[k + 1]], axis=-2) for k in (1, 2)]
    triangles = np.concatenate([half.reshape(-1, 3, 3) for half in halves])
    assert len(triangles) == 1_000_000
    path, begin = put(tmp_path / "ball.stl", binary_stl(triangles)), time.process_time()
    hull = hull_of(path)
    assert time.process_time() - begin < 60.0
    assert len(hull) <= MOST_VERTICES
    assert np.allclose(np.linalg.norm(hull, axis=1), radius, atol=1e-6)
    ways = np.random.default_rng(1).normal(size=(1000, 3))
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    assert (hull @ ways.T).max(axis=0).min() > radius - 3e-4


def test_a_body_is_touched_where_its_collision_geometry_is(tmp_path: Path) -> None:
    put(tmp_path / "a.stl")
    file, turn = tmp_path / "robot.urdf", axis_rotation("z", np.array(np.pi / 2))
    box = Geometry("box", (0.2, 0.2, 0.2), "", np.zeros(3), np.eye(3), collision=True)
    seen = mesh("a.stl", collision=False)
    touched = mesh("a.stl", position=np.array([5.0, 0.0, 0.0]), rotation=turn)
    assert np.ptp(vertices_of(cut([box, seen]), file, []), axis=0) == pytest.approx([0.2] * 3)
    assert np.ptp(vertices_of(cut([seen]), file, []), axis=0) == pytest.approx([2.0, 4.0, 6.0])
    both = vertices_of(cut([box, touched]), file, [])
    assert both[:, 0].min() == pytest.approx(-0.1)
    assert both[:, 0].max() == pytest.approx(7.0)
    assert np.ptp(both, axis=0)[1:] == pytest.approx([2.0, 6.0])


def test_a_missing_mesh_is_a_fault_and_the_rest_is_given(tmp_path: Path) -> None:
    put(tmp_path / "lfs.stl", b"version https://git-lfs.github.com/spec/v1\n")
    box = Geometry("box", (0.2, 0.2, 0.2), "", np.zeros(3), np.eye(3), collision=True)
    faults: list[MeshFault] = []
    body = cut([box, mesh("package://p/a.stl"), mesh("b.stl"), mesh("b.stl"), mesh("lfs.stl")])
    assert len(vertices_of(body, tmp_path / "robot.urdf", faults)) == 8
    missing, pointer = sentences(faults)
    assert "2 meshes (a.stl, b.stl)" in missing
    assert "robot.urdf" in missing
    assert "1 mesh (lfs.stl)" in pointer
    assert len(vertices_of(cut([mesh("c.stl")]), tmp_path / "robot.urdf", faults)) == 0
