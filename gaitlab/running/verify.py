"""Is the store what it was? Every checksum, and a random sample simulated once more."""

from __future__ import annotations

import random
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import gaitlab.simulation.trial
from gaitlab.documents.steps import expect, step
from gaitlab.errors import StoreError
from gaitlab.experiment.named_code import named_code, refusal, unnamed_code
from gaitlab.running.executor import Job, Outcome, job_of
from gaitlab.running.processes import executor
from gaitlab.simulation.trial import own_code
from gaitlab.store import Store, TrialRecord, Unreadable, fingerprint

LONGEST = 3600.0  # s, the longest horizon of an experiment
RERUN_STATES = ("DONE", "INFEASIBLE")  # a failure need not repeat itself


@dataclass(frozen=True, kw_only=True)
class Verdict:
    """What was found.

    Attributes:
        checked: Trials whose file was read to the last column.
        unsound: Files that are not what was written, as messages.
        repeated: Trials that were simulated again and gave the same bits.
        different: Trials that did not, with the reason as far as it is known.
        skipped: Trials of the sample that could not be simulated again, with the reason.
    """

    checked: int
    unsound: tuple[Unreadable, ...]
    repeated: int = 0
    different: tuple[str, ...] = ()
    skipped: tuple[str, ...] = ()

    @property
    def sound(self) -> bool:
        """Whether nothing wrong was found."""
        return not (self.unsound or self.different)


def verify(
    store: Store,
    *,
    sample: int = 0,
    jobs: int = 1,
    choose: Callable[[Sequence[str], int], Sequence[str]] | None = None,
    allowed: Callable[[Sequence[str]], bool] = lambda files: False,
) -> Verdict:
    """Read every file to the last column, and simulate some trials again.

    The store is only read.

    Args:
        store: What to verify.
        sample: How many trials to simulate again.
        jobs: Worker processes; 0 simulates in this process.
        choose: Picks from the ids of the trials; at random by default.
        allowed: Whether to simulate a trial that runs files which only the store names.

    Raises:
        StoreError: If the store cannot be read.
    """
    index = store.index()
    step(f"checking the files of {len(index.entries)} trials")
    unsound = tuple(store.unsound())
    wrong = {error.path.stem for error in unsound}
    repeatable = [
        key
        for key, item in index.entries.items()
        if item.state in RERUN_STATES and key not in wrong
    ]
    pick = choose or random.Random().sample
    chosen = pick(repeatable, min(sample, len(repeatable)))
    repeated, different, skipped = _repeat(store, chosen, jobs, allowed)
    return Verdict(
        checked=len(index.entries) - len(wrong & index.entries.keys()),
        unsound=unsound,
        repeated=repeated,
        different=tuple(different),
        skipped=tuple(skipped),
    )


def _repeat(
    store: Store, chosen: Sequence[str], jobs: int, allowed: Callable[[Sequence[str]], bool]
) -> tuple[int, list[str], list[str]]:
    """Count of trials that gave the same bits, messages on those that did not, on those skipped."""
    records = {trial_id: store.record(trial_id) for trial_id in chosen}
    now = gaitlab.simulation.trial.PHYSICS_VERSION
    old = [i for i, record in records.items() if record.trial.get("physics_version") != now]
    skipped = [f"{i}: of another physics version than {now}" for i in old]
    unnamed = _unnamed(store, [record for i, record in records.items() if i not in old])
    refused = {i: files for i, files in unnamed.items() if not allowed(files)}
    skipped += [f"{i}: {refusal(files)}" for i, files in refused.items()]
    due = [_job(record) for i, record in records.items() if i not in {*old, *refused}]
    repeated, different = 0, list[str]()
    with tempfile.TemporaryDirectory(prefix="gaitlab-verify-") as folder:
        again = Store(Path(folder))
        expect(len(due))
        for number, outcome in enumerate(executor(again.path, jobs).run(due), start=1):
            step(f"simulated {number} of {len(due)} again")
            reason = _difference(store, again, outcome)
            repeated += not reason
            if reason:
                different.append(f"{outcome.job.trial_id}: {reason}")
    return repeated, different, skipped


def _unnamed(store: Store, records: Sequence[TrialRecord]) -> dict[str, list[str]]:
    """Files that only the store names, by the trial that would run them."""
    coded = [record for record in records if own_code(record.trial)]
    named = named_code(store.path) if coded else set()
    found = {record.trial_id: unnamed_code(record.trial, named) for record in coded}
    return {i: files for i, files in found.items() if files}


def _job(record: TrialRecord) -> Job:
    """The trial of a record once more; its time-out goes by its horizon at the longest."""
    trial: Mapping[str, Any] = record.trial
    horizon = trial.get("horizon", {}).get("time")
    seconds = horizon if isinstance(horizon, float | int) and horizon < LONGEST else LONGEST
    return job_of(record.trial_id, trial, seconds)


def _difference(store: Store, again: Store, outcome: Outcome) -> str:
    trial_id = outcome.job.trial_id
    if outcome.record is None:
        return outcome.reason
    if outcome.record.state == "FAILED":
        return f"failed this time: {outcome.record.reason.splitlines()[0]}"
    if fingerprint(again.file(trial_id)) == fingerprint(store.file(trial_id)):
        return ""
    try:
        before = store.record(trial_id).provenance
    except StoreError:
        before = {}
    now = outcome.record.provenance
    changed = [name for name in now if name in _NUMERIC and before.get(name) != now[name]]
    differences = "; ".join(f"{name} was {before.get(name)}, is {now[name]}" for name in changed)
    return f"other numbers this time ({differences or 'the same versions and platform'})"


_NUMERIC = (
    *("numpy_version", "engine_version", "numba_version", "platform", "processor"),
    *("gaitlab_version", "git_commit"),
)
