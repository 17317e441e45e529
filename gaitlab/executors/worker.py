"""The inside of a worker process: quiet, single-threaded, and never alive without its driver."""

from __future__ import annotations

import ctypes
import faulthandler
import os
import signal
import sys
import threading
import time
import traceback
from collections.abc import Mapping
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, Protocol

from gaitlab.errors import GaitlabError
from gaitlab.store import TrialRecord

_PR_SET_PDEATHSIG = 1  # linux/prctl.h
_WATCH_PERIOD = 1.0  # s between looks at the driver where the kernel does not watch it


class Task(Protocol):
    """What a worker does with a trial."""

    def __call__(self, trial_id: str, trial: Mapping[str, Any]) -> TrialRecord:
        """Run and commit one trial."""


def simulated(trial_id: str, trial: Mapping[str, Any], store: Path) -> TrialRecord:
    """`run_trial`, loaded on the first call: the driver names it and never loads the engine."""
    from gaitlab.run import run_trial

    return run_trial(trial_id, trial, store)


def serve(pipe: Connection, task: Task, driver: int, output: Path) -> None:
    """Run the trials that come through the pipe until it closes.

    Args:
        pipe: Receives (trial id, trial), sends the record or the exception of the task.
        task: What to do with a trial.
        driver: Process that started this one; this one ends when that one does.
        output: File that gets whatever the worker prints, its last words among it.
    """
    _die_with(driver)
    _write_to(output)
    while True:
        try:
            trial_id, trial = pipe.recv()
        except (EOFError, OSError):
            return
        pipe.send(_answer(task, trial_id, trial))


def _answer(task: Task, trial_id: str, trial: Mapping[str, Any]) -> TrialRecord | Exception:
    try:
        return task(trial_id, trial)
    except GaitlabError as error:
        return error
    except Exception:
        return RuntimeError(f"in a worker:\n{traceback.format_exc()}")


def _die_with(driver: int) -> None:
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    else:
        threading.Thread(target=_watch, args=(driver,), daemon=True).start()
    if os.getppid() != driver:  # it died before the kernel was asked
        os._exit(1)


def _watch(driver: int) -> None:
    while os.getppid() == driver:
        time.sleep(_WATCH_PERIOD)
    os._exit(1)


def _write_to(output: Path) -> None:
    """Physics engines print to stdout, which belongs to the user's table."""
    file = output.open("wb", buffering=0)
    os.dup2(file.fileno(), 1)
    os.dup2(file.fileno(), 2)
    faulthandler.enable(file=2)
