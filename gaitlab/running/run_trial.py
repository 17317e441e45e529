"""One trial from its plain data to its place in the store."""

from __future__ import annotations

import time
import traceback
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from gaitlab.errors import Infeasible, NoEngine, StoreError
from gaitlab.log import TrialLog
from gaitlab.metrics import measure
from gaitlab.plugins import label
from gaitlab.running.provenance import provenance
from gaitlab.simulation.engines import engine_of
from gaitlab.simulation.simulate import simulate
from gaitlab.simulation.trial import Trial
from gaitlab.store import Scalar, State, Store, TrialRecord

TRACEBACK_LINES = 12  # of a failed trial's traceback, kept in its reason


def run_trial(trial_id: str, trial: Mapping[str, Any], store: Path) -> TrialRecord:
    """Simulate, measure, commit. A fall is a result, and so is whatever the gait or robot raises.

    A trial that is committed already, by a worker that died right after, is not run again.

    Args:
        trial_id: Identity of the trial.
        trial: The trial as plain data.
        store: Folder of the store.

    Returns:
        The record that was committed: `DONE`, `INFEASIBLE` or `FAILED`.

    Raises:
        NoEngine: If its engine is not installed here.
        StoreError: If it could not be committed, or the store has vanished; the trial is not to
            blame.
        MemoryError: If there is not enough memory; the worker is to end, and the trial is run
            once more.
    """
    committed = Store(store).committed(trial_id)
    if committed is not None:
        return committed
    record, log = simulate_trial(trial_id, trial)
    if not store.is_dir():  # a commit would make it anew, perhaps on another disk
        raise StoreError(
            f"{store}: the folder of the results has vanished while it was in use; bring it back "
            "or choose another one with --store DIR. The same command goes on from there."
        )
    Store(store).commit(record, log)
    return record


def simulate_trial(trial_id: str, trial: Mapping[str, Any]) -> tuple[TrialRecord, TrialLog | None]:
    """Simulate and measure; nothing is written.

    Returns:
        What is to be committed; the log is None unless the trial is `DONE`.

    Raises:
        NoEngine: If its engine is not installed here.
        MemoryError: If there is not enough memory.
    """
    start, used = time.perf_counter(), time.process_time()
    outcome = _outcome(trial)
    used = time.process_time() - used
    record = TrialRecord(
        trial_id=trial_id,
        state=outcome.state,
        reason=outcome.reason,
        trial=trial,
        metrics=outcome.metrics,
        provenance=provenance(time.perf_counter() - start, engine_of(trial), used),
    )
    return record, outcome.log


class _Outcome(NamedTuple):
    state: State
    reason: str = ""
    metrics: Mapping[str, Scalar] = {}
    log: TrialLog | None = None


def _outcome(trial: Mapping[str, Any]) -> _Outcome:
    try:
        made = Trial.from_dict(dict(trial))
        outcome = _walked(made)
        made.require_complete()
        return outcome
    except (MemoryError, NoEngine):
        raise
    except (Exception, SystemExit) as error:  # a user's own code may call sys.exit
        return _Outcome("FAILED", _reason(error))


def _walked(trial: Trial) -> _Outcome:
    try:
        log = simulate(trial)
        own = [label(code.name) for code in trial.metric_codes]
        return _Outcome("DONE", metrics=measure(log, own), log=log)
    except Infeasible as error:
        return _Outcome("INFEASIBLE", str(error))


def _reason(error: BaseException) -> str:
    lines = "".join(traceback.format_exception(error)).splitlines()
    return "\n".join([f"{type(error).__name__}: {error}", *lines[-TRACEBACK_LINES:]])
