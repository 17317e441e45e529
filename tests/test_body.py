from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitlab.errors import Infeasible
from gaitlab.kinematics.transforms import axis_rotation
from gaitlab.model import Box, Joint, Link, Tree, require_limits
from gaitlab.model.soles import Sole

SOLE = Sole(length=0.12, width=0.08, heel=0.05, height=0.04, kind="flat")


def pendulum() -> Tree:
    """A trunk of 1 kg with a 2 kg rod that swings about y, 0.1 m below it."""
    joint = Joint(name="swing", axis="y", lower=-1.0, upper=1.0, servo="mx_28")
    trunk = Link(
        name="trunk",
        parent=None,
        origin=(0.0, 0.0, 0.0),
        joint=None,
        mass=1.0,
        box=Box(size=(0.1, 0.1, 0.1), centre=(0.0, 0.0, 0.0)),
    )
    rod = Link(
        name="rod",
        parent="trunk",
        origin=(0.0, 0.0, -0.1),
        joint=joint,
        mass=2.0,
        box=Box(size=(0.02, 0.02, 0.3), centre=(0.0, 0.0, -0.15)),
    )
    return Tree((trunk, rod))


def standing(n: int) -> tuple[np.ndarray, np.ndarray]:
    return np.zeros((n, 3)), np.tile(np.eye(3), (n, 1, 1))


def test_a_raised_rod_pulls_the_centre_of_mass_to_its_side() -> None:
    tree = pendulum()
    poses = tree.poses(*standing(2), np.array([[0.0], [-np.pi / 2]]))
    expected = [[0.0, 0.0, -2.0 * 0.25 / 3.0], [2.0 * 0.15 / 3.0, 0.0, -2.0 * 0.1 / 3.0]]
    np.testing.assert_allclose(tree.centre_of_mass(poses), expected, atol=1e-15)
    assert tree.mass == 3.0


def test_links_and_centre_of_mass_move_with_the_trunk() -> None:
    tree = pendulum()
    generator = np.random.default_rng(1)
    angles = generator.uniform(-1.0, 1.0, size=(50, 1))
    position = generator.normal(size=(50, 3))
    rotation = axis_rotation("z", angles[:, 0]) @ axis_rotation("x", 2.0 * angles[:, 0])
    still, moved = tree.poses(*standing(50), angles), tree.poses(position, rotation, angles)
    carried = np.einsum("nij,nlj->nli", rotation, still.position) + position[:, None]
    np.testing.assert_allclose(moved.position, carried, atol=1e-14)
    centre = np.einsum("nij,nj->ni", rotation, tree.centre_of_mass(still)) + position
    np.testing.assert_allclose(tree.centre_of_mass(moved), centre, atol=1e-14)


def test_supports_reach_the_edges_and_balance_about_the_centre() -> None:
    for kind, count in (("flat", 12), ("studs", 4)):
        sole = Sole(length=0.12, width=0.08, heel=0.05, height=0.04, kind=kind)
        supports = sole.supports()
        assert supports.shape == (count, 3)
        np.testing.assert_allclose(supports.min(axis=0), [-0.05, -0.04, -0.04], atol=1e-15)
        np.testing.assert_allclose(supports.max(axis=0), [0.07, 0.04, -0.04], atol=1e-15)
        np.testing.assert_allclose(supports.mean(axis=0), sole.centre, atol=1e-15)


@given(n=st.integers(2, 12), across=st.integers(2, 12), length=st.floats(0.02, 0.4))
def test_equal_supports_out_to_the_edges_resist_tipping_by_their_number(n, across, length) -> None:
    sole = replace(SOLE, length=length, heel=0.3 * length, supports_along=n, supports_across=across)
    x, y = (sole.supports() - sole.centre)[:, :2].T
    assert len(x) == n * across
    assert np.mean(x**2) == pytest.approx(length**2 / 12.0 * (n + 1) / (n - 1))
    assert np.mean(y**2) == pytest.approx(0.08**2 / 12.0 * (across + 1) / (across - 1))


def test_more_supports_come_nearer_to_uniform_pressure() -> None:
    def resistance(n: int) -> float:
        x = replace(SOLE, supports_along=n).supports()[:, 0] - SOLE.centre[0]
        return float(np.mean(x**2)) / (SOLE.length**2 / 12.0)

    ratios = [resistance(n) for n in range(2, 13)]
    assert ratios == sorted(ratios, reverse=True)
    assert ratios[0] == pytest.approx(3.0)
    assert 1.0 < ratios[-1] < 1.2


def test_studs_stay_four_however_dense_a_flat_sole_would_be() -> None:
    studs = replace(SOLE, kind="studs", supports_along=6, supports_across=5)
    np.testing.assert_array_equal(np.sort(studs.supports(), 0), np.sort(studs.corners(), 0))


def test_corners_come_rear_right_rear_left_front_right_front_left() -> None:
    expected = [(-0.05, -0.04), (-0.05, 0.04), (0.07, -0.04), (0.07, 0.04)]
    np.testing.assert_allclose(SOLE.corners()[:, :2], expected, atol=1e-15)
    np.testing.assert_allclose(SOLE.corners()[:, 2], -0.04)


def test_a_joint_beyond_its_limit_is_named_with_what_it_may() -> None:
    position = np.array([[0.0], [1.0 + 5e-10], [1.5], [-3.0]])
    require_limits("tail", pendulum().joints, position[:2])
    with pytest.raises(Infeasible) as caught:
        require_limits("tail", pendulum().joints, position)
    assert (caught.value.limb, caught.value.tick) == ("tail", 2)
    assert caught.value.reason == (
        "swing would have to turn to 1.500 rad (85.9 degrees), its limits are -1.000 and 1.000 rad"
        " (-57.3 and 57.3 degrees); shorten step_length or step_height, or change hip_height"
    )


def test_a_joint_that_is_not_a_number_is_refused() -> None:
    with pytest.raises(Infeasible, match="nan"):
        require_limits("tail", pendulum().joints, np.array([[np.nan]]))
