"""Workers that end in every bad way cost their own trials and nothing else.

Trials are pretended; the crashes, the processes and the store are real.
"""

from __future__ import annotations

import hashlib
from collections import Counter
from pathlib import Path

import pytest

from gaitlab.running import dispatch
from gaitlab.running.executor import TIMED_OUT
from gaitlab.store import Store
from tests.reliability import sweeps

ONE_CELL = ("grid.gait.step_length=[0.0]", "grid.gait.lateral_sway=[0.01]")
REASONS = {
    "segfault": "signal SIGSEGV",
    "hang": TIMED_OUT,
    "exit": "exit code 3",
    "eat": "out of memory",
}


@pytest.mark.long
def test_exactly_the_trials_that_kill_their_worker_fail(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One each segfaults, hangs, exits and eats memory; one works."""
    monkeypatch.setattr("gaitlab.running.processes.simulated", sweeps.misbehave)
    monkeypatch.setattr("gaitlab.running.executor.TIMEOUT", 3.0)  # s, a worker imports, too
    monkeypatch.setattr("gaitlab.running.executor.TIMEOUT_RATIO", 0.0)
    one_cell = (*ONE_CELL, "surfaces=[hard_floor]")
    store, wanted = Store(tmp_path / "data"), sweeps.experiment(*one_cell, seeds=5)
    summary = dispatch(wanted, store, jobs=2)
    rows = sweeps.expected(*one_cell, seeds=5)
    deeds = {trial_id: sweeps.deed(int(str(row["seed"]))) for trial_id, row in rows.items()}
    assert Counter(deeds.values()) == dict.fromkeys(sweeps.DEEDS, 1)
    states = {i: "DONE" if deed == "work" else "FAILED" for i, deed in deeds.items()}
    assert store.states() == states
    assert (summary.left, summary.failed) == (0, list(states.values()).count("FAILED"))
    for trial_id, deed in deeds.items():
        if deed != "work":
            reason = store.record(trial_id).reason
            assert REASONS[deed] in reason.splitlines()[0]
            assert reason.endswith("(2 attempts)"), "retried once"


def test_the_time_out_of_a_trial_goes_by_its_own_horizon(tmp_path: Path) -> None:
    from gaitlab.experiment.plan import plan
    from gaitlab.running.executor import TIMEOUT, TIMEOUT_RATIO
    from gaitlab.running.sweep import _jobs
    from gaitlab.simulation.trial import duration

    planned = plan(sweeps.experiment("grid.horizon.time=[1.0, 30.0]", "horizon.cycles=1000"))
    trials = [item.trial for item in planned.trials()]
    times = {trial.id: duration(trial.gait, trial.horizon) for trial in trials}
    timeouts = {job.trial_id: job.timeout for job, _ in _jobs(planned, list(times), times)}
    for trial in trials:
        assert timeouts[trial.id] == TIMEOUT + TIMEOUT_RATIO * times[trial.id]
    assert max(timeouts.values()) - min(timeouts.values()) > 20.0 * TIMEOUT_RATIO


def rss() -> int:
    """Memory of this process that is in use, in [kB]."""
    text = Path("/proc/self/status").read_text()
    return int(text.partition("VmRSS:")[2].split()[0])


@pytest.mark.long
def test_the_memory_of_a_process_is_flat_over_a_thousand_commits(tmp_path: Path) -> None:
    """Pretended trials; `benchmarks/worker_memory.py` measures the same with simulations."""
    store, seen = tmp_path / "data", []
    for number in range(1000):
        trial_id = hashlib.sha256(str(number).encode()).hexdigest()[:32]
        sweeps.pretend(trial_id, {"names": {}, "seed": number}, store)
        if number % 100 == 99:
            seen.append(rss())
    assert seen[-1] - seen[1] < 20_000, seen
