"""Signs of life of the processes that share a search, so that a dead one's candidates go on.

Optuna has a heartbeat of its own, but what it does with a stale trial is to fail it and to try its
values again under a new number, after a grace period. Here a candidate keeps its number and its
batch, which the samplers' seeds and a search that was killed hang on, and the next process takes
it over at once: on one machine the kernel knows who lives.
"""

from __future__ import annotations

import os
import socket
from collections.abc import Mapping
from datetime import datetime, timedelta, timezone
from pathlib import Path

INTERVAL = 20.0  # s between two signs of life
SILENCE = timedelta(seconds=300)  # without one, after which a process counts as dead
PREFIX = "coordinator "  # start of the attribute in which a process shows that it lives


def this_process() -> str:
    """Name of this process: its machine, its number and when the kernel says that it started."""
    return f"{socket.gethostname()}:{os.getpid()}:{_start_of(os.getpid())}"


def now() -> str:
    """This instant, to be kept as a sign of life."""
    return datetime.now(timezone.utc).isoformat(timespec="seconds")


def living(attributes: Mapping[str, object]) -> tuple[str, ...]:
    """Names of the processes that show signs of life, sorted.

    Of this machine's own the kernel decides; of others how long ago their last sign was, which
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
