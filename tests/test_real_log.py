"""A real robot's log beside its simulation; the real robot is a simulated one of another seed."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from gaitlab.cli import run_command_line
from gaitlab.errors import FileError
from gaitlab.kinematics.transforms import axis_rotation, quaternion_of
from gaitlab.running.real_log import LogComparison, Residual, compare_log, replays
from gaitlab.simulation.simulate import commanded, simulate
from tests.trials import trial

EVERY = 5  # ticks of 2 ms between two rows
STAND = 1.0  # s, until the first row is reached


@pytest.fixture(scope="module")
def table() -> dict[str, np.ndarray]:
    """Targets of a short march and what a robot measured of them, replicate 77 of its kind."""
    walking = trial("hard_floor", cycles=1.5, step_length=0.0, seed=77)
    _, targets = commanded(walking)
    log = simulate(walking)
    rows = slice(EVERY, len(log), EVERY)
    joints = [joint.name for joint in walking.robot.tree.joints]
    found = {"time": np.arange(len(targets))[rows] * 0.002}
    found |= {name: targets[rows, k] for k, name in enumerate(joints)}
    before = slice(EVERY - 1, len(log) - 1, EVERY)  # rows of a log are at the ends of ticks
    found |= {f"{name}_measured": log[f"{name}_position"][before] for name in joints}
    found |= {"imu_pitch": log["pitch"][before], "imu_roll": log["roll"][before]}
    return {name: np.asarray(values, dtype=float) for name, values in found.items()}


def compared(folder: Path, table: dict[str, np.ndarray], *settings: str) -> LogComparison:
    pd.DataFrame(table).to_csv(folder / "walk.csv", index=False)
    return compare_log(replays(folder / "walk.csv", "eros", "hard_floor", 2, settings))


def by_name(found: LogComparison) -> dict[str, Residual]:
    return {one.quantity: one for one in found.residuals}


def test_a_robot_of_the_same_kind_is_near_and_the_intervals_hold_the_means(
    table: dict[str, np.ndarray], tmp_path: Path
) -> None:
    found = compared(tmp_path, table)
    assert found.falls == 0
    assert found.rows == len(table["time"])
    assert len(found.residuals) == (len(table) - 1 - 2) // 2 + 3
    for one in found.residuals:
        assert one.mean_interval.low <= one.mean <= one.mean_interval.high
        if one.quantity == "step time":
            assert abs(one.mean) < 0.02
        else:
            assert one.rms_interval.low <= one.rms <= one.rms_interval.high
            assert one.rms < 0.05
            assert abs(one.mean) <= one.rms


def test_what_is_added_to_a_measurement_is_missing_in_the_simulation(
    table: dict[str, np.ndarray], tmp_path: Path
) -> None:
    before = by_name(compared(tmp_path, table))
    moved = {
        **table,
        "left_knee_measured": table["left_knee_measured"] + 0.1,
        "imu_pitch": table["imu_pitch"] - 0.2,
    }
    after = by_name(compared(tmp_path, moved))
    for name, shift in (("left_knee", -0.1), ("trunk pitch", 0.2), ("right_knee", 0.0)):
        assert after[name].mean - before[name].mean == pytest.approx(shift, abs=1e-9)
        assert after[name].rms >= abs(shift) - before[name].rms


def test_a_quaternion_says_the_same_as_angles(table: dict[str, np.ndarray], tmp_path: Path) -> None:
    rotation = axis_rotation("y", table["imu_pitch"]) @ axis_rotation("x", table["imu_roll"])
    turned = {name: part for name, part in table.items() if not name.startswith("imu_")}
    for name, part in zip("xyzw", quaternion_of(rotation).T, strict=True):
        turned[f"imu_q{name}"] = part
    one, other = by_name(compared(tmp_path, table)), by_name(compared(tmp_path, turned))
    for name in ("trunk pitch", "trunk roll"):
        assert other[name].rms == pytest.approx(one[name].rms, rel=1e-6)


def test_slow_steps_are_told(table: dict[str, np.ndarray], tmp_path: Path) -> None:
    """The measured robot does all in three quarters of the time: simulated steps are longer."""
    quick = dict(table)
    for name in table:
        if name.endswith("_measured"):
            at = np.minimum(table["time"] * 4.0 / 3.0, table["time"][-1])
            quick[name] = np.interp(at, table["time"], table[name])
    step = by_name(compared(tmp_path, quick))["step time"]
    assert 0.05 < step.mean < 0.15


def test_it_ends_where_a_simulated_walk_falls(table: dict[str, np.ndarray], tmp_path: Path) -> None:
    falling = dict(table)
    for side in ("left", "right"):
        name = f"{side}_ankle_pitch"
        late = np.clip(table["time"] - 1.0, 0.0, 0.6)
        falling[name] = table[name] + late
    found = compared(tmp_path, falling)
    assert found.falls == 2
    assert found.time <= found.first_fall < table["time"][-1]


def test_degrees_and_no_stand(table: dict[str, np.ndarray], tmp_path: Path) -> None:
    degrees = {n: part if n == "time" else np.degrees(part) for n, part in table.items()}
    one = by_name(compared(tmp_path, table))
    other = by_name(compared(tmp_path, degrees, "gait.unit=deg"))
    assert other["left_knee"].rms == pytest.approx(one["left_knee"].rms, rel=1e-3)
    assert other["trunk pitch"].rms == pytest.approx(one["trunk pitch"].rms, rel=1e-3)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda t: {n: c for n, c in t.items() if "_measured" not in n and "imu" not in n}, "not"),
        (lambda t: {**t, "left_kne_measured": t["left_knee"]}, "left_kne"),
        (lambda t: {**t, **{f"imu_q{a}": t["time"] * 0.0 + 2.0 for a in "xyzw"}}, "quaternion"),
        (lambda t: {**t, "left_knee_measured": t["left_knee"] * np.nan}, "no number"),
    ],
)
def test_what_cannot_be_compared_is_said(change, told, table, tmp_path: Path) -> None:
    with pytest.raises(FileError, match=told):
        compared(tmp_path, change(table))


def test_the_command_prints_every_residual(
    table: dict[str, np.ndarray],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    pd.DataFrame(table).to_csv("walk.csv", index=False)
    words = ["compare-log", "walk.csv", "--robot", "eros", "--seeds", "2"]
    assert run_command_line([*words, "--json"]) == 0
    found = json.loads(capfd.readouterr().out)
    assert found["seeds"] == 2
    assert run_command_line(words) == 0
    printed = capfd.readouterr().out
    for one in found["residuals"]:
        assert one["quantity"] in printed
    assert run_command_line(["compare-log", "walk.csv", "--robot", "nao"]) == 3


def test_walking_a_log_needs_none_of_what_was_measured(
    table: dict[str, np.ndarray], tmp_path: Path
) -> None:
    compared_trial = replays_of(table, tmp_path, "all.csv")
    plain = {name: part for name, part in table.items() if "_measured" not in name}
    assert replays_of(plain, tmp_path, "plain.csv").id == compared_trial.id
    assert replace(compared_trial, seed=1).id != compared_trial.id


def replays_of(table: dict[str, np.ndarray], folder: Path, name: str):
    pd.DataFrame(table).to_csv(folder / name, index=False)
    return replays(folder / name, "eros", "hard_floor", 2)[0]
