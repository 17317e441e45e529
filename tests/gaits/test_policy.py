"""A policy in the loop: what it is fed, what it drives, what it is called, and what is refused."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from dataclasses import replace
from importlib.util import find_spec
from itertools import product
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from gaitlab.cli import run_command_line
from gaitlab.errors import FileError, GaitlabError, WrongValue
from gaitlab.experiment import load_experiment
from gaitlab.experiment.plan import plan
from gaitlab.gaits.policy import Gait
from gaitlab.log import TrialLog
from gaitlab.metrics import measure
from gaitlab.model.commands import servos_for
from gaitlab.model.gait import first_step
from gaitlab.model.imu import Attitude, Imu
from gaitlab.model.servo import driven_by_gains
from gaitlab.motions.declaration import layouts, load_declaration, wired
from gaitlab.motions.pilot import Pilot
from gaitlab.robots.eros import Robot
from gaitlab.servos.files import load_servo
from gaitlab.servos.law import servo_row
from gaitlab.simulation.simulate import commanded, simulate
from gaitlab.simulation.trial import Trial, plugin
from tests.policies import Layer, constant, fitted, save_network
from tests.trials import STILL, trial

ROBOT = Robot()
JOINTS = [joint.name for joint in ROBOT.tree.joints]
CODE = plugin("gait", "policy")
QUIET = Imu(rate_noise=0.0, rate_bias=0.0, attitude_noise=0.0, attitude_bias=0.0)
ENGINE = {"name": "mujoco"} if find_spec("mujoco") else {}
UPRIGHT = Attitude(pitch=0.0, roll=0.0, pitch_rate=0.0, roll_rate=0.0)


def declared(file: Path, *lines: str) -> Path:
    """A declaration beside a network."""
    file.with_suffix(".yaml").write_text("\n".join(lines) + "\n")
    return file


def walking(file: Path, of: Trial | None = None, **gait: object) -> Trial:
    """A trial that a policy walks."""
    of = trial(cycles=1.0, spread=STILL, engine=ENGINE) if of is None else of
    made = Gait(file=str(file), **gait)
    servos = servos_for(made, of.robot, of.servos)
    return replace(of, gait=made, gait_code=CODE, servos=servos)


def targets_of(log: TrialLog) -> np.ndarray:
    return np.stack([log[f"{joint}_target"] for joint in JOINTS], axis=-1)


def imitating(walk: Trial, folder: Path) -> Trial:
    """The same trial walked by a network that was fitted to its gait, start-up included."""
    gait, (_, targets) = walk.gait, commanded(walk)
    cycle = len(gait.cycle.moving)
    every, first = (round(s / walk.engine.dt) for s in (gait.control_period, gait.stand_time))
    sent = targets[first::every][: 3 * cycle]
    t = np.arange(len(sent)) * gait.control_period
    start = gait.startup_time - gait.stand_time
    turned = 2.0 * np.pi * (t / gait.gait_period % 1.0)
    speed = 2.0 * gait.step_length / gait.gait_period
    given = np.column_stack(
        [np.sin(turned), np.cos(turned), np.minimum(t / start, 1.0), 0 * t, 0 * t]
    )
    layers = fitted(given, sent - targets[0], units=256, scale=4.0)
    pose = ", ".join(f"{n}: {a:.12f}" for n, a in zip(JOINTS, targets[0], strict=True))
    file = declared(
        save_network(folder / f"walk_{round(1000 * gait.step_length)}mm.onnx", layers),
        "rate: 100.0",
        f"observations: [phase, {{term: command, scale: {1.0 / speed:.12f}}}]",
        f"period: {gait.gait_period}",
        "action_scale: 1.0",
        f"default_pose: {{{pose}}}",
    )
    settings = {"stand_time": gait.stand_time, "start_time": start, "forward_speed": speed}
    return walking(file, walk, **settings)


def require_imitation(walk: Trial, folder: Path) -> bool:
    """The verdict of both, which has to be one; targets have to be the gait's to 1e-3 rad."""
    by_gait, by_policy = simulate(walk), simulate(imitating(walk, folder))
    n = min(len(by_gait), len(by_policy))
    apart = np.abs(targets_of(by_gait)[:n].astype(float) - targets_of(by_policy)[:n])
    assert apart.max() < 1e-3
    one, other = (measure(log)["stable"] for log in (by_gait, by_policy))
    assert one == other
    assert by_policy.header.course == by_gait.header.course
    assert by_policy.header.gait_period == pytest.approx(by_gait.header.gait_period)
    return bool(one)


