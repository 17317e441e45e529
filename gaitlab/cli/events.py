"""What happens in a run, for machines: one JSON object a line on stdout.

    event    when                   keys
    member   the next of several    experiment, number: what comes next is of this member of a
                                    reproduction; its `end` is that of all members
    start    the plan is known      counts
    trial    a trial has ended      id, state, stable (null if nothing was simulated), cell, seed,
                                    reason (why there is no result; else empty)
    minute   about once a minute    counts, time_left in [s] (null while unknown)
    message  the user has to know   text
    end      nothing runs any more  counts, seconds, interrupted: the object of `--json`

The counts are planned, cached, done, infeasible, failed, newly_failed, falls, and of those
fell_standing, the ones before the first step. A stream that stops without `end` is that of a run
that was killed or refused; its exit code says which.
"""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Callable, Mapping
from contextlib import suppress

from gaitlab.cli.printing import MINUTE
from gaitlab.running import Ended, Silent, Summary

COUNTS = (
    *("planned", "cached", "done", "infeasible", "failed", "newly_failed"),
    *("falls", "fell_standing"),
)


def summary_object(summary: Summary) -> dict[str, object]:
    """What `--json` prints of a run."""
    rest = {"seconds": round(summary.seconds, 3), "interrupted": summary.interrupted}
    return {**_counts(summary), **rest}


def end_line(summary: Summary) -> str:
    """The last line of a run."""
    return json.dumps({"event": "end", **summary_object(summary)})


class JsonLines(Silent):
    """Writes an event a line, each at once and whole.

    Args:
        clock: Gives the time, in [s].
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock, self._last = clock, clock()
        # Its own way out, because others' output is kept from stdout while trials run.
        self._file = os.dup(1) if sys.stdout is not None else os.open(os.devnull, os.O_WRONLY)

    def start(self, summary: Summary) -> None:
        """The plan is known."""
        self._write("start", _counts(summary))

    def ended(self, trial: Ended) -> None:
        """A trial has ended."""
        found = {"id": trial.trial_id, "state": trial.state, "stable": trial.stable}
        where = {"cell": dict(trial.cell), "seed": trial.seed, "reason": trial.reason}
        self._write("trial", {**found, **where})

    def update(self, summary: Summary) -> None:
        """The counts, if it is time."""
        if self._clock() - self._last >= MINUTE:
            self._last = self._clock()
            left = summary.time_left
            rounded = None if left is None else round(left, 1)
            self._write("minute", {**_counts(summary), "time_left": rounded})

    def message(self, text: str) -> None:
        """Something the user should know now."""
        self._write("message", {"text": text})

    def finish(self, summary: Summary) -> None:
        """Close the way out; the command itself writes the end."""
        os.close(self._file)

    def _write(self, event: str, content: Mapping[str, object]) -> None:
        with suppress(BrokenPipeError):  # who read it has gone; the run goes on
            os.write(self._file, f"{json.dumps({'event': event, **content})}\n".encode())


def _counts(summary: Summary) -> dict[str, object]:
    return {name: getattr(summary, name) for name in COUNTS}
