"""Everything a user can fix, as exceptions that carry their exit code.

A message says what was wrong, what was found, what is allowed and what to do. Only `cli` turns
these into text on the terminal and an exit code, only `run` turns them into trial states.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

MOST_SHOWN = 10  # mistakes of a file, which fill a screen
LONGEST_MESSAGE = 1500  # characters of one mistake


class GaitlabError(Exception):
    """Root of all errors that gaitlab raises on purpose."""

    exit_code = 1


@dataclass(frozen=True, kw_only=True)
class Problem:
    """One mistake in a user's file: where it stands and what to do about it.

    Attributes:
        file: File the mistake stands in.
        line: Line, counted from 1; None when the file as a whole is meant.
        column: Column, counted from 1; None with `line`.
        message: What was found, what is allowed, what to do.
    """

    file: Path
    line: int | None
    column: int | None
    message: str

    def __str__(self) -> str:
        place = "".join(f":{n}" for n in (self.line, self.column) if n is not None)
        message = self.message
        if len(message) > LONGEST_MESSAGE:
            message = f"{message[: LONGEST_MESSAGE // 2]} ... {message[-LONGEST_MESSAGE // 2 :]}"
        return f"{self.file}{place}: {message}"


class FileError(GaitlabError):
    """An experiment, surface, servo, robot or gait file is wrong; nothing was run.

    Attributes:
        problems: Every mistake that was found, in the order of the file.
    """

    exit_code = 3

    def __init__(self, problems: list[Problem]) -> None:
        more = len(problems) - MOST_SHOWN
        rest = [f"and {more} more; mend these first"] if more > 0 else []
        super().__init__("\n".join([*map(str, problems[:MOST_SHOWN]), *rest]))
        self.problems = problems


class UnknownName(GaitlabError):
    """A name was asked for that no file answers to."""

    exit_code = 3


class WrongValue(GaitlabError):
    """A value that a file or an option gave lies outside what is allowed."""

    exit_code = 3


class NoEngine(WrongValue):
    """A physics engine was asked for that is not installed, or of another version than is known.

    No trial is to blame: it stays undone.
    """


class UsageError(GaitlabError):
    """A command was called in a way that cannot be carried out."""

    exit_code = 2


class NothingRun(UsageError):
    """A report was asked for before any of its trials was run."""


class Undecided(GaitlabError):
    """The nightly gate cannot tell: no baseline, nothing in common with it, or too few seeds."""

    exit_code = 6


class WorseBaseline(GaitlabError):
    """A baseline would be replaced by one that walks significantly worse."""

    exit_code = 5


class StoreError(GaitlabError):
    """The store is locked by another run, unwritable, full, damaged or from a newer version."""

    exit_code = 7


class Infeasible(GaitlabError):
    """The robot cannot take a commanded pose; found before anything is simulated.

    Attributes:
        limb: Limb that cannot, for instance `left_leg`.
        tick: Index of the first such target along the time axis.
        reason: Why, with the number found and the number allowed.
    """

    exit_code = 3

    def __init__(self, *, limb: str, tick: int, reason: str) -> None:
        super().__init__(f"{limb} at tick {tick}: {reason}")
        self.limb, self.tick, self.reason = limb, tick, reason

    def __reduce__(self) -> tuple[object, ...]:
        return _infeasible, (self.limb, self.tick, self.reason)


def _infeasible(limb: str, tick: int, reason: str) -> Infeasible:
    return Infeasible(limb=limb, tick=tick, reason=reason)
