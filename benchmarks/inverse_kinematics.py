"""Leg solutions a second on one core: `python benchmarks/inverse_kinematics.py`.

Random targets within reach, in batches that fit the processor's cache, as a long trial or a grid
of trials asks for them. The best of the repeats counts: what is slower was disturbed.
"""

from __future__ import annotations

import argparse
from time import perf_counter

import numpy as np

from gaitlab.kinematics.six_joint_leg import Leg
from gaitlab.kinematics.transforms import axis_rotation, homogeneous
from gaitlab.robots.eros import LegGeometry

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
    for name, solve in (
        ("level sole", lambda: LEG.flat_joints(position, heading)),
        ("any pose", lambda: LEG.pose_joints(pose)),
    ):
        joints = solve()
        error = np.abs(LEG.sole_pose(joints) - pose).max()
        seconds = min(_seconds(solve) for _ in range(repeats))
        rate = BATCH / seconds
        print(f"{name:<10}  {rate / 1e6:5.2f} million legs a second, FK(IK) error {error:.1e} m")


def _seconds(solve: object) -> float:
    start = perf_counter()
    solve()  # type: ignore[operator]
    return perf_counter() - start


if __name__ == "__main__":
    main()
