"""`gaitlab robot` and robots of files in other commands, as a team with a URDF meets them."""

from __future__ import annotations

import json
import re
from math import pi, sqrt
from pathlib import Path

import numpy as np
import pytest

from gaitlab.cli import run_command_line
from gaitlab.errors import Infeasible
from gaitlab.experiment import load_experiment
from gaitlab.experiment.json_schema import MODELINE
from gaitlab.experiment.plan import plan
from gaitlab.log import GRAVITY
from gaitlab.model.foreign.findings import DIRECTIONS, FINEST, standing_torques
from gaitlab.model.foreign.robot import ForeignRobot
from gaitlab.model.foreign.robot_file import load_robot
from gaitlab.model.stance import stance_of, standing_feet
from gaitlab.model.urdf import urdf
from gaitlab.robots import eros, nao
from tests.test_cli import Printed

EROS, NAO = eros.Robot(), nao.Robot()
TORQUE, SPEED = 6.0, 7.0  # of every joint of the URDFs here
FILES = ("stand.png", "my_robot.yaml", "my_first_walk.yaml")


def text_of(robot=EROS, effort: float = TORQUE, velocity: float = SPEED) -> str:
    return urdf(robot.tree, robot.sole, robot.feet, effort=effort, velocity=velocity)


def changed(old: str, new: str, *, count: int = 1) -> str:
    """The URDF of EROS with something else in it."""
    assert old in text_of()
    return text_of().replace(old, new, count)


@pytest.fixture
def gaitlab(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]):
    """Run a command in a folder with a URDF of EROS."""
    monkeypatch.chdir(tmp_path)
    Path("my.urdf").write_text(text_of())

    def command(*arguments: str) -> Printed:
        code = run_command_line(arguments)
        return Printed((code, *capfd.readouterr()))

    return command


def found_in(gaitlab, *arguments: str) -> dict:
    done = gaitlab("robot", *arguments, "--json")
    assert done.code == 0, done.err
    found: dict = json.loads(done.out)
    return found


@pytest.mark.parametrize(("robot", "roles"), [(EROS, "YRPPPR"), (NAO, "pRPPPR")], ids=["e", "n"])
def test_the_numbers_are_the_robots_own(gaitlab, robot, roles: str) -> None:
    Path("my.urdf").write_text(text_of(robot))
    found, stance = found_in(gaitlab, "my.urdf"), stance_of(robot)
    assert (found["links"], found["joints"]) == (len(robot.tree.links), len(robot.tree.joints))
    assert found["mass"] == pytest.approx(robot.tree.mass, abs=1e-9)
    legs, sole, stands = found["legs"], found["sole"], found["stance"]
    assert (legs["feet"], legs["roles"]) == (list(robot.feet), roles)
    assert legs["length"] == pytest.approx(stance.leg_length, abs=1e-6)
    assert legs["mirror_misfit"] < 1e-6
    for name in ("length", "width", "heel", "height"):
        assert sole[name] == pytest.approx(getattr(robot.sole, name), abs=1e-6)
    assert sole["heel_behind_joint"] == pytest.approx(robot.sole.heel, abs=1e-6)
    assert stands["hip_height"] == pytest.approx(stance.hip_height, abs=1e-6)
    if robot is EROS:  # NAO's arms are held otherwise by its own class
        assert stands["com_height"] == pytest.approx(stance.com_height, abs=2e-3)
    assert stands["natural_period"] == pytest.approx(2 * pi * sqrt(stands["com_height"] / GRAVITY))
    assert abs(stands["com_ahead"]) < 1e-4
    assert stands["knees"] == "forward"
    servos = found["servos"]
    assert [(each["stated_by"], each["torque"], each["speed"]) for each in servos] == [
        ("URDF", TORQUE, SPEED)
    ]
    assert len(servos[0]["joints"]) == len(robot.tree.joints)


