"""Joint angles over time, as a team's own walk writes them: read, checked, fitted to a robot.

A file is CSV, NumPy's npz or Parquet and holds `time`, in s, and a column for each joint under its
name in the robot, in rad or, where the gait says so, in degrees. A unit may follow a name,
`time [s]`. Lines of a CSV that begin with # are comments. What a robot has measured meanwhile may
stand beside: `left_knee_measured` and so on for joints, and of the trunk `imu_roll` and
`imu_pitch` or the quaternion `imu_qx`, `imu_qy`, `imu_qz`, `imu_qw`; a walk does not read these.
"""

from __future__ import annotations

import csv
import hashlib
import re
import zipfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import degrees, pi, radians
from pathlib import Path
from typing import Literal

import numpy as np

from gaitlab.documents.printable import visible
from gaitlab.errors import FileError, Problem
from gaitlab.model import Robot
from gaitlab.model.servo import Servo
from gaitlab.plugins import suggestion

Unit = Literal["rad", "deg"]
SUFFIXES = (".csv", ".npz", ".parquet")
MEASURED = "_measured"  # behind a joint's name: what its encoder said
IMU = ("imu_roll", "imu_pitch", "imu_qx", "imu_qy", "imu_qz", "imu_qw")
ANGLES = ("imu_roll", "imu_pitch")
TITLE = re.compile(r"\s*(.+?)\s*(?:\[(.*)\])?\s*")  # name and unit
UNITS = {"s": "time", "rad": "angle", "deg": "angle", "-": "ratio"}
LARGEST = 200_000_000  # byte
TURN = 2.0 * pi
LAG = 0.05  # s, by which a servo at its no-load speed may be behind; a target further off jumps


@dataclass(frozen=True, kw_only=True, eq=False)
class Trajectory:
    """Joint targets over time, as they stand in a file.

    Attributes:
        file: The file.
        time: From the first row on, in [s]. Shape (n,).
        joints: Names of the joints.
        angles: Their targets, in [rad]. Shape (n, joints).
        measured: What a robot measured in these rows, by the name of the column: joints under
            their own, angles in [rad]; None if it holds none.
        lines: Line of each row, counted from 1; empty for a file without lines.
        digest: SHA-256 of the targets and their names. 64 hex digits.
    """

    file: Path
    time: np.ndarray
    joints: tuple[str, ...]
    angles: np.ndarray
    measured: Mapping[str, np.ndarray]
    lines: Sequence[int]
    digest: str

    @property
    def end(self) -> float:
        """When the last row has been held as long as the one before it, in [s]."""
        return float(2.0 * self.time[-1] - self.time[-2])

    def at(self, t: np.ndarray) -> np.ndarray:
        """Targets at instants in [s], on straight lines between rows. Shape (n, joints)."""
        return np.stack([np.interp(t, self.time, column) for column in self.angles.T], axis=-1)

    def row(self, t: np.ndarray) -> np.ndarray:
        """Index of the row that holds at instants in [s]. Shape (n,)."""
        found = np.searchsorted(self.time, t + 1e-9, side="right") - 1
        return np.clip(found, 0, len(self.time) - 1)

    def problem(self, row: int, message: str) -> Problem:
        """A mistake in a row."""
        return _problem(self.file, self.lines, row, message)


def load_trajectory(file: str | Path, unit: Unit = "rad") -> Trajectory:
    """The trajectory of a file, every number checked.

    Args:
        file: The file; its suffix says what it is.
        unit: Of the angles.

    Raises:
        FileError: What is wrong, at its line.
    """
    path = Path(file)
    try:
        status = path.stat()
    except OSError as error:
        reason = "there is no such file" if isinstance(error, FileNotFoundError) else str(error)
        raise _wrong(path, f"{reason}; give a {_list(SUFFIXES, 'or')} file") from error
    if path.suffix.lower() not in SUFFIXES or not path.is_file():
        raise _wrong(path, f"is no trajectory; give a {_list(SUFFIXES, 'or')} file")
    if status.st_size > LARGEST:
        raise _wrong(path, f"has {status.st_size} byte; at most {LARGEST} are read")
    return _loaded(path, unit, status.st_mtime_ns, status.st_size)


