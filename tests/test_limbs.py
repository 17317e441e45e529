"""Limbs of every robot: they end where they are told, and say why when they cannot."""

from __future__ import annotations

import numpy as np
import pytest

from gaitlab.errors import WrongValue
from gaitlab.model.limbs import Limb, Limbed, branches, end_pose
from gaitlab.plugins import load_class, names

ROBOTS = {name: load_class("robot", name)() for name in names("robot")}
LIMBS = {
    f"{name} {limb.name}": limb
    for name, robot in ROBOTS.items()
    if isinstance(robot, Limbed)
    for limb in robot.limbs().values()
}
every_limb = pytest.mark.parametrize("limb", LIMBS.values(), ids=LIMBS)
LEG = LIMBS["eros left_leg"]
FOOT = [0.02, 0.05, -0.25]


def random_joints(limb: Limb, n: int) -> np.ndarray:
    low, high = (np.array([getattr(j, end) for j in limb.joints]) for end in ("lower", "upper"))
    return np.random.default_rng(41).uniform(low, high, size=(n, len(limb.joints)))


def test_eros_and_flow_have_all_five_limbs() -> None:
    five = {"left_leg", "right_leg", "left_arm", "right_arm", "head"}
    for name in ("eros", "flow"):
        assert set(ROBOTS[name].limbs()) == five


@every_limb
def test_a_limb_reaches_again_what_it_has_reached(limb: Limb) -> None:
    reached = 0
    for joints in random_joints(limb, 60):
        target = end_pose(limb, joints)[:3, 3]
        try:
            found = branches(limb, target)
        except WrongValue:
            continue  # a level foot cannot be everywhere a pitched one can
        for branch in found:
            np.testing.assert_allclose(limb.forward(branch.joints)[:3, 3], target, atol=1e-9)
        reached += 1
    assert reached >= 10


@every_limb
def test_joints_are_named_and_limited(limb: Limb) -> None:
    assert len({joint.name for joint in limb.joints}) == len(limb.joints)
    assert all(joint.lower < joint.upper for joint in limb.joints)
    beyond = [joint.lower for joint in limb.joints]
    beyond[0] -= 0.1
    with pytest.raises(WrongValue, match=f"{limb.joints[0].name} is .* its limits are"):
        end_pose(limb, beyond)


@every_limb
@pytest.mark.parametrize("length", [0, 1, 9])
def test_a_vector_of_the_wrong_length_is_refused(limb: Limb, length: int) -> None:
    with pytest.raises(WrongValue, match=f"found {length} numbers, expected 3"):
        branches(limb, [0.1] * length)
    with pytest.raises(WrongValue, match=f"found {length} numbers"):
        end_pose(limb, [0.0] * length)


@every_limb
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_numbers_that_are_none_are_refused(limb: Limb, value: float) -> None:
    with pytest.raises(WrongValue, match="must be finite"):
        branches(limb, [0.0, value, 0.0])
    with pytest.raises(WrongValue, match="must be finite"):
        end_pose(limb, [value] * len(limb.joints))
    with pytest.raises(WrongValue, match="must be finite"):
        branches(limb, [0.0, 0.0, -0.2], value)


def test_branches_within_the_limits_come_first_and_the_others_say_why_not() -> None:
    forward, backward = branches(LEG, FOOT)
    assert forward.beyond == ()
    assert "left_knee is -1.1" in backward.beyond[0]


def test_heading_turns_a_foot_and_nothing_else() -> None:
    (turned, _) = branches(LEG, FOOT, 0.3)
    pose = LEG.forward(turned.joints)
    np.testing.assert_allclose(pose[:3, 3], FOOT, atol=1e-12)
    assert np.arctan2(pose[1, 0], pose[0, 0]) == pytest.approx(0.3)
    with pytest.raises(WrongValue, match="this limb's end has none"):
        branches(LIMBS["flow left_arm"], [0.2, 0.0, -0.2], 0.3)


def test_a_target_out_of_reach_names_reach_and_span_and_no_gait() -> None:
    with pytest.raises(WrongValue, match=r"would have to be 0\.9270 m, the leg spans") as caught:
        branches(LEG, [0.0, 0.042, -1.0])
    assert "step_length" not in str(caught.value)
