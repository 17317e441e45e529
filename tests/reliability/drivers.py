"""Real drivers to kill: processes that run `gaitlab`, started by forking one that has imported it.

Run as a module this file is that process. It reads requests from its stdin, a line of JSON each,
and answers with the driver's process id, or with how a driver ended.
"""

from __future__ import annotations

import json
import os
import random
import select
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stdout
from io import StringIO
from pathlib import Path
from typing import IO, Any

ROOT = Path(__file__).parent.parent.parent
PATIENCE = 120.0  # s for what takes a second or two on an idle machine
EVENTS = ("open", "os.rename", "os.remove", "os.mkdir", "os.truncate", "os.scandir")


class Drivers:
    """Starts drivers, and says how they ended."""

    def __init__(self, process: subprocess.Popen[str]) -> None:
        self._process = process

    def start(
        self, *arguments: str, task: str = "slow", kill_at: int = 0, errors: Path | None = None
    ) -> int:
        """A driver with these arguments of the command line; gives its process id.

        Args:
            arguments: `run`, the experiment and so on.
            task: What its trials do.
            kill_at: The file-system step before which it kills itself; 0 for never.
            errors: File for its stderr.
        """
        given = {"arguments": arguments, "task": task, "kill_at": kill_at, "errors": str(errors)}
        return self._ask(given)

    def wait(self, pid: int) -> int:
        """How a driver ended: its exit code, or minus the signal."""
        return self._ask({"wait": pid})

    def run(self, *arguments: str, **how: Any) -> int:
        return self.wait(self.start(*arguments, **how))

    def _ask(self, request: dict[str, Any]) -> int:
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        print(json.dumps(request), file=self._process.stdin, flush=True)
        return int(line_of(self._process.stdout))


@contextmanager
def drivers() -> Iterator[Drivers]:
    """The process that forks drivers, while the block runs."""
    command = [sys.executable, "-m", "tests.reliability.drivers"]
    with subprocess.Popen(
        command, cwd=ROOT, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        try:
            assert process.stdout is not None
            assert line_of(process.stdout) == "ready\n"
            yield Drivers(process)
            process.communicate(timeout=PATIENCE)
        finally:
            process.kill()


def line_of(stream: IO[str], seconds: float = PATIENCE) -> str:
    """The next line of a process that prints one and waits.

    Raises:
        AssertionError: If the process ends or says nothing for so long.
    """
    assert select.select([stream], [], [], seconds)[0], f"no word within {seconds:.0f} s"
    line = stream.readline()
    assert line, "it ended without a word"
    return line


def until(condition: Callable[[], bool], seconds: float = 30.0, *, period: float = 0.005) -> bool:
    """Whether a condition comes true in time, looked at after every period, both in [s]."""
    end = time.monotonic() + seconds
    while not condition() and time.monotonic() < end:
        time.sleep(period)
    return condition()


def children(pid: int) -> list[int]:
    """Processes that a process has started and that still run."""
    return [int(p.name) for p in Path("/proc").iterdir() if p.name.isdigit() and _parent(p) == pid]


def runs(pid: int) -> bool:
    return _parent(Path(f"/proc/{pid}")) is not None


def _parent(process: Path) -> int | None:
    try:
        state, parent = (process / "stat").read_text().rpartition(")")[2].split()[:2]
    except (FileNotFoundError, ProcessLookupError):
        return None
    return None if state == "Z" else int(parent)


def _serve() -> None:
    import gaitlab.cli.progress
    import gaitlab.running
    import gaitlab.store.query
    import gaitlab.store.tables  # noqa: F401, imported once for all drivers
    from gaitlab.cli import run_command_line
    from tests.reliability import sweeps

    # Whatever the first command imports and remembers, no driver needs to.
    with redirect_stdout(StringIO()):
        run_command_line(["run", str(sweeps.FILE), "--dry-run", "--json", "--store", "nowhere"])
    print("ready", flush=True)
    for line in sys.stdin:
        request = json.loads(line)
        if "wait" in request:
            print(os.waitstatus_to_exitcode(os.waitpid(request["wait"], 0)[1]), flush=True)
            continue
        pid = os.fork()
        if pid == 0:
            _drive(**request)
        print(pid, flush=True)


def _drive(arguments: list[str], task: str, kill_at: int, errors: str) -> None:
    import gaitlab.running.processes
    from gaitlab.cli import run_command_line
    from tests.reliability import sweeps

    nowhere = os.open(os.devnull, os.O_RDWR)
    for descriptor in (0, 1):
        os.dup2(nowhere, descriptor)
    if errors != "None":
        os.dup2(os.open(errors, os.O_WRONLY | os.O_CREAT | os.O_TRUNC), 2)
    random.seed()
    gaitlab.running.processes.simulated = sweeps.TASKS[task]
    if kill_at:
        _kill_before_step(kill_at, arguments[arguments.index("--store") + 1])
    code = 1
    try:
        code = run_command_line(arguments)
    finally:
        sys.stderr.flush()
        os._exit(code)


def _kill_before_step(last: int, store: str) -> None:
    """SIGKILL before the n-th opening, writing, syncing, renaming and so on in the store."""
    left, sync = last, os.fsync

    def step(event: str = "open", arguments: tuple[object, ...] = (store,)) -> None:
        nonlocal left
        if event in EVENTS and str(arguments[0]).startswith(store):
            left -= 1
            if left == 0:
                os.kill(os.getpid(), signal.SIGKILL)

    def synced(descriptor: int) -> None:
        step()
        sync(descriptor)

    def called(frame: object, event: str, function: Any) -> None:
        if event == "c_call" and function.__name__ == "write":
            step("open", (getattr(function.__self__, "name", ""),))

    os.fsync = synced
    sys.addaudithook(step)
    sys.setprofile(called)


if __name__ == "__main__":
    _serve()