@lru_cache(maxsize=64)
def _loaded(path: Path, unit: Unit, *_: int) -> Trajectory:
    read = {".csv": _read_csv, ".npz": _read_npz, ".parquet": _read_parquet}
    titles, table, lines = read[path.suffix.lower()](path)
    columns = _columns(path, titles, unit)
    if len(table) < 2:
        raise _wrong(path, f"holds {len(table)} rows; a trajectory has at least two")
    wrong = np.argwhere(~np.isfinite(table))
    if len(wrong):
        row, column = wrong[0]
        raise FileError(
            [_problem(path, lines, row, f"{titles[column]} is {table[row, column]}, no number")]
        )
    time = table[:, titles.index(columns["time"])]
    back = np.flatnonzero(np.diff(time) <= 0.0)
    if len(back):
        row = int(back[0]) + 1
        message = f"time goes from {time[row - 1]:g} to {time[row]:g} s; it has to rise"
        raise FileError([_problem(path, lines, row, message)])
    factor = radians(1.0) if unit == "deg" else 1.0
    angular = {n: table[:, titles.index(t)] for n, t in columns.items() if n != "time"}
    for name, angles in angular.items():
        if not name.startswith("imu_q"):
            angular[name] = angles * factor if unit == "deg" else angles
    joints = tuple(n for n in angular if not n.endswith(MEASURED) and n not in IMU)
    targets = np.stack([angular[name] for name in joints], axis=-1)
    beyond = np.argwhere(np.abs(targets) > TURN)
    if len(beyond):
        row, column = (int(i) for i in beyond[0])
        advice = "" if unit == "deg" else "; if these are degrees, write `unit: deg`"
        message = f"{joints[column]} is {targets[row, column]:g} rad, more than a turn{advice}"
        raise FileError([_problem(path, lines, row, message)])
    content = [np.ascontiguousarray(part).astype("<f8").tobytes() for part in (time, targets)]
    digest = hashlib.sha256(b"\0".join([*map(str.encode, joints), *content])).hexdigest()
    measured = {name: part for name, part in angular.items() if name not in joints}
    return Trajectory(
        file=path,
        time=time - time[0],
        joints=joints,
        angles=targets,
        measured=measured,
        lines=lines,
        digest=digest,
    )


Table = tuple[list[str], np.ndarray, Sequence[int]]  # titles, numbers by row, lines


def _read_csv(path: Path) -> Table:
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise _wrong(path, "is no text in UTF-8") from error
    kept = [(k, line) for k, line in enumerate(text.splitlines(), start=1) if _counts(line)]
    if not kept:
        raise _wrong(path, "is empty; expected a line of names, time and joints, and rows below")
    titles, *rows = csv.reader(line for _, line in kept)
    lines = [number for number, _ in kept[1:]]
    for line, row in zip(lines, rows, strict=True):
        if len(row) != len(titles):
            message = f"{len(row)} columns, the line of names has {len(titles)}"
            raise FileError([Problem(file=path, line=line, column=None, message=message)])
    try:
        return titles, np.array(rows, dtype=float).reshape(len(rows), len(titles)), lines
    except ValueError:
        numbers = [[_number(cell) for cell in row] for row in rows]  # to tell where
    for line, found, row in zip(lines, numbers, rows, strict=True):
        for title, number, cell in zip(titles, found, row, strict=True):
            if number is None:
                message = f"{title.strip()} is {cell.strip()[:40]!r}, no number"
                raise FileError([Problem(file=path, line=line, column=None, message=message)])
    return titles, np.array(numbers, dtype=float), lines


def _counts(line: str) -> bool:
    return bool(line.strip()) and not line.lstrip().startswith("#")


def _number(cell: str) -> float | None:
    try:
        return float(cell)
    except ValueError:
        return None