def test_standing_is_what_virtual_work_says() -> None:
    """Turning a joint lifts all that hangs on it against gravity and the load on the sole."""
    robot = foreign(text_of())
    stance = stance_of(robot)
    feet = standing_feet(stance.hip_height, stance.step_width, stance.com_offset)
    joints, half = robot.joint_targets(feet), robot.tree.mass * GRAVITY / 2.0

    def energy(angles: np.ndarray) -> float:
        poses = robot.tree.poses(np.zeros((1, 3)), np.eye(3)[None], angles[None])
        lifted = robot.tree.mass * GRAVITY * float(robot.tree.centre_of_mass(poses)[0, 2])
        for side, foot in enumerate(robot.feet):
            k = robot.tree.index(foot)
            sole = poses.position[0, k] + poses.rotation[0, k] @ robot.sole.centre_of(side)
            lifted -= half * float(sole[2])
        return lifted

    step = 1e-5 * np.eye(joints.shape[1])
    slope = [(energy(joints[0] + s) - energy(joints[0] - s)) / 2e-5 for s in step]
    np.testing.assert_allclose(standing_torques(robot, joints), slope, atol=1e-6)


def foreign(text: str, name: str = "my.urdf") -> ForeignRobot:
    Path(name).write_text(text)
    made: ForeignRobot = load_robot(Path(name).resolve()).cls()
    return made


@pytest.fixture(autouse=True)
def in_a_folder_of_its_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_a_foot_gets_as_far_as_is_said_and_no_farther(gaitlab) -> None:
    found, robot = found_in(gaitlab, "my.urdf"), foreign(text_of())
    stance = stance_of(robot)
    joints = {joint.name for joint in robot.tree.joints}
    for name, way in DIRECTIONS.items():
        reach = found["reach"][name]
        for distance, reached in ((reach["distance"], True), (reach["distance"] + FINEST, False)):
            feet = standing_feet(stance.hip_height, stance.step_width, stance.com_offset)
            feet.position[:, 0] += distance * np.array(way)
            try:
                robot.joint_targets(feet)
            except Infeasible:
                assert not reached, name
            else:
                assert reached, name
        assert reach["ends"] in joints | {"straight leg", "folded leg"}


def test_the_drafts_load_and_plan(gaitlab) -> None:
    found = found_in(gaitlab, "my.urdf")
    assert found["files"] == dict.fromkeys(FILES, "written")
    assert Path("stand.png").read_bytes().startswith(b"\x89PNG")
    drafted, own = (
        load_robot(Path("my_robot.yaml").resolve()),
        load_robot(Path("my.urdf").resolve()),
    )
    assert drafted.digest == own.digest
    planned = plan(load_experiment("my_first_walk.yaml"))
    assert (planned.cell_count, planned.size) == (4, 40)
    (robot,) = {item.trial.names.robot for item in planned.trials()}
    assert robot == "my_robot"
    done = gaitlab("run", "my_first_walk.yaml", "--dry-run")
    assert done.code == 0
    assert "runs code" not in done.out  # a description is read and never run


@pytest.mark.parametrize("velocity", [SPEED, 100.0], ids=["stated", "unstated"])
def test_a_line_of_the_draft_says_the_same_without_its_mark(gaitlab, velocity: float) -> None:
    Path("my.urdf").write_text(text_of(velocity=velocity))
    assert gaitlab("robot", "my.urdf").code == 0
    draft = Path("my_robot.yaml")
    before = load_robot(draft.resolve())
    schema, *said = draft.read_text().split("\n")
    assert schema.startswith(MODELINE)
    lines = [re.sub(r"^# ( *\S+: ?|servos:$)", r"\1", line) for line in said]
    draft.write_text("\n".join(lines[:2] + [x for x in lines[2:] if not x.startswith("#")]))
    after = load_robot(draft.resolve())
    keys = {"urdf", "servos", "mass", "posture", "legs", "sole", "forward", "description"}
    assert {line.partition(":")[0] for line in lines if re.match(r"\w+:", line)} == keys
    assert after.digest == before.digest
    assert (before.unstated == ()) == (velocity == SPEED)
    assert after.unstated == ()
    one, other = before.cls(), after.cls()
    assert other.mass == pytest.approx(one.mass, rel=1e-5)
    assert other.sole.corners() == pytest.approx(one.sole.corners(), abs=1e-6)
    for joint, again in zip(one.tree.joints, other.tree.joints, strict=True):
        servo, same = one.own_servos[joint.servo], other.own_servos[again.servo]
        assert same.stall_torque == pytest.approx(servo.stall_torque, rel=1e-5)
        assert same.position_gain == servo.position_gain


