"""One trial from plain data to the store, with the real simulation."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import partial
from itertools import islice
from pathlib import Path

import pytest

from gaitlab.errors import StoreError
from gaitlab.experiment import load_experiment
from gaitlab.experiment.plan import plan
from gaitlab.running.executor import Job
from gaitlab.running.processes import Processes
from gaitlab.running.run_trial import run_trial
from gaitlab.running.worker import simulated
from gaitlab.simulation.trial import Trial
from gaitlab.store import Store
from gaitlab.store.parquet import columns_sha256

EXPERIMENT = Path(__file__).parent / "data" / "pretended.yaml"


def trial(*settings: str) -> Trial:
    short = ("horizon.time=0.2", "horizon.cycles=0.5", *settings)
    experiment = load_experiment(EXPERIMENT, settings=short)
    return next(islice(plan(experiment).trials(), 2, None)).trial


@pytest.fixture
def store(tmp_path: Path) -> Store:
    return Store(tmp_path / "data")


def run(wanted: Trial, store: Store):
    store.path.mkdir(exist_ok=True)
    return run_trial(wanted.id, json.loads(json.dumps(wanted.to_dict())), store.path)


def test_a_trial_is_simulated_measured_and_committed(store: Store) -> None:
    wanted = trial()
    record = run(wanted, store)
    assert (record.state, record.reason) == ("DONE", "")
    assert store.record(wanted.id).metrics["walked_time"] == record.metrics["walked_time"] > 0.0
    assert Trial.from_dict(store.record(wanted.id).trial).id == wanted.id
    known = {"gaitlab_version", "engine", "engine_version", "host", "wall_time"}
    assert known <= set(record.provenance)
    assert record.provenance["processor"]


@pytest.mark.parametrize("written", [None, b"", b"Features: fp asimd\n", b"model name\t: \xff 9\n"])
def test_every_processor_has_a_name(tmp_path: Path, monkeypatch, written: bytes | None) -> None:
    from gaitlab.running import provenance

    file = tmp_path / "cpuinfo"
    if written is not None:
        file.write_bytes(written)
    monkeypatch.setattr(provenance, "CPUINFO", file)
    assert provenance.processor.__wrapped__()


def test_metrics_of_the_stored_log_are_those_of_the_record(store: Store) -> None:
    from gaitlab.metrics import measure
    from gaitlab.store.record import finite

    wanted = trial()
    run(wanted, store)
    again = {name: finite(value) for name, value in measure(store.log(wanted.id)).items()}
    assert again == store.record(wanted.id).metrics


def test_the_same_trial_gives_the_same_bytes_here_and_in_workers(tmp_path: Path) -> None:
    wanted, digests = trial(), set()
    for name in ("first", "second"):
        run(wanted, Store(tmp_path / name))
        digests.add(columns_sha256(Store(tmp_path / name).log(wanted.id)))
    job = Job(trial_id=wanted.id, trial=wanted.to_dict(), timeout=120.0)
    (tmp_path / "third").mkdir()
    task = partial(simulated, store=tmp_path / "third")
    list(Processes(task, 1).run([job]))
    digests.add(columns_sha256(Store(tmp_path / "third").log(wanted.id)))
    assert len(digests) == 1


def test_a_committed_trial_is_not_run_again(store: Store) -> None:
    wanted = trial()
    run(wanted, store)
    before = store.file(wanted.id).stat().st_mtime_ns
    run(wanted, store)
    assert store.file(wanted.id).stat().st_mtime_ns == before


def test_a_pose_out_of_reach_is_infeasible_with_its_reason(store: Store) -> None:
    wanted = trial("gait.step_height=0.15")
    record = run(wanted, store)
    assert record.state == "INFEASIBLE"
    assert "tick" in record.reason
    assert store.states() == {wanted.id: "INFEASIBLE"}


def test_a_gait_that_raises_is_a_failed_trial_with_its_traceback(
    store: Store, tmp_path: Path
) -> None:
    (tmp_path / "broken.py").write_text(
        "from dataclasses import dataclass\n"
        "from gaitlab.gaits.eros import Gait as Eros\n"
        "@dataclass(frozen=True, kw_only=True)\n"
        "class Gait(Eros):\n"
        "    def feet(self, t):\n"
        "        raise ZeroDivisionError('in my gait')\n"
    )
    (tmp_path / "mine.yaml").write_text("gait: ./broken.py\nrobot: eros\nsurfaces: [hard_floor]\n")
    wanted = next(plan(load_experiment(tmp_path / "mine.yaml")).trials()).trial
    record = run(wanted, store)
    assert record.state == "FAILED"
    assert record.reason.startswith("ZeroDivisionError: in my gait")
    assert "broken.py" in record.reason


def test_a_failed_trial_runs_again(store: Store) -> None:
    wanted = trial()
    record = run(wanted, store)
    store.commit(replace(record, state="FAILED", reason="lost"), None)
    assert run(wanted, store).state == "DONE"


def test_a_store_that_cannot_be_written_is_no_failed_trial(store: Store) -> None:
    store.path.mkdir()
    (store.path / "trials").write_text("in the way")
    with pytest.raises(StoreError, match="cannot be written"):
        run(trial("gait.step_height=0.15"), store)


def test_a_store_that_has_vanished_is_not_made_anew(store: Store) -> None:
    wanted = trial("gait.step_height=0.15")
    with pytest.raises(StoreError, match="has vanished"):
        run_trial(wanted.id, wanted.to_dict(), store.path)
    assert not store.path.exists()