def _read_npz(path: Path) -> Table:
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as held:
            arrays = {name: np.asarray(held[name], dtype=float) for name in held.files}
    except (OSError, ValueError, TypeError, EOFError, zipfile.BadZipFile) as error:
        raise _wrong(path, f"cannot be read as arrays of numbers ({error})") from error
    return _stacked(path, arrays)


def _read_parquet(path: Path) -> Table:
    import pandas as pd  # slow to load, and seldom needed

    try:
        frame = pd.read_parquet(path)
        arrays = {str(name): frame[name].to_numpy(dtype=float) for name in frame}
    except (OSError, ValueError, TypeError) as error:
        raise _wrong(path, f"cannot be read as a table of numbers ({error})") from error
    return _stacked(path, arrays)


def _stacked(path: Path, arrays: Mapping[str, np.ndarray]) -> Table:
    shapes = {name: array.shape for name, array in arrays.items()}
    expected = next(iter(shapes.values()), ())
    for name, shape in shapes.items():
        if len(shape) != 1 or shape != expected:
            raise _wrong(
                path, f"{name} has the shape {shape}; one row of numbers each, as long as the rest"
            )
    if not arrays:
        raise _wrong(path, "is empty; expected `time` and an array for each joint")
    return list(arrays), np.stack(list(arrays.values()), axis=-1), ()


def _columns(path: Path, titles: Sequence[str], unit: Unit) -> dict[str, str]:
    """The title of each column by its name, `time` and at least one joint among them."""
    found: dict[str, str] = {}
    for title in titles:
        match = TITLE.fullmatch(title)
        name, stated = (match[1], match[2]) if match else ("", None)
        if not name or len(name) > 200:
            raise _wrong(path, f"a column is called {visible(title)[:40]!r}; give it a name")
        if name in found:
            raise _wrong(path, f"two columns are called {name}; keep one of them")
        if stated in ("rad", "deg") and stated != unit and not name.startswith("imu_q"):
            raise _wrong(
                path, f"{name} is in {stated}, the gait says {unit}; write `unit: {stated}`"
            )
        if name == "time" and stated not in (None, "s"):
            raise _wrong(path, f"time is in {stated}; it has to be in s")
        found[name] = title
    if "time" not in found:
        raise _wrong(path, f"has no column `time`{suggestion('time', found)}")
    if not any(n != "time" and n not in IMU and not n.endswith(MEASURED) for n in found):
        raise _wrong(path, "has no column of a joint")
    return found


def _problem(path: Path, lines: Sequence[int], row: int, message: str) -> Problem:
    line = lines[row] if lines else None
    place = "" if lines else f"row {row + 1}: "
    return Problem(file=path, line=line, column=None, message=f"{place}{message}")


def _wrong(path: Path, message: str) -> FileError:
    return FileError([Problem(file=path, line=None, column=None, message=message)])


def _list(words: Iterable[str], last: str) -> str:
    *first, end = words
    return f"{', '.join(first)} {last} {end}"


def trajectory_text(
    time: np.ndarray, joints: Sequence[str], angles: np.ndarray, comments: Sequence[str]
) -> str:
    """A CSV that reads back as the same numbers, rows that change nothing left out.

    Args:
        time: In [s]. Shape (n,).
        joints: Names.
        angles: In [rad]. Shape (n, joints).
        comments: Lines for its head.
    """
    changed = np.any(np.diff(angles, axis=0) != 0.0, axis=1)
    changed[-1] |= not changed.any()  # two rows at least
    kept = np.flatnonzero(np.concatenate([[True], changed]))
    rows = zip(time[kept].tolist(), angles[kept].tolist(), strict=True)
    lines = [f"# {comment}" for comment in comments]
    lines += [",".join(["time", *joints])]
    lines += [",".join(map(repr, [instant, *row])) for instant, row in rows]
    return "\n".join(lines) + "\n"


def leg_joints(robot: Robot) -> tuple[str, ...]:
    """Joints with a servo between the trunk and either foot, in the order of the tree."""
    tree, legs = robot.tree, set[str]()
    for foot in robot.feet:
        link = tree.links[tree.index(foot)]
        while link.parent is not None:
            if link.joint is not None and link.joint.servo is not None:
                legs.add(link.joint.name)
            link = tree.links[tree.index(link.parent)]
    return tuple(joint.name for joint in tree.joints if joint.name in legs)


