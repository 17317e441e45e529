"""A trial from its numbers to its log, in real Bullet."""

from __future__ import annotations

import hashlib
import json
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from gaitlab.errors import Infeasible
from gaitlab.kinematics.six_joint_leg import Leg
from gaitlab.kinematics.transforms import rotation_of
from gaitlab.log import GRAVITY, TrialLog
from gaitlab.log.columns import columns
from gaitlab.model.settings import Horizon
from gaitlab.simulation.simulate import simulate
from tests.trials import STILL, standing, trial

SURFACES = ("grass_50mm", "grass_30mm", "grass_10mm", "carpet_4mm", "hard_floor", "webots_grass")
STEPPING = {"step_length": 0.02, "step_height": 0.015, "lateral_sway": 0.03, "stand_time": 0.1}

DIGEST = """
import hashlib, json, sys
from gaitlab.simulation.simulate import simulate
from gaitlab.simulation.trial import Trial
log = simulate(Trial.from_dict(json.load(sys.stdin)))
print(hashlib.sha256(b"".join(a.tobytes() for a in log.arrays.values())).hexdigest())
"""


def bytes_of(log: TrialLog) -> bytes:
    return b"".join(array.tobytes() for array in log.arrays.values())


@pytest.mark.parametrize("surface", SURFACES)
def test_the_robot_stands_still_on_every_surface_and_the_ground_carries_its_weight(
    surface: str,
) -> None:
    log = simulate(standing(surface, 0.3))
    last = slice(-100, None)
    load = log.per_foot("normal_force")[last].sum(axis=1).mean()
    assert log.fall_index is None
    assert load == pytest.approx(log.header.mass * GRAVITY, rel=0.01)
    fsrs = sum(
        log[f"{side}_foot_fsr_{place}"][last].mean()
        for side in ("left", "right")
        for place in ("front_left", "front_right", "rear_left", "rear_right")
    )
    assert fsrs == pytest.approx(load, rel=1e-5)
    assert (log["zmp_margin"][last] > 0.0).all()
    assert np.abs(np.diff(log["trunk_z"][last])).max() < 2e-4


@pytest.mark.parametrize("surface", ["grass_50mm", "hard_floor"])
def test_ground_forces_accelerate_the_centre_of_mass_as_newton_says(surface: str) -> None:
    log = simulate(trial(surface, cycles=1.0, spread=STILL, **STEPPING))
    window, dt = 25, log.header.dt  # means over 50 ms, over which the derivative is known
    momentum = log.header.mass * np.gradient(log.vector("com_"), dt, axis=0)
    force = np.stack(
        [
            *(log.per_foot(f"force_{axis}").sum(axis=1) for axis in "xy"),
            log.per_foot("normal_force").sum(axis=1) - log.header.weight,
        ],
        axis=-1,
    )
    change = momentum[2 * window :: window] - momentum[window:-window:window]
    impulse = np.add.reduceat(force * dt, np.arange(0, len(log), window))[1:-1]
    count = min(len(change), len(impulse))
    for axis in range(3):
        correlation = np.corrcoef(change[:count, axis], impulse[:count, axis])[0, 1]
        assert correlation > 0.97


def test_the_same_trial_gives_the_same_bytes_here_again_and_in_another_process() -> None:
    one = trial("grass_50mm", cycles=0.5, **STEPPING)
    first, second = bytes_of(simulate(one)), bytes_of(simulate(one))
    assert first == second
    told = subprocess.run(
        [sys.executable, "-c", DIGEST],
        input=json.dumps(one.to_dict()),
        capture_output=True,
        text=True,
        check=True,
        timeout=120,
    )
    assert told.stdout.split()[-1] == hashlib.sha256(first).hexdigest()


def test_another_seed_walks_another_way_and_no_spread_makes_seeds_alike() -> None:
    walks = [simulate(trial(cycles=0.5, seed=seed, **STEPPING)) for seed in (0, 1)]
    assert not np.array_equal(walks[0]["trunk_x"], walks[1]["trunk_x"])
    alike = [simulate(trial(cycles=0.5, seed=s, spread=STILL, **STEPPING)) for s in (0, 1)]
    assert bytes_of(alike[0]) == bytes_of(alike[1])


def test_a_fall_ends_the_log_and_names_its_cause() -> None:
    log = simulate(trial(cycles=9.0, step_length=0.16, step_height=0.05, lateral_sway=0.0))
    assert log.fall_index == len(log) - 1
    assert log["fall_cause"][-1] in (1, 2, 3)
    assert (log["fall_cause"][:-1] == 0).all()


def test_a_foot_out_of_reach_is_infeasible_with_limb_tick_and_reach() -> None:
    with pytest.raises(Infeasible) as caught:
        simulate(trial(step_length=0.29, hip_height=0.24))
    assert caught.value.limb in ("left_leg", "right_leg")
    assert caught.value.tick > 0
    assert "0.21" in caught.value.reason  # m, thigh and shank together


def test_the_horizon_ends_the_log_at_the_first_of_cycles_time_and_distance() -> None:
    base = trial(cycles=1.0, **STEPPING)
    header = simulate(base).header
    whole = len(simulate(base))
    assert whole * header.dt == pytest.approx(header.startup_time + header.gait_period)
    timed = simulate(replace(base, horizon=Horizon(cycles=1.0, time=0.3)))
    assert len(timed) * header.dt == pytest.approx(header.startup_time + 0.3)
    near = simulate(replace(base, horizon=Horizon(cycles=1.0, distance=0.01)))
    assert len(near) < whole
    along = np.abs(near.displacement[near.walking, 0])
    assert along[-1] >= 0.01 - 1e-6  # m, single precision
    assert along[:-1].max() < 0.01 + 1e-6


def test_no_column_of_a_walk_on_grass_is_dead() -> None:
    log = simulate(trial("grass_10mm", cycles=1.5, **{**STEPPING, "lateral_sway": 0.045}))
    held = ("shoulder", "elbow", "head", "yaw")  # poses that this gait does not move
    quiet = {"fall_cause", "body_contact"} if log.fall_index is None else set()
    for column in columns(log.header.joints):
        if column.name in quiet or (
            column.name.endswith("_target") and any(part in column.name for part in held)
        ):
            continue
        values = log[column.name].astype(float)
        assert np.ptp(values[np.isfinite(values)]) > 0, column.name


def test_feet_stand_where_the_joint_positions_say() -> None:
    """The sole's column against the trunk's, by the robot's closed-form leg."""
    one = trial("hard_floor", cycles=0.5, **STEPPING)
    log = simulate(one)
    joints = log.joint_table("position")[:, :6]
    sole = one.robot.sole
    leg = Leg(geometry=one.robot.leg, ankle_height=sole.height, side="left")
    pose = leg.sole_pose(joints)
    rotation = rotation_of(log.vector("trunk_q", "xyzw"))
    under_ankle_to_centre = np.array([sole.length / 2 - sole.heel, sole.outward, 0.0])
    local = pose[:, :3, 3] + pose[:, :3, :3] @ under_ankle_to_centre
    expected = log.vector("trunk_") + np.einsum("nij,nj->ni", rotation, local)
    np.testing.assert_allclose(log.vector("left_foot_"), expected, atol=2e-6)