@pytest.mark.parametrize("engine", ["mujoco", pytest.param("bullet", marks=pytest.mark.long)])
def test_a_network_fitted_to_a_gait_walks_as_the_gait_does(engine: str, tmp_path: Path) -> None:
    if engine == "mujoco":
        pytest.importorskip("mujoco")
    walks = list(product(("hard_floor", "carpet_4mm", "grass_50mm"), (0.02, 0.06, 0.12)))
    verdicts = [
        require_imitation(
            trial(surface, cycles=3.0, step_length=step, engine={"name": engine}), tmp_path
        )
        for surface, step in (walks if engine == "mujoco" else walks[::2])  # corners and centre
    ]
    assert len(set(verdicts)) == 2, "some walk and some fall"


def test_the_same_trial_is_the_same_log_bit_for_bit(tmp_path: Path) -> None:
    walk = walking(echo(tmp_path, "joint_positions", "joint_velocities", "angular_velocity"))
    one, other = simulate(walk), simulate(Trial.from_dict(walk.to_dict()))
    for name, column in one.arrays.items():
        np.testing.assert_array_equal(other[name], column, err_msg=name)


def echo(folder: Path, *terms: str, gain: float = 1.0, lines: Sequence[str] = ()) -> Path:
    """A policy whose first outputs are the first numbers that it is fed."""
    sizes = {"projected_gravity": 3, "angular_velocity": 3, "command": 3, "phase": 2}
    inputs = sum(sizes.get(term, len(JOINTS)) for term in terms)
    weights = gain * np.eye(inputs, len(JOINTS))
    file = save_network(folder / "echo.onnx", [(weights, np.zeros(len(JOINTS)))])
    listed = f"observations: [{', '.join(terms)}]"
    return declared(file, "rate: 50.0", listed, "action_scale: 1.0", *lines)


@pytest.mark.parametrize("late", [0, 3])
def test_joints_are_fed_as_the_tick_before_left_them_and_targets_come_after_the_delay(
    late: int, tmp_path: Path
) -> None:
    log = simulate(walking(echo(tmp_path, "joint_positions"), stand_time=0.2, delay=0.002 * late))
    sent = targets_of(log)
    felt = np.stack([log[f"{joint}_position"] for joint in JOINTS], axis=-1)
    low, high = (
        np.array([getattr(j, end) for j in ROBOT.tree.joints]) for end in ("lower", "upper")
    )
    acts = np.arange(100, len(log) - 10, 10)
    np.testing.assert_allclose(
        sent[acts + late], np.clip(felt[acts - 1], low, high).astype(np.float32), atol=1e-6
    )
    held = sent[100 + late :]
    changed = np.flatnonzero((held[1:] != held[:-1]).any(axis=1)) + 1
    assert set(changed % 10) == {0}
    np.testing.assert_array_equal(sent[: 100 + late], np.tile(sent[0], (100 + late, 1)))


def test_the_trunk_is_fed_as_an_imu_tells_it_late_and_noisy(tmp_path: Path) -> None:
    file = echo(tmp_path, "angular_velocity", "projected_gravity", gain=0.01)
    imu = replace(QUIET, period=0.002, delay=0.006)
    log = simulate(walking(file, stand_time=0.2, imu=imu))
    sent = 100.0 * (targets_of(log).astype(float) - targets_of(log)[0])
    acts = np.arange(120, len(log) - 10, 10)
    pitch, roll = (log[name][acts - 4].astype(float) for name in ("pitch", "roll"))
    down = [np.sin(pitch), -np.cos(pitch) * np.sin(roll), -np.cos(pitch) * np.cos(roll)]
    np.testing.assert_allclose(sent[acts, 3:6], np.transpose(down), atol=1e-3)
    noisy = simulate(walking(file, stand_time=0.2, imu=replace(imu, attitude_noise=0.1)))
    assert np.abs(targets_of(noisy)[120] - targets_of(log)[120]).max() > 1e-4
    slow = simulate(walking(file, stand_time=0.2, imu=replace(imu, period=0.04)))
    new = np.diff(targets_of(slow)[100:], axis=0).any(axis=1)
    assert set((np.flatnonzero(new) + 1) % 20) == {0}, "a reading is held until the next"