def test_names_that_yaml_would_take_for_something_else_are_drafted(gaitlab) -> None:
    text = (
        text_of(velocity=100.0).replace("left_foot", "left 'foot': #1").replace("_knee", "/k.n e")
    )
    text = text.replace('<robot name="robot"', '<robot name="a: &apos;b&apos;&#10;c: {"')
    Path("my.urdf").write_text(text)
    assert gaitlab("robot", "my.urdf").code == 0
    draft = Path("my_robot.yaml")
    before = load_robot(draft.resolve())
    draft.write_text(re.sub(r"^# (?=legs|description|posture)", "", draft.read_text(), flags=re.M))
    assert load_robot(draft.resolve()).digest == before.digest
    assert plan(load_experiment("my_first_walk.yaml")).size == 40


def test_a_draft_that_was_edited_is_kept_unless_forced(gaitlab) -> None:
    assert gaitlab("robot", "my.urdf").code == 0
    edited = Path("my_robot.yaml").read_text() + "mass: 3.0\n"
    Path("my_robot.yaml").write_text(edited)
    assert found_in(gaitlab, "my.urdf")["files"] == dict(
        zip(FILES, ("written", "kept", "written"), strict=True)
    )
    assert Path("my_robot.yaml").read_text() == edited
    found = found_in(gaitlab, "my_robot.yaml")
    assert found["mass"] == pytest.approx(3.0)
    assert set(found["files"]) == {"stand.png", "my_first_walk.yaml"}
    assert set(found_in(gaitlab, "my.urdf", "--force")["files"].values()) == {"written"}
    assert Path("my_robot.yaml").read_text() != edited


def test_a_picture_of_somebody_elses_is_not_lost(gaitlab) -> None:
    Path("stand.png").write_bytes(b"\x89PNG ours")
    assert gaitlab("robot", "my.urdf").code == 2
    assert Path("stand.png").read_bytes() == b"\x89PNG ours"
    assert gaitlab("robot", "my.urdf", "--force").code == 0


def test_the_same_robot_gives_the_same_picture(gaitlab) -> None:
    for folder in ("one", "other"):
        assert gaitlab("robot", "my.urdf", "--output", folder).code == 0
    one, other = (Path(folder, "stand.png").read_bytes() for folder in ("one", "other"))
    assert one == other


def test_what_is_set_is_reckoned_with_and_drafted(gaitlab) -> None:
    words = ("--set", "mass=3.3", "--set", "sole.length=0.2", "--set", "servos.default=mx_106")
    found = found_in(gaitlab, "my.urdf", *words, "--output", "there")
    assert found["mass"] == pytest.approx(3.3)
    assert (found["sole"]["length"], found["sole"]["stated"]) == (0.2, ["length"])
    assert {servo["stated_by"] for servo in found["servos"]} == {"servo file"}
    assert found_in(gaitlab, "there/my_robot.yaml", "--output", "again")["mass"] == found["mass"]
    assert plan(load_experiment("there/my_first_walk.yaml")).size == 40


def test_a_servo_that_cannot_hold_the_stance_is_named_and_the_files_are_there(gaitlab) -> None:
    Path("my.urdf").write_text(text_of(effort=0.1))
    done = gaitlab("robot", "my.urdf")
    assert done.code == 0
    assert re.search(r"cannot stand: \w+ needs", done.out)
    assert all(Path(name).is_file() for name in FILES)
    (servo,) = found_in(gaitlab, "my.urdf")["servos"]
    assert servo["standing_torque"] > servo["torque"]
    assert servo["standing_joint"] in servo["joints"]


