"""Schedulers and workers of Dask as processes of their own, to be killed."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from gaitlab.store import TrialRecord
from gaitlab.store.parquet import encode
from tests import recorded
from tests.reliability import sweeps
from tests.reliability.drivers import ROOT, children, until

START_TIME = 60.0  # s; a busy machine is no failure
QUIET = {"DASK_DISTRIBUTED__WORKER__MEMORY__TERMINATE": "False"}
TRIED_AGAIN = "DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES"  # how often a trial is


@contextmanager
def _process(
    words: list[str], log: Path, path: str, more: Mapping[str, str], before: Sequence[str] = ()
) -> Iterator[subprocess.Popen[bytes]]:
    environment = {**os.environ, "PYTHONPATH": path, **QUIET, **more}
    cwd = path.partition(":")[0]  # Python's first folder
    with log.open("ab") as file:
        process = subprocess.Popen(
            [*before, sys.executable, "-m", *words],
            env=environment,
            cwd=cwd,
            stdout=file,
            stderr=file,
        )
    try:
        yield process
    finally:
        started = children(process.pid)
        process.terminate()
        try:
            process.wait(10.0)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait(10.0)
        for pid in started:
            _kill(pid)


def _kill(pid: int) -> None:
    try:
        os.kill(pid, 9)
    except ProcessLookupError:
        return


@contextmanager
def scheduler(
    folder: Path, *, port: int = 0, tried_again: int = 0
) -> Iterator[tuple[subprocess.Popen[bytes], str]]:
    """A scheduler of Dask, which no gaitlab is beside, and its address."""
    file = folder / "scheduler.json"
    file.unlink(missing_ok=True)
    words = ["distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", str(port)]
    words += ["--no-dashboard", "--scheduler-file", str(file)]
    bare = folder / "bare"
    bare.mkdir(exist_ok=True)
    (bare / "gaitlab.py").write_text("raise ImportError('a scheduler needs no gaitlab')")
    more = {TRIED_AGAIN: str(tried_again)}
    with _process(words, folder / "scheduler.log", str(bare), more) as process:
        assert until(lambda: file.exists() and file.read_text().endswith("}"), START_TIME)
        yield process, str(json.loads(file.read_text())["address"])


@contextmanager
def workers(
    address: str,
    folder: Path,
    count: int = 1,
    path: str = str(ROOT),
    *,
    threads: int = 1,
    before: Sequence[str] = (),
) -> Iterator[subprocess.Popen[bytes]]:
    """Worker processes, and the process that looks after them and starts lost ones again."""
    words = ["distributed.cli.dask_worker", address, "--nthreads", str(threads)]
    words += ["--nworkers", str(count), "--no-dashboard", "--local-directory", str(folder)]
    with _process(words, folder / "workers.log", path, {}, before) as process:
        yield process


def worker_pids(nanny: int) -> list[int]:
    """The worker processes themselves."""
    return [pid for pid in children(nanny) if b"spawn_main" in _command(pid)]


def _command(pid: int) -> bytes:
    try:
        return Path(f"/proc/{pid}/cmdline").read_bytes()
    except (FileNotFoundError, ProcessLookupError):
        return b""


def pretend_encoded(trial_id: str, trial: Mapping[str, Any]) -> tuple[TrialRecord, bytes]:
    """As `sweeps.pretend`, for who commits it."""
    record = sweeps.given(trial_id, trial)
    return record, encode(record, recorded.log(40, seed=int(trial_id[:6], 16)))