class Remembering:
    """A network that says what it was fed."""

    def __init__(self, outputs: int) -> None:
        self.given: list[np.ndarray] = []
        self.outputs = outputs

    def run(self, row: np.ndarray) -> np.ndarray:
        self.given.append(row.copy())
        return np.full(self.outputs, float(len(self.given)))


def test_history_is_the_oldest_first_in_frames_or_in_terms(tmp_path: Path) -> None:
    common = ("rate: 50.0", "action_scale: 0.5", "history: 3", "joints: [left_knee, right_knee]")
    fed = {}
    for order in ("frames", "terms"):
        file = tmp_path / f"{order}.yaml"
        file.write_text(
            "\n".join([*common, "observations: [last_action, phase]", f"history_order: {order}"])
        )
        wiring = wired(load_declaration(str(file), tmp_path / "none.onnx"), ROBOT, {})
        network = Remembering(2)
        pilot = Pilot(
            network,  # type: ignore[arg-type]
            wiring,
            ["left_knee", "right_knee"],
            command=(0.0, 0.0, 0.0),
            ramp=0.0,
            period=0.8,
            delay=0.0,
        )
        rest = wiring.pose[wiring.columns]
        for k in range(4):
            found = pilot.act(0.2 * k, UPRIGHT, 0.0, rest, np.zeros(2))
            np.testing.assert_allclose(found, rest + 0.5 * (k + 1))
        fed[order] = network.given
    np.testing.assert_allclose(fed["frames"][0], [0, 0, 0, 1] * 3, atol=1e-9)
    np.testing.assert_allclose(fed["frames"][3], [1, 1, 1, 0, 2, 2, 0, -1, 3, 3, -1, 0], atol=1e-9)
    np.testing.assert_allclose(fed["terms"][3], [1, 1, 2, 2, 3, 3, 1, 0, 0, -1, -1, 0], atol=1e-9)


def test_the_command_grows_and_its_distance_is_speed_times_time(tmp_path: Path) -> None:
    file = echo(tmp_path, "command", gain=0.1)
    walk = walking(file, stand_time=0.2, start_time=0.4, forward_speed=0.3, turn_speed=0.2)
    log = simulate(walk)
    moved = 10.0 * (targets_of(log).astype(float) - targets_of(log)[0])
    np.testing.assert_allclose(moved[100:300:10, 0], 0.3 * np.arange(20) / 20, atol=1e-4)
    np.testing.assert_allclose(moved[300:, 0], 0.3, atol=1e-4)
    np.testing.assert_allclose(moved[300:, 2], 0.2, atol=1e-4)
    header = log.header
    assert 2.0 * header.step_length / header.gait_period == pytest.approx(0.3)
    assert 2.0 * header.turn / header.gait_period == pytest.approx(0.2)


def test_who_never_moves_never_takes_a_step(tmp_path: Path) -> None:
    file = declared(
        save_network(tmp_path / "still.onnx", constant(3, np.zeros(len(JOINTS)))),
        "rate: 50.0",
        "observations: [command]",
        "action_scale: 0.25",
    )
    log = simulate(walking(file))
    assert np.isinf(log.header.first_step_time)
    assert not log["fall_cause"].any()
    gait = walking(file).gait
    assert np.isinf(first_step(gait.feet_on(ROBOT, np.arange(0.0, 2.0, 0.01))))


@pytest.mark.parametrize(("kp", "kd"), [(100.0, 2.0), (5.0, 0.05), (40.0, 10.0)])
def test_gains_make_a_servo_of_the_same_motor(kp: float, kd: float) -> None:
    own = load_servo("mx_64")
    made = driven_by_gains(replace(own, supply=11.0), kp=kp, kd=kd)
    row = servo_row([made], np.ones(1))
    limit = replace(own, supply=11.0).largest_torque
    assert row.damping[0] == pytest.approx(kd)
    assert row.gain[0] * row.damping[0] == pytest.approx(kp)
    assert row.limit[0] == pytest.approx(limit)
    assert kd * row.speed[0] >= limit * (1.0 - 1e-12), "at rest it has all its torque"
    assert row.speed[0] >= own.no_load_speed * 11.0 / 12.0 - 1e-12
    assert made.latency == own.latency