def require_walkable(
    trajectory: Trajectory, robot: Robot, servos: Sequence[Servo], repeats_from: float | None
) -> None:
    """Refuse a trajectory that a robot cannot be sent.

    Args:
        trajectory: The trajectory.
        robot: The robot.
        servos: One per driven joint, in the order of its tree.
        repeats_from: Instant that follows the end, in [s]; None if it is walked once.

    Raises:
        FileError: Joints that it has not or lacks, the first angle of each joint beyond its limits
            and its first jump, with the instants.
    """
    joints = {joint.name: joint for joint in robot.tree.joints}
    driven = [joint.name for joint in robot.tree.joints if joint.servo is not None]
    heads = [
        f"the robot {robot.name!r} has no joint {name!r}{suggestion(name, joints)}"
        if name not in joints
        else f"{name} has no servo in the robot {robot.name!r}; leave the column out"
        for name in trajectory.joints
        if name not in driven
    ]
    lacking = [name for name in leg_joints(robot) if name not in trajectory.joints]
    if lacking:
        heads.append(
            f"the legs' {', '.join(lacking)} are missing; arms and head may be left out, legs not"
        )
    if heads:
        raise FileError(
            [Problem(file=trajectory.file, line=None, column=None, message=m) for m in heads]
        )
    limited = [joints[name] for name in trajectory.joints]
    low, high = (np.array([getattr(j, end) for j in limited]) for end in ("lower", "upper"))
    beyond = (trajectory.angles < low - 1e-6) | (trajectory.angles > high + 1e-6)
    problems = []
    for column in np.flatnonzero(beyond.any(axis=0)):
        row, joint = int(np.argmax(beyond[:, column])), limited[column]
        problems.append(
            trajectory.problem(
                row,
                f"{joint.name} is {_angle(trajectory.angles[row, column])} at "
                f"{trajectory.time[row]:g} s; its limits are {_angle(joint.lower)} and "
                f"{_angle(joint.upper)}",
            )
        )
    speeds = {
        name: servo.no_load_speed * servo.supply / servo.voltage
        for name, servo in zip(driven, servos, strict=True)
    }
    problems += _jumps(trajectory, [speeds[name] for name in trajectory.joints], repeats_from)
    if problems:
        raise FileError(problems)


def _jumps(
    trajectory: Trajectory, speeds: Sequence[float], repeats_from: float | None
) -> list[Problem]:
    """The first change of each joint that no servo could follow even roughly.

    A target that stays the same over several rows has had as long to be reached.
    """
    rows, time = trajectory.angles, trajectory.time
    seam = None if repeats_from is None else int(trajectory.row(np.array([repeats_from]))[0])
    if seam is not None:
        rows = np.vstack([rows, rows[seam]])
        time = np.append(time, trajectory.end)
    problems = []
    for column, (name, speed) in enumerate(zip(trajectory.joints, speeds, strict=True)):
        change = np.abs(np.diff(rows[:, column]))
        turned = np.flatnonzero(change)
        held = np.diff(time[turned + 1], prepend=time[0])
        wrong = np.flatnonzero(change[turned] > speed * (held + LAG))
        if not len(wrong):
            continue
        row, took = int(turned[wrong[0]]) + 1, float(held[wrong[0]])
        at_seam = seam is not None and row == len(time) - 1
        where = "from the last row to the one it repeats from" if at_seam else "in one row"
        problems.append(
            trajectory.problem(
                min(row, len(trajectory.time) - 1),
                f"{name} jumps {where}, at {time[row]:g} s from "
                f"{_angle(rows[row - 1, column])} to {_angle(rows[row, column])}; its servo turns "
                f"at most {speed:.2f} rad/s, {speed * took:.3f} rad in the {took:g} s there are",
            )
        )
    return problems


def _angle(angle: float) -> str:
    return f"{angle:.4f} rad ({degrees(angle):.1f} degrees)"
