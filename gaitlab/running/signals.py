"""Signals that end or outlive a run: Ctrl-C, SIGTERM, and a terminal that goes away."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType


@contextmanager
def stoppable(stop: Callable[[int], None]) -> Iterator[None]:
    """Ctrl-C and SIGTERM call `stop` while the block runs; SIGHUP silences the terminal.

    Only the main thread can have signals; elsewhere the block runs as it is.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    terminals = [descriptor for descriptor in (0, 1, 2) if os.isatty(descriptor)]

    def on_stop(number: int, frame: FrameType | None) -> None:
        stop(number)

    def on_hangup(number: int, frame: FrameType | None) -> None:
        _silence(terminals)

    handlers = {signal.SIGINT: on_stop, signal.SIGTERM: on_stop, signal.SIGHUP: on_hangup}
    before = {number: signal.signal(number, handler) for number, handler in handlers.items()}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _silence(terminals: list[int]) -> None:
    """What would be written to a terminal that has gone is dropped; files go on as before."""
    nowhere = os.open(os.devnull, os.O_RDWR)
    for descriptor in terminals:
        os.dup2(nowhere, descriptor)
    os.close(nowhere)