def test_declared_gains_reach_the_servos_of_a_trial(tmp_path: Path) -> None:
    file = echo(tmp_path, "command", lines=["kp: {'*': 30.0, '*_knee': 60.0}", "kd: 1.5"])
    (tmp_path / "e.yaml").write_text(
        "robot: eros\ngait: {type: policy, file: ./echo.onnx}\nsurfaces: [hard_floor]\n"
        "grid: {gait.kp_scale: [1.0, 2.0]}\nseeds: 1\n"
    )
    trials = [item.trial for item in plan(load_experiment(str(tmp_path / "e.yaml"))).trials()]
    assert Gait(file=str(file)).digest == trials[0].gait.digest
    for scale, made in zip((1.0, 2.0), trials, strict=True):
        for name, servo in zip(JOINTS, made.servos, strict=True):
            wanted = scale * (60.0 if name.endswith("_knee") else 30.0)
            stiffness = servo.position_gain * servo.stall_torque / servo.no_load_speed
            assert stiffness == pytest.approx(wanted)


def test_it_is_called_by_its_files_and_not_by_where_they_lie(tmp_path: Path) -> None:
    file = echo(tmp_path, "command")
    (tmp_path / "other").mkdir()
    for suffix in (".onnx", ".yaml"):
        shutil.copy(file.with_suffix(suffix), tmp_path / "other" / f"renamed{suffix}")
    walk = walking(file)
    assert walk.id == walking(tmp_path / "other" / "renamed.onnx").id
    assert walk.id == Trial.from_dict(walk.to_dict()).id
    declaration = file.with_suffix(".yaml").read_text()
    declared(file, declaration.replace("50.0", "100.0"))
    assert walking(file).id != walk.id
    with pytest.raises(WrongValue, match="changed since the trial was planned"):
        simulate(walk)
    declared(file, "# a remark", declaration)
    assert walking(file).id == walk.id
    save_network(file, [(2.0 * np.eye(3, len(JOINTS)), np.zeros(len(JOINTS)))])
    assert walking(file).id != walk.id


def test_checkpoints_are_cells_of_one_experiment(tmp_path: Path) -> None:
    for name, gain in (("a", 1.0), ("b", 2.0)):
        file = echo(tmp_path, "command", gain=gain)
        for suffix in (".onnx", ".yaml"):
            file.with_suffix(suffix).rename(tmp_path / f"{name}{suffix}")
    (tmp_path / "e.yaml").write_text(
        "robot: eros\ngait: {type: policy}\nsurfaces: [hard_floor]\n"
        "grid: {gait.file: [./a.onnx, ./b.onnx]}\nseeds: 2\n"
    )
    planned = list(plan(load_experiment(str(tmp_path / "e.yaml"))).trials())
    assert len({item.trial.id for item in planned}) == 4
    assert len({item.trial.gait.digest for item in planned}) == 2
    assert {Path(item.trial.gait.file).name for item in planned} == {"a.onnx", "b.onnx"}


class Size(NamedTuple):
    joints: int
    inputs: int


@pytest.mark.parametrize("name", layouts())
def test_a_published_layout_is_a_declaration_of_one_line(name: str, tmp_path: Path) -> None:
    size = Size(len(JOINTS), 9 + 3 * len(JOINTS) + 2 * (name == "unitree_rl_gym"))
    file = save_network(tmp_path / "walk.onnx", constant(size.inputs, np.zeros(size.joints)))
    Gait(file=str(file), declaration=name).require_playable(ROBOT, ())
    declared(file, f"layout: {name}")
    beside = Gait(file=str(file))
    assert beside.wiring(ROBOT).rate == 50.0
    assert beside.digest == Gait(file=str(file), declaration=name).digest


def test_unitree_rl_gym_is_what_its_deployment_feeds(tmp_path: Path) -> None:
    legs = [name for name in JOINTS if "hip" in name or "knee" in name or "ankle" in name]
    file = tmp_path / "g1.yaml"
    file.write_text(f"layout: unitree_rl_gym\njoints: [{', '.join(legs)}]\n")
    found = wired(load_declaration(str(file), tmp_path / "g1.onnx"), ROBOT, {})
    scales = [0.25] * 3 + [1.0] * 3 + [2.0, 2.0, 0.25] + [1.0] * 12 + [0.05] * 12 + [1.0] * 14
    assert found.inputs == 47  # num_obs of its g1
    np.testing.assert_array_equal(found.scale, scales)


