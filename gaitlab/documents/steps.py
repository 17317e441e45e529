"""What a command is doing, for whoever waits for it: said where it is done, shown by the caller."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TypeAlias

# Is told the step that begins, how many ended before it, and how many there are as far as is known.
Listener: TypeAlias = Callable[[str, int, int], None]


class _Heard:
    """How far the steps are that a listener hears of."""

    def __init__(self, listener: Listener) -> None:
        self._listener, self._text = listener, ""
        self._begun = self._expected = 0

    def expect(self, count: int) -> None:
        self._expected += count

    def begin(self, text: str) -> None:
        if text == self._text:  # said by what draws it and by what saves it
            return
        self._text, self._begun = text, self._begun + 1
        self._expected = max(self._expected, self._begun)
        self._listener(text, self._begun - 1, self._expected)


_HEARD: ContextVar[_Heard | None] = ContextVar("heard", default=None)


@contextmanager
def heard(listener: Listener) -> Iterator[None]:
    """Whom `step` tells; without a listener it tells nobody."""
    token = _HEARD.set(_Heard(listener))
    try:
        yield
    finally:
        _HEARD.reset(token)


def expect(count: int) -> None:
    """Say that so many further steps will come."""
    if (current := _HEARD.get()) is not None:
        current.expect(count)


def step(text: str) -> None:
    """Say what is done from now on, in a few words: `drawing balance`."""
    if (current := _HEARD.get()) is not None:
        current.begin(text)
