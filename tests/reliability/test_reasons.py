"""Why a trial would run again, in the words of `--dry-run`.

Trials are pretended; experiments, plans and the store are real.
"""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from gaitlab.cli import run_command_line
from gaitlab.running import outlook
from gaitlab.store import Store
from tests import written
from tests.reliability import sweeps

SHIPPED = Path(__file__).parent.parent.parent / "surfaces"
CELLS = 8


@pytest.fixture
def store(tmp_path: Path) -> Store:
    return Store(tmp_path / "data")


def due(store: Store, *settings: str, seeds: int = 1, retry_failed: bool = True) -> dict[str, int]:
    wanted = sweeps.experiment(*sweeps.SMALL, *settings, seeds=seeds)
    return outlook(wanted, store).due(retry_failed)


def test_what_was_never_asked_for_is_new_and_what_is_there_is_not_run(store: Store) -> None:
    assert due(store) == {"new": CELLS}
    sweeps.run(store, *sweeps.SMALL)
    assert due(store) == {}
    assert due(store, seeds=3) == {"new": 2 * CELLS}


def test_changing_one_value_of_a_grid_runs_only_its_cells(store: Store) -> None:
    sweeps.run(store, *sweeps.SMALL)
    other = "grid.gait.lateral_sway=[0.01, 0.03]"
    assert due(store, other) == {"new": CELLS // 2}
    assert sweeps.run(store, *sweeps.SMALL, other).done == CELLS // 2
    assert due(store) == {}, "the first grid is still there"


@pytest.fixture
def lawns(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working directory with surface files of its own, which win over the shipped ones."""
    monkeypatch.chdir(tmp_path)
    return Path(shutil.copytree(SHIPPED, tmp_path / "surfaces"))


def test_an_edited_surface_is_named_for_its_own_cells_and_a_comment_is_nothing(
    store: Store, lawns: Path
) -> None:
    sweeps.run(store, *sweeps.SMALL)
    lawn = lawns / "grass_50mm.yaml"
    lawn.write_text(f"{lawn.read_text()}# mown on Friday\n")
    assert due(store) == {}
    lawn.write_text(lawn.read_text().replace("value: 0.050", "value: 0.048"))
    assert due(store) == {"surface changed": CELLS // 2}
    sweeps.run(store, *sweeps.SMALL)
    assert due(store) == {}


def test_the_reason_outlives_an_interrupted_run(store: Store, lawns: Path) -> None:
    """The list that is replaced when a run starts is kept, so the rest still has its reason."""
    sweeps.run(store, *sweeps.SMALL)
    lawn = lawns / "grass_50mm.yaml"
    lawn.write_text(lawn.read_text().replace("value: 0.050", "value: 0.048"))
    sweeps.run(store, *sweeps.SMALL)
    fresh = sweeps.expected(*sweeps.SMALL)
    for trial_id in [i for i, row in fresh.items() if row["surface"] == "grass_50mm"][:2]:
        store.file(trial_id).unlink()
    assert due(store) == {"surface changed": 2}


def test_a_new_physics_version_is_named(store: Store, monkeypatch: pytest.MonkeyPatch) -> None:
    sweeps.run(store, *sweeps.SMALL)
    monkeypatch.setattr("gaitlab.simulation.trial.PHYSICS_VERSION", 1000)
    assert due(store) == {"physics version changed": CELLS}


@pytest.mark.parametrize(
    ("setting", "reason"),
    [
        ("gait.step_height=0.02", "gait changed"),
        ("engine.dt=0.001", "engine changed"),
        ("horizon.cycles=3", "horizon changed"),
        ("spread.tilt=0.0", "spread changed"),
        ("servo.position_gain=9.0", "servo changed"),
        ("robot.sole.kind=studs", "robot changed"),
        ("surface.friction=0.31", "surface changed"),
    ],
)
def test_every_part_that_changes_is_named(store: Store, setting: str, reason: str) -> None:
    only_grass = "surfaces=[grass_50mm]"
    sweeps.run(store, *sweeps.SMALL, only_grass)
    assert due(store, only_grass, setting) == {reason: CELLS // 2}


def test_several_parts_that_change_are_all_named(store: Store) -> None:
    sweeps.run(store, *sweeps.SMALL)
    assert due(store, "gait.step_height=0.02", "spread.tilt=0.0") == {
        "gait and spread changed": CELLS
    }


def test_failed_and_damaged_trials_are_told_apart(store: Store) -> None:
    sweeps.run(store, *sweeps.SMALL)
    one, other, *_ = store.states()
    failed = store.record(one)
    store.commit(type(failed)(**{**vars(failed), "state": "FAILED", "reason": "lost"}), None)
    store.file(other).write_bytes(b"torn")
    assert due(store) == {"failed before": 1, "file damaged": 1}
    assert due(store, retry_failed=False) == {"file damaged": 1}


def test_a_dry_run_prints_the_reasons_and_touches_nothing(
    store: Store, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys
) -> None:
    monkeypatch.setattr("gaitlab.running.processes.simulated", sweeps.pretend)
    grid = "grid: {gait.step_length: [0.0, 0.04], gait.lateral_sway: [0.01, 0.02]}"
    file = tmp_path / "pretended.yaml"
    file.write_text(f"include: {sweeps.FILE}\n{grid}\nseeds: 1\n")
    command = ["run", str(file), "--store", str(store.path)]
    assert run_command_line([*command, "-j", "0", "-q"]) == 0
    before = sweeps.content(store)
    file.write_text(file.read_text() + "horizon: {cycles: 3}\n")
    capsys.readouterr()
    assert run_command_line([*command, "-n"]) == 0
    assert capsys.readouterr().out.count("horizon changed") == CELLS
    assert run_command_line([*command, "-n", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["to_run"]["horizon_changed"] == CELLS
    assert sweeps.content(store) == before


def test_a_dry_run_says_whose_code_the_experiment_runs(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = written.write(tmp_path)
    assert run_command_line(["run", str(path), "-n"]) == 0
    told = capsys.readouterr()
    own = tmp_path / "my_gait.py"
    assert f"this experiment runs code of your own: {own}" in told.out + told.err


def test_a_python_file_beside_an_experiment_that_does_not_name_it_is_never_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("eros.py", "gait.py", "robot.py", "conftest.py", "grass_50mm.py"):
        (tmp_path / name).write_text("open('pwned', 'w')\n")
    (tmp_path / "walk.yaml").write_text(sweeps.FILE.read_text())
    assert run_command_line(["run", "./walk.yaml", "-n", "--json"]) == 0
    assert not (tmp_path / "pwned").exists()
