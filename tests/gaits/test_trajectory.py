"""A walk from a file of joint angles: what it is, what it is called, and what is refused."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from io import BytesIO
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from gaitlab.balance.ankle_hip import Balance
from gaitlab.cli import run_command_line
from gaitlab.errors import FileError, GaitlabError, Infeasible, WrongValue
from gaitlab.experiment import load_experiment
from gaitlab.experiment.plan import plan
from gaitlab.gaits.trajectory import Gait
from gaitlab.log import TrialLog
from gaitlab.metrics import measure
from gaitlab.model.commands import feet_of, hip_height_of, joint_commands
from gaitlab.model.forward import feet_of_joints
from gaitlab.motions.trajectory import leg_joints, load_trajectory, trajectory_text
from gaitlab.plugins import load_class
from gaitlab.robots.eros import Robot
from gaitlab.servos.files import load_servo
from gaitlab.simulation.simulate import commanded, simulate
from gaitlab.simulation.trial import Trial, plugin
from tests.trials import trial

ROBOT = Robot()
JOINTS = [joint.name for joint in ROBOT.tree.joints]
LEGS = leg_joints(ROBOT)
WALKS = [("eros", "eros"), ("nao", "nao"), ("biped", "biped"), ("flow", "flow"), ("eros", "walk")]
EXACT = 1e-8  # m and rad, of what inverse kinematics has put there


def written(walking: Trial, file: Path) -> Trial:
    """The same trial, walked from a file of its targets."""
    _, targets = commanded(walking)
    time = np.arange(len(targets)) * walking.engine.dt
    file.write_text(trajectory_text(time, JOINTS, targets, ["a walk"]))
    gait = walking.gait
    made = Gait(
        file=str(file),
        period=gait.gait_period,
        repeat=False,
        step_length=gait.step_length,
        stand_time=0.0,
        walk_start=gait.startup_time,
    )
    return replace(walking, gait=made, gait_code=plugin("gait", "trajectory"))


def require_same(one: TrialLog, other: TrialLog) -> None:
    assert len(one) == len(other)
    for name, column in one.arrays.items():
        np.testing.assert_allclose(
            other[name].astype(float), column.astype(float), rtol=0.0, atol=1e-6, err_msg=name
        )
    np.testing.assert_equal(dict(measure(other)), dict(measure(one)))


@pytest.mark.parametrize("surface", ["carpet_4mm", "grass_50mm"])
def test_the_targets_of_a_walk_walked_from_a_file_are_the_same_walk(
    surface: str, tmp_path: Path
) -> None:
    walking = trial(surface, cycles=2.0, step_length=0.04)
    require_same(simulate(walking), simulate(written(walking, tmp_path / "walk.csv")))


def test_a_balance_controller_corrects_a_file_as_it_corrects_the_gait(tmp_path: Path) -> None:
    balance = {"balance": Balance(), "balance_code": plugin("balance", "ankle_hip")}
    walking = replace(trial(cycles=1.0, step_length=0.04), **balance)
    again = written(walking, tmp_path / "walk.csv")
    log, (_, open_loop) = simulate(again), commanded(again)
    sent = np.stack([log[f"{joint}_target"] for joint in JOINTS], axis=-1)
    assert np.abs(sent - open_loop[: len(sent)]).max() > 0.01
    assert simulate(walking)["pitch"].std() == pytest.approx(log["pitch"].std(), rel=0.1)


@pytest.mark.parametrize(("robot_name", "gait_name"), WALKS)
def test_the_feet_of_joints_are_those_that_inverse_kinematics_was_given(
    robot_name: str, gait_name: str
) -> None:
    robot, gait = load_class("robot", robot_name)(), load_class("gait", gait_name)()
    if hasattr(gait, "suited_to"):
        gait = type(gait)(**gait.suited_to(robot))
    feet = gait.feet(np.arange(0.0, gait.startup_time + 2.0 * gait.gait_period, 0.02))
    found = feet_of_joints(robot, joint_commands(robot, feet))
    for name in ("position", "heading", "trunk_pitch"):
        np.testing.assert_allclose(getattr(found, name), getattr(feet, name), atol=EXACT)
    assert not found.swing[0].any()
    swung = (feet.swing == found.swing).all(axis=1)
    assert swung.mean() > 0.8  # a foot that has only just left the ground does not count yet
    assert found.swing.any(axis=0).all()


@pytest.mark.parametrize(("robot_name", "gait_name"), [*WALKS, ("bioloid", "bioloid")])
def test_every_shipped_walk_can_be_walked_from_a_file_and_repeats_without_a_jump(
    robot_name: str, gait_name: str, tmp_path: Path
) -> None:
    robot, gait = load_class("robot", robot_name)(), load_class("gait", gait_name)()
    if hasattr(gait, "suited_to"):
        gait = type(gait)(**gait.suited_to(robot))
    driven = [k for k, joint in enumerate(robot.tree.joints) if joint.servo is not None]
    names = [robot.tree.joints[k].name for k in driven]
    servos = [load_servo(robot.tree.joints[k].servo) for k in driven]
    t = np.arange(round((gait.startup_time + 3.0 * gait.gait_period) / 0.002)) * 0.002
    targets = joint_commands(robot, gait.feet(t))
    file = tmp_path / "walk.csv"
    file.write_text(trajectory_text(t, names, targets[:, driven], ["a walk"]))
    walked = Gait(file=str(file), period=gait.gait_period, stand_time=0.0)
    walked.require_playable(robot, servos)
    again = joint_commands(robot, feet_of(walked, robot, t))
    np.testing.assert_array_equal(again[:, driven], targets[:, driven])


def rows(count: int = 61, **joints: np.ndarray | float) -> dict[str, np.ndarray]:
    """A march on the spot in 0.6 s and the first row again, with some columns set otherwise."""
    gait = trial(step_length=0.0).gait
    time = np.arange(count) * 0.01
    feet = gait.feet(gait.startup_time + time)
    angles = joint_commands(ROBOT, feet)
    table = {"time": time, **dict(zip(JOINTS, angles.T, strict=True))}
    for name, value in joints.items():
        table[name] = np.broadcast_to(value, time.shape)
    return table


def saved(folder: Path, table: dict[str, np.ndarray], name: str = "walk.csv") -> str:
    file = folder / name
    if file.suffix == ".csv":
        pd.DataFrame(table).to_csv(file, index=False)
    elif file.suffix == ".npz":
        np.savez(file, **table)
    else:
        pd.DataFrame(table).to_parquet(file)
    return str(file)


def test_it_is_called_by_what_it_holds_and_not_by_where_it_lies(tmp_path: Path) -> None:
    (tmp_path / "other").mkdir()
    table = rows()
    places = ["walk.csv", "walk.npz", "walk.parquet", "other/renamed.csv"]
    digests = {load_trajectory(saved(tmp_path, table, place)).digest for place in places}
    assert len(digests) == 1
    gaits = [Gait(file=str(tmp_path / place), period=0.6) for place in places]
    walks = [replace(trial(), gait=gait, gait_code=plugin("gait", "trajectory")) for gait in gaits]
    assert len({walk.id for walk in walks}) == 1
    assert Trial.from_dict(walks[0].to_dict()).id == walks[0].id
    table["left_knee"] = table["left_knee"] + 1e-9
    other = replace(walks[0], gait=Gait(file=saved(tmp_path, table), period=0.6))
    assert other.id != walks[0].id
    with pytest.raises(WrongValue, match="changed since the trial was planned"):
        simulate(walks[0])


def test_degrees_are_the_same_walk(tmp_path: Path) -> None:
    table = rows()
    radians = Gait(file=saved(tmp_path, table))
    turned = {name: part if name == "time" else np.degrees(part) for name, part in table.items()}
    degrees = Gait(file=saved(tmp_path, turned, "degrees.csv"), unit="deg")
    t = np.arange(0.0, 1.5, 0.01)
    one, other = (joint_commands(ROBOT, feet_of(g, ROBOT, t)) for g in (radians, degrees))
    np.testing.assert_allclose(one, other, atol=1e-12)


def test_it_stands_then_walks_its_rows_and_repeats_the_last_period(tmp_path: Path) -> None:
    table = rows(60)
    gait = Gait(file=saved(tmp_path, table), period=0.6, stand_time=0.5)
    t = np.arange(0.0, 2.3, 0.002)
    feet = feet_of(gait, ROBOT, t)
    knee = feet.joints["left_knee"]
    expected = table["left_knee"][np.floor((t - 0.5) / 0.01 + 1e-6).astype(int) % 60]
    walking = t >= 0.5
    np.testing.assert_array_equal(knee[walking], expected[walking])
    assert np.isnan(feet.phase[~walking]).all()
    assert (feet.step_index[~walking] == -1).all()
    assert np.abs(np.diff(knee[~walking])).max() < 0.02
    assert feet.step_index.max() == 5
    assert ((feet.phase[walking] >= 0.0) & (feet.phase[walking] < 1.0)).all()
    assert hip_height_of(gait, ROBOT) == pytest.approx(trial().gait.hip_height)
    once = replace(gait, repeat=False)
    last = feet_of(once, ROBOT, np.array([1.09, 1.2, 60.0])).joints["left_knee"]
    assert (last == table["left_knee"][-1]).all()


def test_a_control_period_reads_the_lines_between_rows(tmp_path: Path) -> None:
    gait = Gait(file=saved(tmp_path, rows()), stand_time=0.0, control_period=0.004)
    t = np.arange(0.0, 0.5, 0.002)
    knee = feet_of(gait, ROBOT, t).joints["left_knee"]
    table = rows()
    held = np.floor(t / 0.004 + 1e-6) * 0.004
    np.testing.assert_allclose(knee, np.interp(held, table["time"], table["left_knee"]))


def test_joints_that_a_file_leaves_out_stay_as_the_robot_stands(tmp_path: Path) -> None:
    table = {name: part for name, part in rows().items() if name in ("time", *LEGS)}
    feet = feet_of(Gait(file=saved(tmp_path, table)), ROBOT, np.arange(0.0, 2.0, 0.1))
    for name in set(JOINTS) - set(LEGS):
        assert len(set(feet.joints[name].tolist())) == 1


EXPERIMENT = """\
name: ours
robot: eros
gait: {{type: trajectory, file: ./{file}, {more}}}
surfaces: [hard_floor]
seeds: 1
horizon: {{cycles: 1}}
"""


def planned(folder: Path, file: str = "walk.csv", more: str = "period: 0.6") -> None:
    """Everything that is done before anything runs."""
    (folder / "ours.yaml").write_text(EXPERIMENT.format(file=file, more=more))
    list(plan(load_experiment(folder / "ours.yaml")).trials())


def lines(change: Callable[[list[str]], object]) -> Callable[[Path], None]:
    """A file whose lines are changed by hand."""

    def write(folder: Path) -> None:
        file = Path(saved(folder, rows()))
        text = file.read_text().splitlines()
        change(text)
        file.write_text("\n".join(text))

    return write


def table(**joints: np.ndarray | float) -> Callable[[Path], None]:
    return lambda folder: print(saved(folder, rows(**joints)))


def without(*names: str) -> Callable[[Path], None]:
    kept = {name: part for name, part in rows().items() if name not in names}
    return lambda folder: print(saved(folder, kept))


def jump(row: int) -> np.ndarray:
    angles = rows()["left_knee"].copy()
    angles[row:] -= 0.6
    return angles


WRONG: dict[str, tuple[Callable[[Path], None], tuple[str, ...]]] = {
    "no file": (lambda folder: None, ("no such file",)),
    "a folder": (lambda folder: (folder / "walk.csv").mkdir(), ("no trajectory",)),
    "empty": (lambda folder: (folder / "walk.csv").write_text(""), ("empty",)),
    "bytes": (lambda folder: (folder / "walk.csv").write_bytes(b"\xff\xfe\x00"), ("UTF-8",)),
    "one row": (lines(lambda text: text.__delitem__(slice(2, None))), ("at least two",)),
    "a column too few": (
        lines(lambda text: text.__setitem__(3, text[3].rpartition(",")[0])),
        (":4:", f"{len(JOINTS)} columns", str(len(JOINTS) + 1)),
    ),
    "a text": (lines(lambda text: text.__setitem__(5, "0.04" + ",x" * 20)), (":6:", "'x'")),
    "a nan": (table(left_knee=np.where(np.arange(61) == 7, np.nan, 0.9)), ("left_knee", "no num")),
    "infinite": (table(left_knee=np.inf), (":2:", "left_knee", "inf")),
    "times that go back": (
        table(time=np.where(np.arange(61) == 9, 0.0, np.arange(61) * 0.01)),
        (":11:", "time", "rise"),
    ),
    "degrees": (table(left_knee=45.0), (":2:", "left_knee", "unit: deg")),
    "no time": (without("time"), ("`time`",)),
    "no joint": (without(*JOINTS), ("no column of a joint",)),
    "unknown joint": (table(left_kneee=0.0), ("left_kneee", "did you mean 'left_knee'")),
    "a leg's joint missing": (without("left_knee", "right_knee"), ("left_knee", "right_knee")),
    "beyond a limit": (
        table(left_knee=np.where(np.arange(61) >= 20, 3.0, 0.9)),
        (":22:", "left_knee", "3.0000 rad", "0.2 s", "limits"),
    ),
    "a jump": (table(left_knee=jump(30)), (":32:", "left_knee", "jumps", "0.3 s")),
    "two of a name": (
        lines(lambda text: text.__setitem__(0, text[0].replace("right_knee", "left_knee"))),
        ("two columns", "left_knee"),
    ),
    "another unit": (
        lines(lambda text: text.__setitem__(0, text[0].replace("left_knee", "left_knee [deg]"))),
        ("left_knee", "unit: deg"),
    ),
}


@pytest.mark.parametrize("case", WRONG)
def test_what_is_wrong_in_a_file_is_said_before_anything_runs(case: str, tmp_path: Path) -> None:
    make, told = WRONG[case]
    make(tmp_path)
    with pytest.raises(GaitlabError) as caught:
        planned(tmp_path)
    assert caught.value.exit_code == 3
    for part in told:
        assert part in str(caught.value)


def npy(array: np.ndarray) -> bytes:
    held = BytesIO()
    np.save(held, array)
    return held.getvalue()


UNREADABLE: dict[str, tuple[str, Callable[[Path], object], str]] = {
    "garbage": ("walk.npz", lambda file: file.write_bytes(b"PK\x03\x04rubbish"), "cannot be read"),
    "empty": ("walk.npz", lambda file: file.write_bytes(b""), "cannot be read"),
    "one array": ("walk.npz", lambda file: file.write_bytes(npy(np.zeros(3))), "cannot be read"),
    "objects": (
        "walk.npz",
        lambda file: np.savez(file, time=np.array([{}, {}], dtype=object)),
        "cannot be read",
    ),
    "a matrix": ("walk.npz", lambda file: np.savez(file, time=np.zeros((2, 2))), "shape"),
    "unequal": ("walk.npz", lambda file: np.savez(file, time=[0, 1], left_knee=[0.0]), "shape"),
    "no arrays": ("walk.npz", lambda file: np.savez(file), "empty"),
    "no table": ("walk.parquet", lambda file: file.write_bytes(b"PAR1"), "cannot be read"),
    "texts": (
        "walk.parquet",
        lambda file: pd.DataFrame({"time": ["a", "b"]}).to_parquet(file),
        "cannot be read",
    ),
    "another suffix": ("walk.txt", lambda file: file.write_text("time"), "no trajectory"),
}


@pytest.mark.parametrize("case", UNREADABLE)
def test_what_is_no_table_is_refused(case: str, tmp_path: Path) -> None:
    name, write, told = UNREADABLE[case]
    write(tmp_path / name)
    with pytest.raises(FileError, match=told):
        planned(tmp_path, file=name)


def test_who_stands_as_a_walk_of_joints_is_told_to_say_how(tmp_path: Path) -> None:
    saved(tmp_path, rows())
    text = EXPERIMENT.format(file="walk.csv", more="period: 0.6").replace("gait: ", "walk: ")
    text = text.replace("walk: {", "gait: {type: stand, walk: {").replace("0.6}", "0.6}}")
    (tmp_path / "ours.yaml").write_text(text)
    with pytest.raises(FileError, match="hip_height"):
        load_experiment(tmp_path / "ours.yaml")


def test_a_seam_that_jumps_is_refused_and_one_that_is_not_walked_is_not(tmp_path: Path) -> None:
    slope = rows()["left_knee"] - np.linspace(0.0, 0.8, 61)
    saved(tmp_path, rows(left_knee=slope))
    with pytest.raises(FileError, match="left_knee jumps from the last row to the one it repeats"):
        planned(tmp_path)
    planned(tmp_path, more="period: 0.6, repeat: false")


@pytest.mark.parametrize("more", ["period: 0.9", "walk_start: 1.0", "period: 0.6, walk_start: 0.3"])
def test_a_cycle_that_is_not_in_the_file_is_refused(more: str, tmp_path: Path) -> None:
    saved(tmp_path, rows())
    with pytest.raises(FileError, match="do not fit"):
        planned(tmp_path, more=more)


def test_lower_legs_that_overlap_are_infeasible(tmp_path: Path) -> None:
    crossed = {"left_hip_roll": -0.3, "right_hip_roll": 0.3}
    gait = Gait(file=saved(tmp_path, rows(**crossed)), period=0.6)
    with pytest.raises(Infeasible, match="overlap"):
        simulate(replace(trial(), gait=gait, gait_code=plugin("gait", "trajectory")))


def test_files_are_compared_like_any_other_value(tmp_path: Path) -> None:
    (tmp_path / "late").mkdir()
    saved(tmp_path, rows())
    for name in ("late/walk.csv", "late/other.csv"):
        saved(tmp_path, rows(left_shoulder_pitch=0.1), name)
    text = EXPERIMENT.format(file="walk.csv", more="period: 0.6")
    file = tmp_path / "ours.yaml"
    file.write_text(text + "grid: {gait.file: [./walk.csv, late/walk.csv]}\n")
    with pytest.raises(FileError, match=r"two files walk\.csv"):
        load_experiment(file)
    file.write_text(text + "grid: {gait.file: [./walk.csv, late/other.csv]}\n")
    trials = [item.trial for item in plan(load_experiment(file)).trials()]
    assert len({walking.id for walking in trials}) == 2
    assert [walking.gait.trajectory.file.parent.name for walking in trials][1] == "late"


def test_the_command_line_says_it_with_exit_code_3(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    saved(tmp_path, rows(left_knee=45.0))
    (tmp_path / "ours.yaml").write_text(EXPERIMENT.format(file="walk.csv", more="period: 0.6"))
    assert run_command_line(["run", "ours.yaml"]) == 3
    assert "walk.csv:2:" in capfd.readouterr().err
