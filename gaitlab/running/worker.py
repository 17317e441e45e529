"""The inside of a worker process: quiet, single-threaded, and never alive without its driver."""

from __future__ import annotations

import ctypes
import faulthandler
import os
import resource
import signal
import sys
import threading
import time
import traceback
from collections.abc import Callable, Mapping
from contextlib import suppress
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, Protocol, TypeVar

from gaitlab.errors import GaitlabError
from gaitlab.store import TrialRecord

R = TypeVar("R")
READY = "ready"  # first message of a worker: it has imported what its task needs
OUT_OF_MEMORY = 12  # exit code, ENOMEM
_PR_SET_PDEATHSIG = 1  # linux/prctl.h
_FIRST_VICTIM = "1000"  # highest score of the kernel's choice what to kill when memory runs out
_WATCH_PERIOD = 1.0  # s between looks at the driver where the kernel does not watch it


class Task(Protocol):
    """What a worker does with a trial."""

    def __call__(self, trial_id: str, trial: Mapping[str, Any]) -> TrialRecord:
        """Run and commit one trial."""


def simulated(trial_id: str, trial: Mapping[str, Any], store: Path) -> TrialRecord:
    """`run_trial`, loaded on the first call: the driver names it and never loads the engine."""
    from gaitlab.running.run_trial import run_trial

    return run_trial(trial_id, trial, store)


def encoded(trial_id: str, trial: Mapping[str, Any]) -> tuple[TrialRecord, bytes]:
    """A trial that is not committed here: its record, and its file for who commits it."""
    from gaitlab.running.run_trial import simulate_trial
    from gaitlab.store.parquet import encode

    record, log = simulate_trial(trial_id, trial)
    return record, encode(record, log)


def serve(pipe: Connection, task: Task, driver: int, output: Path, memory: int | None) -> None:
    """Run the trials that come through the pipe until it closes.

    Args:
        pipe: Receives (trial id, trial), sends `READY` and then the record or the exception of
            the task, trial by trial.
        task: What to do with a trial.
        driver: Process that started this one; this one ends when that one does.
        output: File that gets whatever the worker prints, its last words among it.
        memory: What it may allocate, in [byte]; None for as much as there is.
    """
    _die_with(driver)
    write_to(output)
    limit_memory(memory)
    pipe.send(READY)
    while True:
        try:
            trial_id, trial = pipe.recv()
        except (EOFError, OSError):
            return
        pipe.send(answer(task, trial_id, trial))


def answer(
    task: Callable[[str, Mapping[str, Any]], R], trial_id: str, trial: Mapping[str, Any]
) -> R | Exception:
    """What a task makes of a trial, or what it raised; lack of memory ends the process."""
    try:
        return task(trial_id, trial)
    except GaitlabError as error:
        return error
    except MemoryError:
        traceback.print_exc(file=sys.stderr)
        sys.stderr.flush()
        os._exit(OUT_OF_MEMORY)
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


def limit_memory(memory: int | None) -> None:
    """A trial that eats memory loses its worker, not the machine and not the driver."""
    with suppress(OSError):
        Path("/proc/self/oom_score_adj").write_text(_FIRST_VICTIM)
    if memory is not None and sys.platform == "linux":
        resource.setrlimit(resource.RLIMIT_DATA, (memory, memory))


def write_to(output: Path) -> None:
    """Physics engines print to stdout, which belongs to the user's table."""
    file = output.open("wb", buffering=0)
    os.dup2(file.fileno(), 1)
    os.dup2(file.fileno(), 2)
    faulthandler.enable(file=2)