ROBOT_FILE = "urdf: ./my.urdf\n"
BAD: dict[str, tuple[str, str | bytes, str]] = {  # file, what it holds, what is said
    "binary": ("b.urdf", b"\x93\x00\xff\xfe", "b.urdf"),
    "empty URDF": ("e.urdf", "", "e.urdf"),
    "empty file": ("e.yaml", "", "empty"),
    "no urdf": ("n.yaml", "mass: 3.0\n", "urdf"),
    "no such urdf": ("n.yaml", "urdf: ./gone.urdf\n", "gone.urdf"),
    "no such joint": ("p.yaml", f"{ROBOT_FILE}posture: {{'.*wing': 0.1}}\n", "p.yaml:2:11"),
    "no pattern": ("p.yaml", f"{ROBOT_FILE}posture: {{'(': 0.1}}\n", "p.yaml:2:11"),
    "unknown servo": ("s.yaml", f"{ROBOT_FILE}servos: mx_65\n", "mx_64"),
    "unknown key": ("k.yaml", f"{ROBOT_FILE}servo: mx_64\n", "servos"),
    "broken XML": ("x.urdf", changed("<joint", "<joint <"), r"x.urdf:\d+:\d+"),
    "entities": ("x.urdf", changed("<robot", '<!DOCTYPE a [<!ENTITY b "c">]><robot'), "DOCTYPE"),
    "no joints": ("x.urdf", "<robot name='a'><link name='b'/></robot>", "joint"),
    "two roots": ("x.urdf", changed("</robot>", "<link name='b'/></robot>"), r"x.urdf:\d+:\d+"),
    "same name": ("x.urdf", changed("</robot>", "<link name='trunk'/></robot>"), "trunk"),
    "dangling": ("x.urdf", changed('<parent link="trunk"', '<parent link="trunc"'), "trunc"),
    "one leg": ("x.urdf", "", "mirror"),
    "knees": ("x.urdf", "", "knees"),
    "stiff knees": ("x.urdf", "", "cannot stand.*knee"),
    "millimetres": ("x.urdf", "", "metres"),
    "too heavy": ("x.urdf", changed("<mass value=\"", "<mass value=\"999"), "kg"),
    "no sole": ("x.urdf", "", "sole"),
}  # fmt: skip


def odd(case: str) -> str:
    """A URDF of EROS with a fault that takes more than a word."""
    text = text_of()
    if case == "one leg":
        return text.replace('axis xyz="0 1 0"', 'axis xyz="0.6 0.8 0"', 3)
    if case == "knees":
        knee = next(joint for joint in EROS.tree.joints if joint.name == "right_knee")
        start = text.index('<joint name="right_knee"')
        limits = f'lower="{knee.lower!r}" upper="{knee.upper!r}"'
        assert limits in text[start:]
        turned = f'lower="{-knee.upper!r}" upper="{-knee.lower!r}"'
        return text[:start] + text[start:].replace(limits, turned, 1)
    if case == "stiff knees":
        for joint in EROS.tree.joints:
            if joint.name.endswith("knee"):
                start = text.index(f'<joint name="{joint.name}"')
                rest = text[start:].replace(f'upper="{joint.upper!r}"', 'upper="0.05"', 1)
                text = text[:start] + rest
        return text
    if case == "millimetres":

        def longer(found: re.Match[str]) -> str:
            return f'xyz="{" ".join(str(1000.0 * float(x)) for x in found[1].split())}"'

        return re.sub(r'xyz="([^"]*\.[^"]*)"', longer, text)
    return re.sub(r"<(visual|collision)>.*?</\1>", "", text, flags=re.DOTALL)


