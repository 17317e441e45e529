"""Geometry of the pictures: the robot, the grass, the figures of a page."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitlab.kinematics.transforms import axis_rotation
from gaitlab.log import TrialLog
from gaitlab.model import Box
from gaitlab.render import Recorded
from gaitlab.render.camera import Camera
from gaitlab.render.figure_style import save
from gaitlab.render.ground import Patch, blades, ground_triangles, grown
from gaitlab.render.painter import Painter, Style
from gaitlab.render.scene import SolePose, all_corners, link_poses, link_shapes, scene_of
from gaitlab.render.stills import still_figure
from gaitlab.surfaces import FibreMat, RigidFloor, SoftLayer, Surface, TuftedPile
from tests.report.builder import GRASS, toy_tree, walk_log
from tests.walked import walked

CARPET = FibreMat(friction=0.4, height=0.004, modulus=2e9, solid_fraction=0.1)
LAYER = SoftLayer(friction=0.5, height=0.01, stiffness=3332.0, damping=108.0)
GROUNDS = [GRASS, CARPET, LAYER, RigidFloor(friction=0.6)]
PATCH = Patch(x=(-0.2, 0.2), y=(-0.15, 0.15))
DENSEST = 1e5  # blades/m²
GAP = 0.012
SOLE = SolePose(np.array([0.0, 0.0, GAP]), np.eye(3), (0.12, 0.08))


@pytest.fixture(scope="module")
def shown() -> Recorded:
    walking, log = walked()
    return Recorded(walking.id, walking, log)


@given(st.tuples(*[st.floats(0.01, 1.0)] * 3), st.floats(-3.0, 3.0))
def test_a_box_has_its_size_wherever_it_turns(
    size: tuple[float, float, float], angle: float
) -> None:
    rotation = axis_rotation("y", np.array(angle))
    link = toy_tree().links[0]
    box, *_ = link_shapes(replace(link, box=Box(size=size, centre=(0.0, 0.0, 0.0))), ("", ""))
    faces = box.at(np.array([1.0, 2.0, 3.0]), rotation)
    local = (faces.corners.reshape(-1, 3) - [1.0, 2.0, 3.0]) @ rotation
    assert np.allclose(np.ptp(local, axis=0), size)
    assert np.all((faces.colours >= 0.0) & (faces.colours <= 1.0))


def test_every_face_of_a_robot_looks_outward() -> None:
    tree = walked()[0].robot.tree
    for link in tree.links:
        for shape in link_shapes(link, ("", "")):
            a, b, c = shape.corners[:, 0], shape.corners[:, 1], shape.corners[:, 2]
            turned = np.cross(b - a, c - b)
            along = (turned / np.linalg.norm(turned, axis=1)[:, None] * shape.normals).sum(axis=1)
            assert np.allclose(along, 1.0)


@pytest.mark.parametrize("ground", [GRASS, CARPET])
def test_blades_grow_to_the_height_of_the_pile(ground: TuftedPile | FibreMat) -> None:
    spine, _ = blades(grown(ground, PATCH, DENSEST), PATCH, [])
    assert 0.9 * ground.height < spine[..., 2].max() < 1.15 * ground.height


def test_no_blade_that_roots_below_a_sole_stands_higher_than_it() -> None:
    spine, _ = blades(grown(GRASS, PATCH, DENSEST), PATCH, [SOLE])
    roots = spine[:, 0]
    below = (np.abs(roots[:, 0]) < 0.06) & (np.abs(roots[:, 1]) < 0.04)
    assert below.sum() > 50
    assert spine[below][..., 2].max() <= GAP
    assert spine[~below][..., 2].max() > 0.9 * GRASS.height


def test_blades_stay_where_they_are_when_another_piece_is_shown() -> None:
    lawn, half = grown(GRASS, PATCH, DENSEST), Patch(x=(0.0, 0.2), y=(0.0, 0.1))
    every, some = (blades(lawn, patch, [])[0] for patch in (PATCH, half))
    x, y = every[:, 0, 0], every[:, 0, 1]
    assert np.array_equal(some, every[(x >= 0.0) & (y >= 0.0) & (y <= 0.1)])


@pytest.mark.parametrize("ground", GROUNDS)
def test_the_top_of_the_ground_is_where_the_surface_says(ground: Surface) -> None:
    camera = Camera(azimuth=0.0, elevation=0.0, focus=np.zeros(3), place=(0.0, 0.0), scale=1.0)
    parts = ground_triangles(grown(ground, PATCH, DENSEST), PATCH, [], camera)
    top = -min(part.corners[..., 1].min() for part in parts)
    assert top == pytest.approx(ground.height, rel=0.15, abs=1e-9)


def test_poses_from_a_log_are_those_of_the_log() -> None:
    log, tree, tick = walk_log(), toy_tree(), 300
    poses = link_poses(tree, log, np.array([tick]))
    joints = log.joint_table("position")[tick : tick + 1]
    expected = tree.poses(log.vector("trunk_")[tick : tick + 1], np.eye(3)[None], joints)
    assert np.allclose(poses.position, expected.position)
    assert np.allclose(poses.rotation, expected.rotation)


def test_soles_are_where_the_log_has_the_feet(shown: Recorded) -> None:
    scene = scene_of(shown, [0.0, 0.2])
    assert np.allclose(scene.soles.mean(axis=2), scene.centres, atol=1e-4)
    for frame in range(2):
        assert all_corners(scene.faces(frame))[:, 2].min() > -0.01


def test_a_figure_is_drawn_alike_every_time(shown: Recorded, tmp_path: Path) -> None:
    files = [save(still_figure(shown, [0.1]), tmp_path, name) for name in "ab"]
    assert files[0].read_bytes() == files[1].read_bytes()


def test_a_figure_has_one_panel_an_instant_at_one_scale(shown: Recorded) -> None:
    figure = still_figure(shown, [-0.5, 0.0, 0.2])
    assert [axes.get_title() for axes in figure.axes] == ["-0.50 s", "0.00 s", "0.20 s"]
    assert len({np.shape(axes.get_images()[0].get_array()) for axes in figure.axes}) == 1


@pytest.mark.parametrize("axis", ["x", "y"])
def test_a_robot_that_lies_down_is_shown_whole_on_its_board(shown: Recorded, axis: str) -> None:
    turned = {f"trunk_q{part}": 0.0 for part in "xyzw"}
    turned |= {f"trunk_q{axis}": np.sqrt(0.5), "trunk_qw": np.sqrt(0.5), "trunk_z": 0.1}
    down = np.arange(len(shown.log)) > 0  # it stands first, which tells its height
    arrays = {
        name: np.where(down, value, shown.log[name]).astype(np.float32)
        for name, value in turned.items()
    }
    log = TrialLog(header=shown.log.header, arrays={**shown.log.arrays, **arrays})
    style = Style(view="board", width=300, height=312)
    scene = scene_of(shown._replace(log=log), [0.1])
    panel = np.asarray(Painter((scene,), style).panel(0, 0))
    for edge in (panel[0], panel[-1], panel[:, 0], panel[:, -1]):
        assert (edge == 255).all()
