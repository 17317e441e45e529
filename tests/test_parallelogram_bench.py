"""A geared leg of FLoW on the bench: pelvis held, pitch joints moving, the sole pushed up."""

from pathlib import Path

import numpy as np
import pybullet
import pytest

from gaitlab.kinematics.transforms import rotation_of
from gaitlab.model.urdf import urdf
from gaitlab.robots.flow import Robot
from gaitlab.simulation.bullet.couplings import add_couplings
from gaitlab.simulation.bullet.world import indices, new_world

AMPLITUDE, FREQUENCY = 0.3, 1.0  # rad and Hz, of thigh and shank
FORCE, AHEAD = 60.0, 0.040  # N up, m ahead of the ankle
SECONDS, START_UP = 2.0, 0.5
ALLOWED = np.radians(0.5)  # of the sole against the pelvis
ROBOT = Robot(parallelogram="geared")


def largest_pitch(dt: float, folder: Path) -> float:
    """Largest pitch of the left sole against the held pelvis after the start-up, in [rad]."""
    client = new_world(50)
    client.setTimeStep(dt)
    try:
        file = folder / "flow.urdf"
        file.write_text(urdf(ROBOT.tree, ROBOT.sole, ROBOT.feet))
        body = client.loadURDF(str(file), useFixedBase=True)
        found = indices(client, body)
        for index in found.joint.values():
            client.setJointMotorControl2(body, index, pybullet.VELOCITY_CONTROL, force=0.0)
        add_couplings(client, body, ROBOT.couplings, found.joint, dt=dt)
        worst = 0.0
        for tick in range(round(SECONDS / dt)):
            angle = AMPLITUDE * np.sin(2.0 * np.pi * FREQUENCY * tick * dt)
            for name, target in _targets(angle).items():
                client.setJointMotorControl2(
                    body,
                    found.joint[name],
                    pybullet.POSITION_CONTROL,
                    targetPosition=target,
                    force=200.0,
                )
            foot = found.link["left_foot"]
            origin, quaternion = client.getLinkState(body, foot, computeForwardKinematics=True)[4:6]
            point = np.add(origin, [AHEAD, 0.0, 0.0])
            client.applyExternalForce(
                body, foot, [0.0, 0.0, FORCE], point.tolist(), pybullet.WORLD_FRAME
            )
            client.stepSimulation()
            if tick * dt > START_UP:
                rotation = rotation_of(np.array(quaternion))
                worst = max(worst, abs(float(np.arcsin(rotation[2, 0]))))
        return worst
    finally:
        client.disconnect()


def _targets(angle: float) -> dict[str, float]:
    """Every driven joint at rest but for thigh and shank of the left leg."""
    driven = [joint.name for joint in ROBOT.tree.joints if joint.servo is not None]
    return dict.fromkeys(driven, 0.0) | {"left_hip_pitch": angle, "left_shank_pitch": -angle}


@pytest.mark.parametrize("dt", [0.003, 0.002, 0.001])
def test_gears_keep_the_sole_parallel_to_the_pelvis(dt: float, tmp_path: Path) -> None:
    assert largest_pitch(dt, tmp_path) < ALLOWED


@pytest.mark.parametrize("dt", [0.001, 0.0005])
def test_a_loaded_gear_sags_the_same_at_every_step_of_time(dt: float, tmp_path: Path) -> None:
    usual = largest_pitch(0.002, tmp_path)
    assert largest_pitch(dt, tmp_path) == pytest.approx(usual, rel=0.05)