@pytest.mark.parametrize("case", BAD)
def test_a_mistake_is_told_where_it_stands_and_nothing_is_written(gaitlab, case: str) -> None:
    name, content, said = BAD[case]
    content = content if content or "empty" in case else odd(case)
    Path(name).write_bytes(content if isinstance(content, bytes) else content.encode())
    done = gaitlab("robot", f"./{name}")
    assert done.code == 3, done.out
    assert re.search(said, done.err), done.err
    assert "Traceback" not in done.err
    assert not any(Path(file).exists() for file in FILES)


@pytest.mark.parametrize(
    ("file", "code"), [(".", 3), ("gone.urdf", 3), ("gone", 3), ("eros", 2), ("my.txt", 3)]
)
def test_what_is_no_urdf_is_told_so(gaitlab, file: str, code: int) -> None:
    done = gaitlab("robot", file)
    assert (done.code, done.out) == (code, "")
    assert done.err
    assert "Traceback" not in done.err


def test_a_sole_that_nothing_shows_may_be_set(gaitlab) -> None:
    Path("my.urdf").write_text(odd("no sole"))
    done = gaitlab("robot", "my.urdf")
    assert done.code == 3
    lengths = {"length": 0.12, "width": 0.07, "height": 0.03}
    words = [w for key, value in lengths.items() for w in ("--set", f"sole.{key}={value}")]
    sole = found_in(gaitlab, "my.urdf", *words)["sole"]
    assert {key: sole[key] for key in lengths} == lengths
    assert load_robot(Path("my_robot.yaml").resolve()).cls().sole.length == 0.12


def test_show_knows_a_robots_file_and_where_its_servos_are(gaitlab) -> None:
    Path("our.yaml").write_text("urdf: ./my.urdf\nservos: {default: mx_64, left_knee: "
                                "{stall_torque: 9, no_load_speed: 5}}\n")  # fmt: skip
    for file in ("my.urdf", "our.yaml"):
        done = gaitlab("show", file)
        assert done.code == 0, done.err
        (mass,) = [line for line in done.out.splitlines() if line.startswith("mass ")]
        assert float(mass.split()[1]) == pytest.approx(EROS.tree.mass, rel=1e-5)
    rows = [line for line in done.out.splitlines() if "left_knee" in line]
    assert any(re.search(r"\b9 +5 +left_knee\b", row) for row in rows)
    assert "gaitlab show mx_64" in done.out


def test_ik_and_fk_take_a_robots_file(gaitlab) -> None:
    target = ["0.02", "0.05", "-0.22"]
    found = gaitlab("ik", "my.urdf", "left_leg", "--target", *target, "--json")
    assert found.code == 0, found.err
    joints = [str(angle) for angle in json.loads(found.out)["joints"].values()]
    pose = json.loads(gaitlab("fk", "my.urdf", "left_leg", "--joints", *joints, "--json").out)
    np.testing.assert_allclose(pose["position"], [float(x) for x in target], atol=1e-9)
    np.testing.assert_allclose(pose["rotation"], np.eye(3), atol=1e-9)


@pytest.mark.parametrize("robot", [EROS, NAO], ids=["eros", "nao"])
def test_a_robot_that_is_exported_is_the_same_robot_when_read(robot) -> None:
    once = foreign(text_of(robot))
    twice = foreign(text_of(once), "again.urdf")
    assert twice.found.feet == once.found.feet
    assert twice.tree.mass == pytest.approx(once.tree.mass, abs=1e-9)
    for one, other in zip(once.tree.links, twice.tree.links, strict=True):
        assert other.name == one.name
        assert other.mass == pytest.approx(one.mass, abs=1e-9)
        assert other.centre == pytest.approx(one.centre, abs=1e-7)
        assert other.moments == pytest.approx(one.moments, abs=1e-9)
    stance = stance_of(once)
    feet = standing_feet(stance.hip_height, stance.step_width, stance.com_offset)
    np.testing.assert_allclose(twice.joint_targets(feet), once.joint_targets(feet), atol=1e-7)
