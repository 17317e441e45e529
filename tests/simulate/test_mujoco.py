"""What the MuJoCo engine knows of MuJoCo's inside, and what it refuses."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import mujoco
import numpy as np
import pytest

from gaitlab.errors import WrongValue
from gaitlab.model import Link, Tree
from gaitlab.simulation.ending import LOST
from gaitlab.simulation.mujoco import structs
from gaitlab.simulation.mujoco.model import built
from gaitlab.simulation.simulate import engine_for
from gaitlab.simulation.tape import Tape
from tests.driven import endless
from tests.ground.bench import Sled
from tests.trials import trial


@pytest.fixture(autouse=True)
def _forgotten():
    structs.layout.cache_clear()
    yield
    structs.layout.cache_clear()


def test_the_layout_of_the_installed_version_is_the_one_that_is_known() -> None:
    assert len(structs.layout().calls) == structs.BIAS + 1
    assert all(structs.layout().calls)


@pytest.mark.parametrize("version", ["3.9.0", "4.1.0", "40.0.1"])
def test_another_version_is_refused_with_the_one_that_is_needed(monkeypatch, version) -> None:
    monkeypatch.setattr(mujoco, "__version__", version)
    with pytest.raises(WrongValue, match=rf"4\.0.*{version}"):
        structs.layout()


@pytest.mark.parametrize("name", ["efc_R", "efc_aref", "efc_frictionloss", "nefc", "ncon"])
def test_a_field_that_is_elsewhere_is_noticed(monkeypatch, name) -> None:
    fields = list(structs.STRUCTS["mjData"].fields)
    at = next(k for k, field in enumerate(fields) if field.name == name)
    fields[at], fields[at + 1] = fields[at + 1], fields[at]
    moved = {**structs.STRUCTS, "mjData": SimpleNamespace(fields=fields)}
    monkeypatch.setattr(structs, "STRUCTS", moved)
    with pytest.raises(WrongValue, match="mujoco"):
        structs.layout()


@pytest.mark.parametrize("name", ["dist", "frame", "mu", "efc_address"])
def test_so_is_one_of_a_contact(monkeypatch, name) -> None:
    fields = [f for f in structs.STRUCTS["mjContact"].fields if f.name != name]
    fields.append(next(f for f in structs.STRUCTS["mjContact"].fields if f.name == name))
    fields.insert(0, SimpleNamespace(name="first", type=fields[0].type))
    moved = {**structs.STRUCTS, "mjContact": SimpleNamespace(fields=fields)}
    monkeypatch.setattr(structs, "STRUCTS", moved)
    with pytest.raises(WrongValue, match="mujoco"):
        structs.layout()


def sled(**changes: object) -> Sled:
    """A sled with another beam."""
    made = Sled()
    beam, *feet = made.tree.links
    links: tuple[Link, ...] = (replace(beam, **changes), *feet)
    object.__setattr__(made, "tree", Tree(links))
    return made


def test_an_inertia_that_no_body_has_is_refused_and_the_robot_named() -> None:
    with pytest.raises(WrongValue, match=r"sled.*inertia"):
        built(sled(inertia=(1e-3, 1e-3, 1.0)), np.zeros(2), 0.002)


def test_the_model_has_the_mass_of_the_robot_and_equal_robots_share_it() -> None:
    one, other = built(sled(mass=5.0), np.zeros(2), 0.002), built(Sled(), np.zeros(2), 0.002)
    assert float(one.model.body_mass.sum()) == pytest.approx(5.24)
    assert built(sled(mass=5.0), np.zeros(2), 0.002).model is one.model
    assert other.model is not one.model


@pytest.mark.parametrize("dt", [0.002, 0.01])
@pytest.mark.parametrize("ground", ["hard_floor", "grass_30mm"])
@pytest.mark.parametrize("force", [1e9, 1e15, 1e300, float("nan")])
def test_numbers_that_run_away_end_a_trial_as_lost(
    tmp_path, monkeypatch, ground: str, force: float, dt: float
) -> None:
    monkeypatch.chdir(tmp_path)
    walk = trial(ground, engine={"name": "mujoco", "dt": dt})
    with engine_for(walk, walk.gait.feet(np.zeros(1))) as engine:
        tape = Tape(200, 20)
        engine.pull((force, 0.0, force))
        assert engine.advance(np.zeros((200, 20)), tape, endless()) == LOST
    assert 0 < tape.length < 200
    assert list(tmp_path.iterdir()) == []  # MuJoCo leaves no log of its own
