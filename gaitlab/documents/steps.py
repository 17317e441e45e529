"""What a command is doing, for whoever waits for it: said where it is done, shown by the caller."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar


def _nobody(text: str) -> None:
    """Nobody listens: a program that imports gaitlab is not talked to."""


_LISTENER: ContextVar[Callable[[str], None]] = ContextVar("listener", default=_nobody)


@contextmanager
def heard(listener: Callable[[str], None]) -> Iterator[None]:
    """Whom `step` tells."""
    token = _LISTENER.set(listener)
    try:
        yield
    finally:
        _LISTENER.reset(token)


def step(text: str) -> None:
    """Say what is done from now on, in a few words: `drawing balance`."""
    _LISTENER.get()(text)
