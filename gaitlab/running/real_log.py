"""What a real robot measured while it was sent its targets, beside what is simulated of them.

The log of the robot is a trajectory that also holds `NAME_measured` of joints and what an IMU said
of the trunk. Its targets are walked again, once a seed, and compared at the instants of its rows,
from the first row on and as far as every simulated walk stays on its feet. Nothing is fitted, and
nothing but these residuals is claimed.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from gaitlab.documents import dump
from gaitlab.errors import FileError, Problem, WrongValue
from gaitlab.experiment.loading import experiment_of
from gaitlab.experiment.plan import plan
from gaitlab.gaits.trajectory import Gait
from gaitlab.kinematics.transforms import roll_pitch_yaw, rotation_of
from gaitlab.log import TrialLog
from gaitlab.model import Robot
from gaitlab.model.forward import feet_of_joints
from gaitlab.motions.trajectory import ANGLES, MEASURED, Trajectory, leg_joints
from gaitlab.simulation.simulate import simulate
from gaitlab.simulation.trial import Trial
from gaitlab.statistics import Interval, mean_interval

SHORTEST_STEP = 0.05  # s; a foot that is up for less has not been lifted
FEWEST_ROWS = 10  # that are compared
TURN = 2.0 * np.pi
QUATERNION = ("imu_qx", "imu_qy", "imu_qz", "imu_qw")


class Residual(NamedTuple):
    """How far simulated walks are from the measured one in one quantity.

    Attributes:
        quantity: A joint, `trunk pitch`, `trunk roll` or `step time`.
        unit: Of the numbers.
        rms: Root mean square of simulated less measured over the rows, the mean over seeds; for
            the step time, of which a walk has one, NaN.
        rms_interval: 95 % interval of that mean.
        mean: Simulated less measured, the mean over rows and seeds.
        mean_interval: 95 % interval of that mean over seeds.
    """

    quantity: str
    unit: str
    rms: float
    rms_interval: Interval
    mean: float
    mean_interval: Interval


@dataclass(frozen=True, kw_only=True)
class LogComparison:
    """A measured walk and what is simulated of it.

    Attributes:
        residuals: By quantity, joints first, in the order of the robot.
        seeds: Simulated walks.
        rows: Rows of the file that are compared.
        time: How much of the file they cover, in [s].
        falls: Simulated walks that fell.
        first_fall: Instant of the file at which the first of them had fallen, in [s]; NaN if none.
        digest: Of the file's targets.
    """

    residuals: Sequence[Residual]
    seeds: int
    rows: int
    time: float
    falls: int
    first_fall: float
    digest: str


def replays(
    file: Path, robot: str, surface: str, seeds: int, settings: Sequence[str] = ()
) -> list[Trial]:
    """Trials in which a robot is sent the targets of a file, from its first row to its last.

    Args:
        file: The file.
        robot: Name or file of the robot.
        surface: Name or file of the ground.
        seeds: How many.
        settings: `path=value` each, as for an experiment.

    Raises:
        GaitlabError: Everything that stands in the way.
    """
    gait = {"type": "trajectory", "file": str(file.absolute())}
    asked = {
        "name": "compare_log",
        "robot": {"type": robot},
        "gait": gait,
        "surfaces": [surface],
        "seeds": seeds,
        "horizon": {"cycles": 10000.0, "distance": 1000.0, "time": 3600.0},
    }
    found = experiment_of(dump(asked), Path.cwd() / "compare_log.yaml", settings)
    made = found.parts.gait
    if not isinstance(made, Gait):
        raise WrongValue("compare-log walks a trajectory; leave gait.type as it is")
    left = made.trajectory.end - made.walk_start
    whole = [*settings, f"horizon.time={max(left, 0.1)!r}"]
    found = experiment_of(dump(asked), Path.cwd() / "compare_log.yaml", whole)
    return [item.trial for item in plan(found).trials()]


def compare_log(trials: Sequence[Trial]) -> LogComparison:
    """Walk the trials of `replays` and compare them with what the file holds.

    Raises:
        FileError: If the file holds nothing measured, or too little is left to compare.
        GaitlabError: If a trial cannot be simulated.
    """
    gait, robot = trials[0].gait, trials[0].robot
    assert isinstance(gait, Gait)
    real = _measured(gait.trajectory, robot)
    logs = [simulate(trial) for trial in trials]
    ends = [_end(log, gait) for log in logs]
    kept = gait.trajectory.time <= min(ends)
    if kept.sum() < FEWEST_ROWS:
        message = (
            f"a simulated walk falls {min(ends):.2f} s after the first row; nothing to compare"
        )
        raise FileError([gait.trajectory.problem(0, message)])
    time = gait.trajectory.time[kept]
    residuals = []
    for quantity, column, values in real:
        differences = [
            np.interp(time + gait.stand_time, log["time"], log[column]) - values[kept]
            for log in logs
        ]
        residuals.append(_residual(quantity, differences))
    residuals += _step_time(gait.trajectory, robot, logs, gait.stand_time, kept)
    fallen = [end for log, end in zip(logs, ends, strict=True) if log.fall_index is not None]
    return LogComparison(
        residuals=residuals,
        seeds=len(logs),
        rows=int(kept.sum()),
        time=float(time[-1]),
        falls=len(fallen),
        first_fall=min(fallen, default=float("nan")),
        digest=gait.trajectory.digest,
    )


def _end(log: TrialLog, gait: Gait) -> float:
    """Last instant of the file up to which a walk is compared, in [s]."""
    last = len(log) - 1 if log.fall_index is None else log.fall_index
    return float(log["time"][last]) - gait.stand_time


def _measured(found: Trajectory, robot: Robot) -> list[tuple[str, str, np.ndarray]]:
    """What the file holds: what it is called, its column in a log, and its values in [rad].

    Raises:
        FileError: If that is nothing, or of a joint that the robot has not.
    """
    names = [joint.name for joint in robot.tree.joints]
    unknown = [n for n in found.measured if n.endswith(MEASURED) and _joint(n) not in names]
    if unknown:
        message = f"{unknown[0]}: the robot {robot.name!r} has no joint {_joint(unknown[0])!r}"
        raise FileError([Problem(file=found.file, line=None, column=None, message=message)])
    real = [
        (name, f"{name}_position", found.measured[f"{name}{MEASURED}"])
        for name in names
        if f"{name}{MEASURED}" in found.measured
    ]
    tilt = {name: found.measured[name] for name in ANGLES if name in found.measured}
    if all(name in found.measured for name in QUATERNION):
        turned = np.stack([found.measured[name] for name in QUATERNION], axis=-1)
        length = np.linalg.norm(turned, axis=1, keepdims=True)
        if np.abs(length - 1.0).max() > 0.05:
            raise FileError([found.problem(0, "imu_qx, qy, qz, qw are no quaternion of length 1")])
        roll, pitch, _ = roll_pitch_yaw(rotation_of(turned / length)).T
        tilt = {"imu_roll": roll, "imu_pitch": pitch, **tilt}
    for name, quantity, column in (
        ("imu_pitch", "trunk pitch", "pitch"),
        ("imu_roll", "trunk roll", "roll"),
    ):
        if name in tilt:
            real.append((quantity, column, tilt[name]))
    if not real:
        message = (
            f"holds nothing measured; name columns JOINT{MEASURED}, imu_pitch and imu_roll, or "
            f"{', '.join(QUATERNION)}"
        )
        raise FileError([Problem(file=found.file, line=None, column=None, message=message)])
    return real


def _joint(column: str) -> str:
    return column.removesuffix(MEASURED)


def _residual(quantity: str, differences: Sequence[np.ndarray]) -> Residual:
    """Of simulated less measured over the rows of each seed, in [rad]."""
    turned = [np.mod(one + np.pi, TURN) - np.pi for one in differences]
    rms = [float(np.sqrt(np.mean(one**2))) for one in turned]
    means = [float(np.mean(one)) for one in turned]
    spread = mean_interval(rms)
    return Residual(
        quantity=quantity,
        unit="rad",
        rms=float(np.mean(rms)),
        rms_interval=Interval(max(spread.low, 0.0), spread.high),
        mean=float(np.mean(means)),
        mean_interval=mean_interval(means),
    )


def _step_time(
    found: Trajectory, robot: Robot, logs: Sequence[TrialLog], stand_time: float, kept: np.ndarray
) -> Iterator[Residual]:
    """Time from one lift of a foot to the next, found in the same way in both: from the joints.

    Nothing for a file without all the legs' joints, or in which fewer than two steps are seen.
    """
    if not all(f"{name}{MEASURED}" in found.measured for name in leg_joints(robot)):
        return
    time = found.time[kept]
    names = [joint.name for joint in robot.tree.joints]
    real = np.zeros((len(time), len(names)))
    for k, name in enumerate(names):
        if f"{name}{MEASURED}" in found.measured:
            real[:, k] = found.measured[f"{name}{MEASURED}"][kept]
    measured = _between_lifts(time, feet_of_joints(robot, real).swing)
    simulated = []
    for log in logs:
        columns = (log[f"{name}_position"] for name in names)
        joints = [np.interp(time + stand_time, log["time"], column) for column in columns]
        swing = feet_of_joints(robot, np.stack(joints, axis=-1)).swing
        simulated.append(_between_lifts(time, swing))
    if not np.isfinite([measured, *simulated]).all():
        return
    differences = [one - measured for one in simulated]
    yield Residual(
        quantity="step time",
        unit="s",
        rms=float("nan"),
        rms_interval=Interval(float("nan"), float("nan")),
        mean=float(np.mean(differences)),
        mean_interval=mean_interval(differences),
    )


def _between_lifts(time: np.ndarray, swing: np.ndarray) -> float:
    """Median time between lifts of any foot, in [s]; NaN for fewer than two."""
    lifts = sorted(t for foot in swing.T for t in _lifts(time, foot))
    return float(np.median(np.diff(lifts))) if len(lifts) > 1 else float("nan")


def _lifts(time: np.ndarray, up: np.ndarray) -> Iterable[float]:
    change = np.diff(up.astype(np.int8))
    for begin in np.flatnonzero(change > 0) + 1:
        landing = np.flatnonzero(change[begin:] < 0)
        last = begin + landing[0] if len(landing) else len(time) - 1
        if time[last] - time[begin] >= SHORTEST_STEP:
            yield float(time[begin])
