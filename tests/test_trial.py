"""A trial is its numbers: they travel whole, and only they make its identity."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitlab.errors import UnknownName, WrongValue
from gaitlab.parameters import (
    Parameter,
    canonical,
    canonical_json,
    get_path,
    instance,
    parameter_table,
    set_path,
    values,
)
from gaitlab.plugins import load_class
from gaitlab.servos.files import load_servo
from gaitlab.simulation import trial as trial_module
from gaitlab.simulation.trial import Names, Trial, plugin
from gaitlab.surfaces.files import load_surface
from tests.trials import trial as shipped_trial
from tests.written import GAIT

NAMES = Names(robot="eros", gait="my_gait", surface="grass_50mm")


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("team")
    (folder / "my_gait.py").write_text(GAIT)
    return folder


@pytest.fixture(scope="module")
def trial(folder: Path) -> Trial:
    return made(folder)


def made(folder: Path, surface: str = "grass_50mm") -> Trial:
    robot = load_class("robot", "eros")()
    servos = {joint.servo: load_servo(joint.servo) for joint in robot.tree.joints}
    return Trial(
        robot=robot,
        gait=load_class("gait", "./my_gait.py", folder)(step_length=0.04),
        surface=load_surface(surface),
        servos=tuple(servos[joint.servo] for joint in robot.tree.joints),
        seed=3,
        names=NAMES,
        robot_code=plugin("robot", "eros"),
        gait_code=plugin("gait", "./my_gait.py", folder),
    )


def spelt_out(trial: Trial) -> str:
    """The identity from one canonical text of the whole trial, nothing remembered."""
    data = trial.to_dict()
    parts = {
        "code": {"gait": trial.gait_code.identity, "robot": trial.robot_code.identity},
        **{name: data[name]["values"] for name in ("gait", "robot", "surface")},
        **{name: data[name] for name in ("engine", "horizon", "seed", "servos", "spread")},
        "physics_version": data["physics_version"],
        "surface_type": data["surface"]["type"],
    }
    return hashlib.sha256(canonical_json(parts).encode()).hexdigest()[:32]


@pytest.mark.parametrize("surface", ["grass_50mm", "carpet_4mm", "hard_floor", "webots_grass"])
def test_the_id_is_the_hash_of_the_whole_trial(folder: Path, surface: str) -> None:
    trial = made(folder, surface)
    for seed in (3, 0, 10**6):
        one = dataclasses.replace(trial, seed=seed)
        assert one.id == spelt_out(one)
    steeper = dataclasses.replace(trial, horizon=dataclasses.replace(trial.horizon, cycles=2.0))
    assert steeper.id == spelt_out(steeper)


def test_ids_of_published_results_stay_as_they_are() -> None:
    """Else every stored trial would be simulated again; see PHYSICS_VERSION."""
    assert (
        shipped_trial(cycles=9.0, seed=7, step_length=0.04).id == "63e8cbe1deb2f31eea5093d53609ab6f"
    )


@pytest.mark.parametrize("surface", ["grass_50mm", "carpet_4mm", "hard_floor", "webots_grass"])
def test_a_trial_survives_json(folder: Path, surface: str) -> None:
    before = made(folder, surface)
    after = Trial.from_dict(json.loads(json.dumps(before.to_dict())))
    assert after == before
    assert after.id == before.id


def test_another_process_rebuilds_the_same_trial(trial: Trial) -> None:
    program = (
        "import json, sys\nfrom gaitlab.simulation.trial import Trial\n"
        "print(Trial.from_dict(json.load(sys.stdin)).id)"
    )
    done = subprocess.run(
        [sys.executable, "-c", program],
        input=json.dumps(trial.to_dict()),
        capture_output=True,
        text=True,
        check=True,
        timeout=60,
    )
    assert done.stdout.strip() == trial.id


def other_value(item: Parameter, value: object) -> object:
    """A value that differs; ranges do not matter to an identity."""
    if isinstance(value, bool):
        return not value
    if isinstance(value, int | float):
        return value + (1 if item.type is int else 1e-3)
    return f"not {value}"


def variants(owner: object) -> list[tuple[str, object]]:
    """The owner with one parameter after the other changed."""
    return [
        (path, set_path(owner, path, other_value(item, get_path(owner, path))))
        for path, item in parameter_table(type(owner)).items()
    ]


def test_the_id_changes_with_every_parameter_of_every_part(trial: Trial) -> None:
    ids = {"base": trial.id, "seed": dataclasses.replace(trial, seed=4).id}
    for part in ("gait", "robot", "surface", "engine", "horizon", "spread"):
        for path, value in variants(getattr(trial, part)):
            ids[f"{part}.{path}"] = dataclasses.replace(trial, **{part: value}).id
    for path, servo in variants(trial.servos[0]):
        for joint in (0, 7):
            servos = (*trial.servos[:joint], servo, *trial.servos[joint + 1 :])
            ids[f"servos.{joint}.{path}"] = dataclasses.replace(trial, servos=servos).id
    assert {"gait.step_height", "robot.sole.kind", "surface.toe_catch"} <= set(ids)
    assert len(set(ids.values())) == len(ids)


def test_the_id_ignores_names_and_the_place_of_a_users_file(trial: Trial, folder, tmp_path) -> None:
    renamed = dataclasses.replace(trial, names=Names(robot="a", gait="b", surface="c"))
    assert renamed.id == trial.id
    moved = made(Path((tmp_path / "my_gait.py").write_text(GAIT) and tmp_path))
    assert moved.gait_code.name != trial.gait_code.name
    assert moved.id == trial.id


def test_the_id_follows_the_text_of_a_users_gait(trial: Trial, tmp_path: Path) -> None:
    (tmp_path / "my_gait.py").write_text(GAIT.replace("gait_period = 1.0", "gait_period = 1.5"))
    assert made(tmp_path).id != trial.id


def test_the_id_follows_the_declared_version_of_the_physics(trial, monkeypatch) -> None:
    fresh, before = dataclasses.replace(trial), trial.id
    monkeypatch.setattr(trial_module, "PHYSICS_VERSION", trial_module.PHYSICS_VERSION + 1)
    assert fresh.id != before


def test_equal_numbers_of_another_kind_of_ground_make_another_trial(trial: Trial) -> None:
    soft, hard = load_surface("webots_grass"), load_surface("hard_floor")
    ids = {dataclasses.replace(trial, surface=surface).id for surface in (soft, hard)}
    assert len(ids | {trial.id}) == 3


def test_whole_numbers_and_signed_zeros_make_the_same_trial(trial: Trial) -> None:
    length = [set_path(trial.gait, "step_length", value) for value in (0, 0.0, -0.0)]
    height = [set_path(trial.robot, "mass", value) for value in (3, 3.0)]
    assert len({dataclasses.replace(trial, gait=gait).id for gait in length}) == 1
    assert len({dataclasses.replace(trial, robot=robot).id for robot in height}) == 1


def test_the_id_ignores_the_order_of_keys(trial: Trial) -> None:
    data = trial.to_dict()
    turned = {key: data[key] for key in reversed(data)}
    turned["gait"] = {key: data["gait"][key] for key in reversed(data["gait"])}
    turned["gait"]["values"] = dict(reversed(data["gait"]["values"].items()))
    assert Trial.from_dict(turned).id == trial.id


def test_an_id_is_32_hex_digits(trial: Trial) -> None:
    assert len(trial.id) == 32
    assert int(trial.id, 16) > 0


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -float("inf")])
def test_no_trial_is_made_of_numbers_that_are_none(trial: Trial, value: float) -> None:
    broken = dataclasses.replace(trial, gait=set_path(trial.gait, "step_length", value))
    with pytest.raises(WrongValue, match="step_length"):
        _ = broken.id


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_canonical_numbers_survive_json_and_are_idempotent(value: float) -> None:
    item = Parameter(
        name="x", type=float, default=0.0, unit="m", low=None, high=None, doc="", source=""
    )
    once = canonical(item, value)
    assert json.loads(json.dumps(once)) == once == value == canonical(item, once)


def test_values_and_instance_are_inverse(trial: Trial) -> None:
    for part in (trial.robot, trial.gait, trial.surface, trial.servos[0], trial.spread):
        assert instance(type(part), values(part)) == part


def test_a_parameter_of_another_version_is_named(trial: Trial) -> None:
    with pytest.raises(WrongValue, match="'wings'"):
        instance(type(trial.engine), {**values(trial.engine), "wings": 2})


def test_a_gait_that_changed_or_went_since_planning_is_refused(tmp_path: Path) -> None:
    own = tmp_path / "my_gait.py"
    own.write_text(GAIT)
    data = made(tmp_path).to_dict()
    own.write_text(GAIT + "\n")
    with pytest.raises(WrongValue, match="has changed since the trial was planned"):
        Trial.from_dict(data)
    own.unlink()
    with pytest.raises(UnknownName, match="there is no file"):
        Trial.from_dict(data)
