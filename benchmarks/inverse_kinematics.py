"""Leg solutions a second on one core: `python benchmarks/inverse_kinematics.py`.

The closed form of EROS' leg, and beside it what a robot from a URDF has: the same leg read back,
solved by damped least squares on the lines of its axes.
Random targets within reach, in batches that fit the processor's cache, as a long trial or a grid
of trials asks for them. The best of the repeats counts: what is slower was disturbed.
"""

from __future__ import annotations

import argparse
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter

import numpy as np

from gaitlab.kinematics.axis_leg import AxisLeg, SolePoses
from gaitlab.kinematics.six_joint_leg import Leg
from gaitlab.kinematics.transforms import axis_rotation, homogeneous
from gaitlab.model.foreign.robot_file import load_robot
from gaitlab.model.urdf import urdf
from gaitlab.robots.eros import LegGeometry, Robot

BATCH = 4000  # targets; a few hundred kB of arrays
REPEATS = 200
LEG = Leg(geometry=LegGeometry(), ankle_height=0.038, side="left")


def targets(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Sole positions in [m] and headings in [rad] within reach."""
    generator = np.random.default_rng(7)
    spread = generator.uniform([-0.06, -0.04, -0.02], [0.06, 0.04, 0.03], size=(n, 3))
    return LEG.hip - np.array([0.0, 0.0, 0.21]) + spread, generator.uniform(-0.5, 0.5, size=n)


def main() -> None:
    """Time both inverse kinematics of the leg and print solutions a second."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=REPEATS)
    repeats = parser.parse_args().repeats
    position, heading = targets(BATCH)
    pose = homogeneous(axis_rotation("z", heading), position)
    for name, solve, times in (
        ("level sole", lambda: LEG.flat_joints(position, heading), repeats),
        ("any pose", lambda: LEG.pose_joints(pose), repeats),
        ("from lines", lambda: _from_lines(pose), max(1, repeats // 20)),
    ):
        joints = solve()
        error = np.abs(LEG.sole_pose(joints) - pose).max()
        seconds = min(_seconds(solve) for _ in range(times))
        rate = BATCH / seconds
        print(f"{name:<10}  {rate / 1e3:8.1f} thousand legs a second, FK(IK) error {error:.1e} m")


def _from_lines(pose: np.ndarray) -> np.ndarray:
    """Joints of the left leg of EROS, read from its URDF, for the same poses."""
    leg, standing = _read_back()
    wanted = SolePoses(pose[:, :3, 3], pose[:, :3, :3])
    return leg.inverse(wanted, standing).angles


@cache
def _read_back() -> tuple[AxisLeg, np.ndarray]:
    robot = Robot()
    with TemporaryDirectory() as folder:
        file = Path(folder) / "eros.urdf"
        file.write_text(urdf(robot.tree, robot.sole, robot.feet), encoding="utf-8")
        found = load_robot(file).found.legs[0]
    shift = LEG.hip - found.points[found.pitch[0]]
    return (
        AxisLeg(
            axes=found.axes,
            points=found.points + shift,
            sole=found.ankle + shift - [0.0, 0.0, robot.sole.height],
            rotation=found.rotation,
            limits=np.tile([-np.inf, np.inf], (len(found.axes), 1)),
        ),
        found.standing,
    )


def _seconds(solve: object) -> float:
    start = perf_counter()
    solve()  # type: ignore[operator]
    return perf_counter() - start


if __name__ == "__main__":
    main()
