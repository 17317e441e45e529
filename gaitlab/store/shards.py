"""How an experiment is shared out: whose trial is whose, which every shard finds out by itself.

A share is cut from the whole plan and not from what is missing, so that it is the same whenever a
shard begins and however often it begins again. Kept beside the list of trials, it lets anyone who
reads the store tell how far each shard is.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Collection, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, TypeAlias

from gaitlab.errors import StoreError, UsageError
from gaitlab.store.durable import NotAFile, read_whole, write_durably
from gaitlab.store.lists import TrialList
from gaitlab.store.record import canonical

SHARES = "shards.json"
MOST_SHARDS = 10_000
_TEXT = re.compile(r"(\d{1,6})/(\d{1,6})", re.ASCII)

ShardState: TypeAlias = Literal["pending", "running", "done"]


@dataclass(frozen=True, kw_only=True)
class Shard:
    """One of several equal shares of an experiment.

    Attributes:
        number: Which, from 1.
        count: Of how many.
    """

    number: int
    count: int

    def __str__(self) -> str:
        return f"{self.number}/{self.count}"

    @property
    def name(self) -> str:
        """As part of a file's name."""
        return f"{self.number}-of-{self.count}"

    @classmethod
    def of(cls, text: str) -> Shard:
        """A shard as it is written, `3/8`.

        Raises:
            UsageError: If it is none.
        """
        parts = _TEXT.fullmatch(text.strip())
        number, count = (int(part) for part in parts.groups()) if parts else (0, 0)
        if not 1 <= number <= count <= MOST_SHARDS:
            raise UsageError(
                f"--shard {text}: allowed is I/N, the I-th of N shards, counted from 1: for "
                f"instance 1/4, 2/4, 3/4 and 4/4; at most {MOST_SHARDS}"
            )
        return cls(number=number, count=count)


def shares(seconds: Mapping[str, float], count: int) -> dict[str, int]:
    """Number of the shard that each trial belongs to.

    The trials are dealt out to and fro, the longest first and those of a cell one after the other.
    So the loads of two shards differ by one trial at most, and each has some seeds of every cell,
    whether the robot soon falls in it or not.

    Args:
        seconds: How long each trial takes at most, in [s], by its id in the order of the plan.
        count: How many shards.
    """
    longest_first = sorted(seconds, key=lambda trial_id: -seconds[trial_id])
    numbers = {}
    for place, trial_id in enumerate(longest_first):
        turn, seat = divmod(place, count)
        numbers[trial_id] = (count - seat) if turn % 2 else seat + 1
    return {trial_id: numbers[trial_id] for trial_id in seconds}


@dataclass(frozen=True, kw_only=True)
class ShardStatus:
    """How far a shard is.

    Attributes:
        shard: Which.
        planned: Trials of its share.
        left: Those that have not ended.
        holder: Host, process and start of the run that is at it; empty if none is.
    """

    shard: Shard
    planned: int
    left: int
    holder: str

    @property
    def state(self) -> ShardState:
        """`running` while a process is at it, `done` when nothing of it is left."""
        return "running" if self.holder else "pending" if self.left else "done"


def write_shares(experiments: Path, name: str, numbers: Mapping[str, int], count: int) -> None:
    """Keep whose trial is whose beside the list of an experiment's trials."""
    content = {"shards": count, "of": dict(numbers)}
    text = canonical({**content, "sha256": _digest(content)}).encode()
    path = experiments / name / SHARES
    with suppress(FileNotFoundError, NotAFile):
        if read_whole(path) == text:
            return
    write_durably(path, text, within=experiments.parent)


def shard_statuses(
    experiments: Path, listed: TrialList, ended: Collection[str], at_work: Mapping[str, str]
) -> list[ShardStatus]:
    """How far the shards of an experiment are; none if it was never shared out as it is now.

    Args:
        experiments: Folder of the experiments of a store.
        listed: Trials of the experiment.
        ended: Trials of the store.
        at_work: Who runs which shard, by the shard's name.
    """
    wanted = {trial.trial_id for trial in listed.trials}
    count, numbers = _read_shares(experiments / listed.experiment / SHARES)
    if numbers.keys() != wanted:
        return []
    planned, left = [0] * (count + 1), [0] * (count + 1)
    for trial_id, number in numbers.items():
        planned[number] += 1
        left[number] += trial_id not in ended
    every = (Shard(number=number, count=count) for number in range(1, count + 1))
    return [
        ShardStatus(
            shard=shard,
            planned=planned[shard.number],
            left=left[shard.number],
            holder=at_work.get(shard.name, ""),
        )
        for shard in every
    ]


def _read_shares(path: Path) -> tuple[int, dict[str, int]]:
    """Number of shards and that of each trial; none if the file is not there or damaged."""
    try:
        content = json.loads(read_whole(path))
        seal = content.pop("sha256")
        if seal != _digest(content):
            return 0, {}
        return int(content["shards"]), content["of"]
    except (OSError, NotAFile, StoreError, ValueError, TypeError, KeyError, AttributeError):
        return 0, {}


def _digest(content: Mapping[str, object]) -> str:
    return hashlib.sha256(canonical(content).encode()).hexdigest()
