"""Who else works on a search, so that a dead coordinator's candidates are taken over."""

from __future__ import annotations

import os
import socket
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime, timedelta, timezone
from pathlib import Path

BEAT = 20.0  # s between two signs of life
SILENCE = timedelta(seconds=300)  # without one, after which a coordinator counts as dead
PREFIX = "coordinator "  # start of the attribute in which a coordinator shows that it lives


@dataclass(frozen=True, kw_only=True)
class Coordinator:
    """A process that asks and tells.

    Attributes:
        host: Its machine.
        pid: Its process there.
        start: When that process started, as the machine's kernel counts it.
    """

    host: str
    pid: int
    start: str

    @property
    def name(self) -> str:
        """What tells it apart from every other one."""
        return f"{self.host}:{self.pid}:{self.start}"


def this_one() -> Coordinator:
    """The coordinator that this process is."""
    return Coordinator(host=socket.gethostname(), pid=os.getpid(), start=_start_of(os.getpid()))


def now() -> str:
    """This instant, to be kept as a sign of life."""
    return datetime.now(timezone.utc).isoformat(timespec="seconds")


def living(attributes: Mapping[str, object]) -> tuple[str, ...]:
    """Names of the coordinators that show signs of life, sorted.

    Of this machine's own the process decides; of others how long ago their last sign was, which
    takes clocks that agree to some minutes.
    """
    signs = {
        name.removeprefix(PREFIX): str(sign)
        for name, sign in attributes.items()
        if name.startswith(PREFIX) and sign
    }
    return tuple(sorted(name for name, sign in signs.items() if _lives(name, sign)))


def _lives(name: str, sign: str) -> bool:
    host, pid, start = name.rsplit(":", 2)
    if host == socket.gethostname():
        return _start_of(int(pid)) == start
    return datetime.now(timezone.utc) - datetime.fromisoformat(sign) < SILENCE


def _start_of(pid: int) -> str:
    """Start of a process in clock ticks since the machine started; empty if there is none."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[19]
    except (OSError, IndexError):
        return _without_proc(pid)


def _without_proc(pid: int) -> str:
    if Path("/proc/self").exists():
        return ""
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return ""
    except OSError:
        return "unknown"
    return "unknown"