def test_what_an_exporter_wrote_counts_unless_it_is_declared(tmp_path: Path) -> None:
    written = {
        "joint_names": "left_knee,right_knee",
        "default_joint_pos": "0.5,0.6",
        "joint_stiffness": "20.0,30.0",
        "joint_damping": "1.0,2.0",
        "action_scale": "0.125",
    }
    file = declared(
        save_network(tmp_path / "w.onnx", constant(15, [0.0, 0.0]), metadata=written),
        "layout: mjlab",
        "kd: 3.0",
    )
    found = Gait(file=str(file)).wiring(ROBOT)
    assert [JOINTS[column] for column in found.columns] == ["left_knee", "right_knee"]
    np.testing.assert_allclose(found.pose[found.columns], [0.5, 0.6])
    np.testing.assert_allclose(found.action_scale, 0.125)
    assert found.gains == {"left_knee": (20.0, 3.0), "right_knee": (30.0, 3.0)}


NONE = np.zeros(len(JOINTS))
GOOD = ("rate: 50.0", "observations: [command, phase]", "action_scale: 0.01")
ROOT_OF_PHASE: list[Layer] = [  # sqrt(sin), a number for half of a cycle
    (np.eye(5)[:, 3:4], np.zeros(1)),
    (np.ones((1, len(JOINTS))), NONE),
]


def wrong_networks(folder: Path) -> dict[str, tuple[Path, str]]:
    """Files that are no policy of this declaration, and what is said of each."""
    file, five = folder / "wrong.onnx", constant(5, NONE)
    two = [(np.zeros((5, 4)), np.zeros(4)), (np.zeros((4, len(JOINTS))), NONE)]
    return {
        "input": (save_network(folder / "i.onnx", constant(7, NONE)), "takes 7 .* declared are 5"),
        "output": (save_network(folder / "o.onnx", constant(5, [0.0] * 7)), "gives 7 .* are 20"),
        "external": (save_network(folder / "x.onnx", five, external=True), "external data"),
        "custom": (
            save_network(folder / "c.onnx", two, activation="Mine", domain="our.ops"),
            "custom operator",
        ),
        "two inputs": (save_network(folder / "t.onnx", five, inputs=("obs", "memory")), "2 inputs"),
        "an image": (save_network(folder / "m.onnx", five, shape=[4, 5]), "shape 4 x 5"),
        "nan": (save_network(folder / "n.onnx", constant(5, NONE + np.nan)), "gave nan for"),
        "open size": (
            save_network(folder / "s.onnx", constant(7, NONE), shape=["batch", "numbers"]),
            "does not run",
        ),
        "no network": (file, "no network that onnxruntime can run"),
        "missing": (folder / "missing.onnx", "no such file"),
        "csv": (folder / "walk.csv", "is no policy"),
    }


KINDS = ["input", "output", "external", "custom", "two inputs", "an image", "nan", "open size"]


@pytest.mark.parametrize("kind", [*KINDS, "no network", "missing", "csv"])
def test_a_network_that_is_no_policy_is_refused_before_anything_walks(
    kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "wrong.onnx").write_bytes(b"no network")
    (tmp_path / "walk.csv").write_text("time,left_knee\n0,0\n")
    file, said = wrong_networks(tmp_path)[kind]
    declared(file, *GOOD)
    assert refused(tmp_path, f"{{type: policy, file: ./{file.name}}}", capsys, said)


def refused(
    folder: Path, gait: str, capsys: pytest.CaptureFixture[str], said: str, more: str = ""
) -> bool:
    """Whether an experiment with this gait is exit 3 before anything walks, and says why."""
    (folder / "e.yaml").write_text(
        f"robot: eros\ngait: {gait}\nsurfaces: [hard_floor]\nseeds: 1\n{more}"
    )
    code = run_command_line(["run", str(folder / "e.yaml"), "--store", str(folder / "data")])
    message = " ".join(capsys.readouterr().err.split())
    assert code == 3, message
    assert "Traceback" not in message
    with pytest.raises(GaitlabError, match=said):
        load_experiment(str(folder / "e.yaml"))
    return True


