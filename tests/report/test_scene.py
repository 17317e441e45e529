"""Geometry of the pictures: the camera, the robot, the grass."""

from __future__ import annotations

from math import pi
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitlab.kinematics.transforms import axis_rotation
from gaitlab.model import LinkPoses
from gaitlab.render.figure_style import save
from gaitlab.render.lawn import Patch, PressingSole, ground_faces
from gaitlab.render.portrait import SIDE, filmstrip, patch_below, portrait
from gaitlab.render.robot import Stance, stance_at
from gaitlab.render.scene import Camera, box_faces
from gaitlab.surfaces import FibreMat, RigidFloor, SoftLayer, Surface, TuftedPile
from tests.report.builder import GRASS, JOINTS, SOLE, toy_tree, walk_log

CARPET = FibreMat(friction=0.4, height=0.004, modulus=2e9, solid_fraction=0.1)
LAYER = SoftLayer(friction=0.5, height=0.01, stiffness=3332.0, damping=108.0)
GROUNDS = [GRASS, CARPET, LAYER, RigidFloor(friction=0.6)]
PATCH = Patch(x=(-0.2, 0.2), y=(-0.15, 0.15))


def stance(height: float) -> Stance:
    tree = toy_tree()
    poses = tree.poses(np.array([[0.0, 0.0, 0.23 + height]]), np.eye(3)[None], np.zeros((1, 2)))
    return Stance(tree=tree, sole=SOLE, feet=("left_foot", "right_foot"), poses=poses)


@given(st.floats(-pi, pi), st.floats(-1.5, 1.5))
def test_a_camera_keeps_lengths_and_handedness(azimuth: float, elevation: float) -> None:
    axes = Camera(azimuth=azimuth, elevation=elevation).axes
    assert np.allclose(axes @ axes.T, np.eye(3), atol=1e-12)
    right, up, away = axes
    assert np.allclose(np.cross(right, up), -away, atol=1e-12)


def test_from_the_right_side_forward_is_right_and_left_is_far() -> None:
    camera = Camera(azimuth=-pi / 2, elevation=0.0)
    assert np.allclose(camera.see(np.eye(3)), [[1, 0, 0], [0, 0, 1], [0, 1, 0]], atol=1e-12)


@given(st.tuples(*[st.floats(0.01, 1.0)] * 3), st.floats(-3.0, 3.0))
def test_a_box_has_its_size_wherever_it_turns(
    size: tuple[float, float, float], angle: float
) -> None:
    rotation = axis_rotation("y", np.array(angle))
    faces = box_faces(size, np.array([1.0, 2.0, 3.0]), rotation, "#808080")
    local = (faces.corners.reshape(-1, 3) - [1.0, 2.0, 3.0]) @ rotation
    assert np.allclose(np.ptp(local, axis=0), size)
    assert np.all((faces.colours >= 0.0) & (faces.colours <= 1.0))


@pytest.mark.parametrize("ground", [GRASS, CARPET])
def test_blades_grow_to_the_height_of_the_pile(ground: TuftedPile | FibreMat) -> None:
    top = ground_faces(ground, PATCH, [], SIDE)[-1].corners[..., 2].max()
    assert 0.9 * ground.height < top < 1.15 * ground.height


def test_no_blade_that_roots_below_a_sole_stands_higher_than_it() -> None:
    gap = 0.012
    sole = PressingSole(centre=np.array([0.0, 0.0, gap]), rotation=np.eye(3), size=(0.12, 0.08))
    blades = ground_faces(GRASS, PATCH, [sole], SIDE)[-1].corners
    roots = 0.5 * (blades[:, 0] + blades[:, -1])
    below = (np.abs(roots[:, 0]) < 0.06) & (np.abs(roots[:, 1]) < 0.04)
    assert below.sum() > 50
    assert blades[below][..., 2].max() <= gap + 0.001  # m, the ribbon's own width tilts up
    assert blades[~below][..., 2].max() > 0.9 * GRASS.height


@pytest.mark.parametrize("ground", GROUNDS)
def test_the_top_of_the_ground_is_where_the_surface_says(ground: Surface) -> None:
    corners = np.concatenate(
        [f.corners.reshape(-1, 3) for f in ground_faces(ground, PATCH, [], SIDE)]
    )
    assert corners[:, 2].max() == pytest.approx(ground.height, rel=0.15, abs=1e-9)


def test_the_patch_reaches_beyond_the_robot_on_every_side() -> None:
    standing = stance(0.0)
    patch, corners = patch_below([standing]), standing.corners()
    assert patch.x[0] < corners[:, 0].min() < corners[:, 0].max() < patch.x[1]
    assert patch.y[0] < corners[:, 1].min() < corners[:, 1].max() < patch.y[1]


def test_a_stance_from_a_log_is_the_pose_of_the_log() -> None:
    log, tree, tick = walk_log(), toy_tree(), 300
    poses = stance_at(log, tree, SOLE, tick).poses
    joints = log.joint_table("position")[tick : tick + 1]
    expected = tree.poses(log.vector("trunk_")[tick : tick + 1], np.eye(3)[None], joints)
    assert isinstance(poses, LinkPoses)
    assert np.allclose(poses.position, expected.position)
    assert np.allclose(poses.rotation, expected.rotation)
    assert log.header.joints == JOINTS


def test_a_portrait_on_each_ground_is_drawn_alike_every_time(tmp_path: Path) -> None:
    seen = set()
    for ground in GROUNDS:
        files = [save(portrait(stance(0.0), ground), tmp_path, name) for name in "ab"]
        assert files[0].read_bytes() == files[1].read_bytes()
        seen.add(files[0].read_bytes())
    assert len(seen) == len(GROUNDS)


def test_a_filmstrip_has_one_panel_a_tick_at_one_scale() -> None:
    figure = filmstrip(walk_log(), toy_tree(), SOLE, CARPET, [150, 300, 450], forces=True)
    assert [axes.get_title() for axes in figure.axes] == ["0.51 s", "2.01 s", "3.51 s"]
    widths = [np.ptp(axes.get_xlim()) for axes in figure.axes]
    assert np.allclose(widths, widths[0])
