"""`gaitlab verify`: every checksum, and real simulations that give the same bits again.

Real, short walks on the hard floor.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from gaitlab.cli import run_command_line
from gaitlab.running import dispatch
from gaitlab.running.verify import verify
from gaitlab.store import Store
from tests.reliability import sweeps

SHORT = (
    "horizon.cycles=0.5",
    "horizon.time=0.1",
    "gait.stand_time=0.1",
    "surfaces=[hard_floor]",
    "grid.gait.lateral_sway=[0.01]",
    "grid.gait.step_length=[0.0, 0.04]",
)


@pytest.fixture(scope="module")
def walked(tmp_path_factory: pytest.TempPathFactory) -> Store:
    """Two real trials; tests that change them work on a copy."""
    store = Store(tmp_path_factory.mktemp("walked") / "data")
    dispatch(sweeps.experiment(*SHORT), store, jobs=0)
    return store


@pytest.fixture
def copy(walked: Store, tmp_path: Path) -> Store:
    import shutil

    shutil.copytree(walked.path, tmp_path / "copy")
    return Store(tmp_path / "copy")


def test_simulations_repeat_bit_for_bit_here_and_in_a_worker(walked: Store) -> None:
    for jobs in (0, 1):
        found = verify(walked, sample=2, jobs=jobs)
        assert found.sound
        assert (found.checked, found.repeated, found.different, found.skipped) == (2, 2, (), ())


def test_the_order_of_trials_never_changes_what_they_give(walked: Store) -> None:
    for order in (sorted, lambda ids: sorted(ids, reverse=True)):
        found = verify(walked, sample=2, jobs=0, choose=lambda ids, n, order=order: order(ids)[:n])
        assert found.repeated == 2


def test_a_log_that_was_exchanged_is_found_by_simulating_again(copy: Store) -> None:
    one, other = copy.states()
    copy.commit(copy.record(one), copy.log(other))
    found = verify(copy, sample=2, jobs=0)
    assert found.unsound == ()
    assert [message[:32] for message in found.different] == [one]
    assert "other numbers this time (the same versions and platform)" in found.different[0]


def test_trials_of_another_physics_version_are_not_compared(copy: Store) -> None:
    trial_id = next(iter(copy.states()))
    record = copy.record(trial_id)
    copy.commit(replace(record, trial={**record.trial, "physics_version": 0}), copy.log(trial_id))
    found = verify(copy, sample=2, jobs=0)
    assert (found.repeated, len(found.skipped), found.sound) == (1, 1, True)


def test_a_flipped_bit_is_exit_4_and_repaired_by_doing_the_trial_again(
    copy: Store, capsys: pytest.CaptureFixture[str]
) -> None:
    before = sweeps.logs(copy)
    path = copy.file(next(iter(before)))
    content = bytearray(path.read_bytes())
    content[len(content) // 4] ^= 1  # amid the columns
    path.write_bytes(content)
    command = ["verify", "--sample", "0", "--store", str(copy.path)]
    assert run_command_line(command) == 4
    assert f"not sound: {path}: damaged" in capsys.readouterr().err
    assert run_command_line([*command, "--repair"]) == 4
    assert not path.exists()
    assert dispatch(sweeps.experiment(*SHORT), copy, jobs=0).done == 1
    assert sweeps.logs(copy) == before
    assert run_command_line(command) == 0
    assert "2 trials sound, 0 files not" in capsys.readouterr().out