@pytest.mark.parametrize(
    ("lines", "said"),
    [
        (["joints: [left_knee, left_kneee]"], "no joint 'left_kneee'.*left_knee"),
        (["joints: [left_knee, left_knee]"], "stands twice"),
        (["joints: left_knee"], "a list of names"),
        (["default_pose: {left_kneee: 0.1}"], "no joint is called 'left_kneee'"),
        (["default_pose: {left_knee: -2.0}"], "its limits are"),
        (["default_pose: {left_knee: 20.0}"], "20"),
        (["kp: 30.0"], "come together"),
        (["kp: {left_knee: 30.0}", "kd: 1.0"], "is missing"),
        (["kp: 30.0", "kd: 0.0"], "kd"),
        (["kp: [30.0, 20.0]", "kd: 1.0"], "2 numbers for 20 joints"),
        (["rate: 0.0"], "rate"),
        (["rates: 50.0"], "rates"),
        (["observations: [comand]"], "nothing is called 'comand'.*command"),
        (["observations: []"], "observations"),
        (["observations: [{term: command, scale: [1.0, 2.0]}]"], "3 numbers and 2 scales"),
        (["layout: legged"], "layout"),
        (["history: 0"], "history"),
        (["action_scale: {left_knee: big}"], "action_scale"),
    ],
)
def test_a_wrong_declaration_is_refused_at_its_line(
    lines: Sequence[str], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    keys = {line.partition(":")[0] for line in lines}
    kept = [line for line in GOOD if line.partition(":")[0] not in keys]
    file = declared(save_network(tmp_path / "w.onnx", constant(5, NONE)), *kept, *lines)
    assert refused(tmp_path, "{type: policy, file: ./w.onnx}", capsys, said)
    with pytest.raises(FileError) as error:
        Gait(file=str(file)).require_playable(ROBOT, ())
    assert all(problem.line for problem in error.value.problems)


def test_a_policy_without_a_declaration_says_how_to_declare_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    save_network(tmp_path / "w.onnx", constant(5, NONE))
    assert refused(tmp_path, "{type: policy, file: ./w.onnx}", capsys, "declaration: isaac_lab")
    other = "{type: policy, file: ./w.onnx, declaration: isac_lab}"
    assert refused(tmp_path, other, capsys, "isaac_lab")


def test_a_policy_balances_by_itself(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    declared(save_network(tmp_path / "w.onnx", constant(5, NONE)), *GOOD)
    gait = "{type: policy, file: ./w.onnx}"
    assert refused(tmp_path, gait, capsys, "balances by itself", "balance: ankle_hip\n")


def test_without_onnxruntime_it_says_how_to_get_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    declared(save_network(tmp_path / "w.onnx", constant(5, NONE)), *GOOD)
    monkeypatch.setattr("gaitlab.motions.network.find_spec", lambda name: None)
    gait = "{type: policy, file: ./w.onnx}"
    assert refused(tmp_path, gait, capsys, r"gaitlab\[policy\]")


def test_what_is_no_number_while_it_walks_is_no_result(tmp_path: Path) -> None:
    file = save_network(tmp_path / "w.onnx", ROOT_OF_PHASE, activation="Sqrt")
    walk = walking(declared(file, *GOOD, "period: 0.8"))
    walk.gait.require_playable(ROBOT, ())
    with pytest.raises(WrongValue, match=r"gave nan for \w+ 0\.4\d\d s after it took over"):
        simulate(walk)


def test_a_trial_whose_policy_goes_wrong_fails_with_the_reason(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = save_network(tmp_path / "w.onnx", ROOT_OF_PHASE, activation="Sqrt")
    declared(file, *GOOD, "period: 0.8")
    (tmp_path / "e.yaml").write_text(
        "robot: eros\ngait: {type: policy, file: ./w.onnx}\nsurfaces: [hard_floor]\nseeds: 1\n"
        "horizon: {cycles: 1}\n"
    )
    command = ["run", str(tmp_path / "e.yaml"), "--store", str(tmp_path / "data"), "-j", "0"]
    assert run_command_line(command) == 4
    found = capsys.readouterr()
    assert "gave nan" in " ".join((found.out + found.err).split())
