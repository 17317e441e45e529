"""What goes into an executor and what comes out."""

from __future__ import annotations

from collections.abc import Generator, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from gaitlab.store import TrialRecord


@dataclass(frozen=True, kw_only=True)
class Job:
    """One trial to run.

    Attributes:
        trial_id: Identity of the trial.
        trial: The trial as plain data.
        timeout: Longest time it may take, in [s]; only worker processes can keep to it.
    """

    trial_id: str
    trial: Mapping[str, Any]
    timeout: float


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What became of a job.

    Attributes:
        job: The job.
        record: What the trial committed; None if its worker was lost.
        reason: How the worker was lost; empty if it was not.
        seconds: How long the lost trial took, in [s].
    """

    job: Job
    record: TrialRecord | None
    reason: str = ""
    seconds: float = 0.0


class Executor(Protocol):
    """Runs jobs and gives their outcomes as they finish."""

    def run(self, jobs: Iterable[Job]) -> Generator[Outcome, None, None]:
        """Take jobs as there is room for them; never more than one ahead of the workers."""

    def drain(self) -> None:
        """Take no more jobs; those that run are finished."""

    @property
    def running(self) -> int:
        """Jobs in flight."""
