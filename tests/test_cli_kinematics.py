"""`gaitlab ik`, `fk` and `audit` as a user meets them."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from gaitlab.cli import run_command_line
from gaitlab.cli.audit import papers
from gaitlab.model.limbs import Limbed
from gaitlab.plugins import load_class, names
from tests.test_cli import said_by

GOLDEN = json.loads((Path(__file__).parent / "data" / "flow.json").read_text())
CROUCH = ["0", "0", "-0.4", "0.8", "-0.4", "0"]


class Printed(tuple[int, str, str]):
    """Exit code, stdout and stderr of a command."""

    code = property(lambda self: self[0])
    out = property(lambda self: self[1])
    err = property(lambda self: self[2])


@pytest.fixture
def gaitlab(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]):
    """Run a command in an empty folder."""
    monkeypatch.chdir(tmp_path)

    def command(*arguments: str) -> Printed:
        code = run_command_line(arguments)
        return Printed((code, *capfd.readouterr()))

    return command


def test_flow_stands_as_in_the_reference(gaitlab) -> None:
    for case in GOLDEN["leg_ik_flat"]:
        if case["geometry"] != "default":
            continue
        limb = "left_leg" if case["sy"] == 1 else "right_leg"
        target, heading = [str(x) for x in case["P"]], str(case["heading"])
        found = gaitlab("ik", "flow", limb, "--target", *target, "--heading", heading, "--json")
        assert found.code == 0, found.err
        joints = json.loads(found.out)["joints"]
        assert list(joints)[:2] == [f"{limb[:-4]}_hip_yaw", f"{limb[:-4]}_hip_roll"]
        np.testing.assert_allclose(list(joints.values()), case["q"], atol=1e-9)


def test_settings_change_the_geometry(gaitlab) -> None:
    lengths = GOLDEN["geometry"]["unequal"]["leg"]
    names_of = {"dy": "leg.hip_spacing", "dz1": "leg.hip_drop", "l1": "leg.thigh"}
    names_of |= {"l2": "leg.shank", "dz6": "sole.height"}
    settings = [w for key, path in names_of.items() for w in ("--set", f"{path}={lengths[key]}")]
    case = next(c for c in GOLDEN["leg_ik_flat"] if c["geometry"] == "unequal" and c["sy"] == 1)
    target = [str(x) for x in case["P"]]
    heading = ["--heading", str(case["heading"])]
    found = gaitlab("ik", "flow", "left_leg", "--target", *target, *heading, *settings, "--json")
    joints = json.loads(found.out)["joints"]
    np.testing.assert_allclose(list(joints.values()), case["q"], atol=1e-9)


def test_fk_undoes_ik(gaitlab) -> None:
    target = [0.02, 0.05, -0.25]
    words = [str(x) for x in target]
    found = gaitlab("ik", "eros", "left_leg", "--target", *words, "--json")
    joints = [str(angle) for angle in json.loads(found.out)["joints"].values()]
    back = gaitlab("fk", "eros", "left_leg", "--joints", *joints, "--json")
    pose = json.loads(back.out)
    np.testing.assert_allclose(pose["position"], target, atol=1e-12)
    np.testing.assert_allclose(pose["rotation"], np.eye(3), atol=1e-12)
    assert list(pose["joints"].values()) == [float(angle) for angle in joints]


def test_all_shows_four_branches_of_flows_arm_and_counts_are_whole(gaitlab) -> None:
    target = ("--target", "0.2", "0.1", "-0.15")
    found = gaitlab("ik", "flow", "left_arm", *target, "--all", "--counts", "--json")
    shown = json.loads(found.out)
    assert len(shown["branches"]) == 4
    assert shown["branches"][0]["joints"] == shown["joints"]
    assert all(isinstance(value, int) for value in shown["counts"].values())
    np.testing.assert_allclose(
        list(shown["joints"].values()), GOLDEN["arm5_ik_position"][0]["q"], atol=1e-9
    )


def test_mx_counts_are_4096_a_turn_about_2048(gaitlab) -> None:
    found = gaitlab("ik", "eros", "left_leg", "--target", "0", "0.042", "-0.263", "--counts")
    rows = {line.split()[0]: line.split()[1:] for line in found.out.splitlines()[1:]}
    for angle, _, count in rows.values():
        assert int(count) == round(2048 + float(angle) * 4096 / (2.0 * np.pi))
    assert rows["left_hip_yaw"][2] == "2048"


def test_numbers_may_be_parted_by_commas(gaitlab) -> None:
    spaces = gaitlab("ik", "eros", "left_leg", "--target", "0.02", "0.05", "-0.25")
    commas = gaitlab("ik", "eros", "left_leg", "--target", "0.02,0.05,-0.25")
    assert spaces == commas
    assert "left_hip_yaw" in spaces.out


def test_every_robot_answers_for_every_limb_it_has(gaitlab) -> None:
    for robot in names("robot"):
        made = load_class("robot", robot)()
        if not isinstance(made, Limbed):
            continue
        for name, limb in made.limbs().items():
            inside = [str(max(j.lower, min(0.1, j.upper))) for j in limb.joints]
            found = gaitlab("fk", robot, name, "--joints", *inside, "--json")
            assert found.code == 0, found.err
            assert len(json.loads(found.out)["position"]) == 3


@pytest.mark.parametrize(
    ("words", "code", "part"),
    [
        (["ik", "eros", "left_leg", "--target", "0", "0"], 3, "found 2 numbers, expected 3"),
        (["ik", "eros", "left_leg", "--target", "0", "0", "nan"], 3, "must be finite"),
        (["ik", "eros", "left_leg", "--target", "0", "0", "x"], 3, "found '0 0 x'"),
        (["ik", "eros", "left_legg", "--target", "0", "0", "0"], 3, "did you mean 'left_leg'"),
        (["ik", "eross", "left_leg", "--target", "0", "0", "0"], 3, "did you mean 'eros'"),
        (["ik", "eros", "left_leg", "--target", "0", "0", "-1"], 3, "the leg spans [0.0000, 0.21"),
        (["ik", "eros", "left_leg", "--target", "-.09", ".042", "-.18"], 3, "its limits are -1.2"),
        (["ik", "eros", "left_leg"], 2, "--target is missing"),
        (["ik", "eros", "left_leg", "--target", "0", "0", "-.2", "--foo"], 2, "no option --foo"),
        (
            ["ik", "eros", "left_leg", "--target", "0", "0", "-.2", "--set", "leg.thig=1"],
            3,
            "thigh",
        ),
        (["ik", "eros", "left_leg", "--target", "0", "0", "-.2", "--set", "mass=0"], 3, "0.5 to"),
        (["fk", "eros", "left_leg", "--joints", "0", "0"], 3, "found 2 numbers, expected 6"),
        (["fk", "eros", "left_leg", "--joints", *CROUCH[:5], "nan"], 3, "must be finite"),
        (["fk", "eros", "left_leg", "--joints", "0", "0", "0", "-1", "0", "0"], 3, "left_knee is"),
        (["fk", "flow", "left_leg"], 2, "--joints is missing"),
        (["audit", "erso"], 3, "did you mean 'eros'"),
    ],
)
def test_a_mistake_is_answered_in_words(gaitlab, words: list[str], code: int, part: str) -> None:
    found = gaitlab(*words)
    assert (found.code, found.out) == (code, "")
    assert part in found.err
    assert "Traceback" not in found.err


@pytest.mark.long
@pytest.mark.parametrize("paper", papers())
def test_the_audit_of_a_paper_is_a_page_of_markdown(gaitlab, tmp_path: Path, paper: str) -> None:
    found = gaitlab("audit", paper, "--output", str(tmp_path / "pages"))
    assert found.code == 0, found.err
    text = Path(found.out.strip()).read_text()
    assert text.startswith("# ")
    for heading in ("## Wrong in print", "## Left out by the paper"):
        assert heading in text
    tables = [line for line in text.splitlines() if line.startswith("|")]
    assert tables
    assert not any(word in text for word in ("nan", "None", "inf "))


def test_asking_for_joints_loads_no_physics() -> None:
    script = (
        "import sys; from gaitlab.cli import run_command_line;"
        "run_command_line(['ik', 'eros', 'left_leg', '--target', '0', '0.04', '-0.25', '--json']);"
        "print([name for name in ('pybullet', 'pandas', 'duckdb') if name in sys.modules])"
    )
    assert said_by(script).splitlines()[-1] == "[]"
