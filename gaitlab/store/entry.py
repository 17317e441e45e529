"""A line of the index: what it knows of one trial, sealed against flipped bits."""

from __future__ import annotations

import json
import re
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple, cast

from gaitlab.errors import StoreError
from gaitlab.store.parquet import Unreadable, read_record
from gaitlab.store.record import Scalar, State, TrialRecord, canonical, finite, is_flat, lasting

_CRC = re.compile(rb'{"crc":"([0-9a-f]{8})",')
_HEAD = re.compile(
    rb'"trial_id":"([0-9a-f]{32})","size":(\d{1,18}),"state":"(DONE|INFEASIBLE|FAILED)","fell":(true|false),"details":'
)


class Details(NamedTuple):
    """What is looked up for tables and people only.

    Attributes:
        reason: First line of the record's reason.
        labels: Robot, gait, surface and balance controller, if any, by name, and the seed.
        metrics: As in the record.
        provenance: As in the record, without what differs between two equal runs.
    """

    reason: str
    labels: Mapping[str, Scalar]
    metrics: Mapping[str, Scalar]
    provenance: Mapping[str, Scalar]


@dataclass(frozen=True, kw_only=True)
class Entry:
    """What the index knows of one trial.

    Attributes:
        trial_id: Identity of the trial.
        size: Length of its file, in bytes.
        state: `DONE`, `INFEASIBLE` or `FAILED`.
        fell: Whether the robot fell.
        text: The details as JSON; parsed when asked for, because a store has many trials.
        trials: Folder of the trials' files, one of which gives the details if the text does not.
    """

    trial_id: str
    size: int
    state: State
    fell: bool
    text: bytes
    trials: Path | None = field(default=None, compare=False)

    @property
    def details(self) -> Details:
        """Everything else, read from the text, which a checksum alone does not make gaitlab's.

        Raises:
            StoreError: If it is not, and the trial's own file cannot be read.
        """
        try:
            found = Details(**json.loads(self.text))
            if isinstance(found.reason, str) and all(map(is_flat, found[1:])):
                return found
        except (ValueError, TypeError, RecursionError):
            pass
        try:
            record = read_record(trial_file(self.trials or Path(), self.trial_id))
        except (OSError, Unreadable) as error:
            raise StoreError(
                f"{error}; `gaitlab status --rebuild` writes the index anew"
            ) from error
        return entry(record, self.size).details

    @property
    def reason(self) -> str:
        """First line of the record's reason."""
        return self.details.reason


def trial_file(trials: Path, trial_id: str) -> Path:
    """Where the file of a trial is, or would be."""
    return trials / trial_id[:2] / f"{trial_id}.parquet"


def entry(record: TrialRecord, size: int) -> Entry:
    """The line of the index that stands for a record whose file has this size, in bytes."""
    names = record.trial.get("names", {})
    labels = {kind: names.get(kind) for kind in ("robot", "gait", "surface")}
    balance = {"balance": names["balance"]} if "balance" in names else {}
    details = Details(
        reason=next(iter(record.reason.splitlines()), ""),
        labels={**labels, **balance, "seed": record.trial.get("seed")},
        metrics={name: finite(value) for name, value in record.metrics.items()},
        provenance=lasting(record.provenance),
    )
    return Entry(
        trial_id=record.trial_id,
        size=size,
        state=record.state,
        fell=bool(record.metrics.get("fell")),
        text=canonical(details._asdict()).encode(),
    )


def encode(item: Entry) -> bytes:
    """The entry as one line of JSON, without the line's end."""
    fell = "true" if item.fell else "false"
    head = f'"trial_id":"{item.trial_id}","size":{item.size},"state":"{item.state}","fell":{fell},'
    rest = b'%b"details":%b}' % (head.encode(), item.text)
    return b'{"crc":"%08x",%b' % (zlib.crc32(rest), rest)


def decode(line: bytes, trials: Path | None = None) -> Entry | None:
    """The inverse of `encode`; None for a line that is torn or not what was written.

    Args:
        line: One line.
        trials: Folder of the files that the lines are about.
    """
    crc = _CRC.match(line)
    head = _HEAD.match(line, crc.end()) if crc else None
    if crc is None or head is None or zlib.crc32(line[crc.end() :]) != int(crc[1], 16):
        return None
    return Entry(
        trial_id=head[1].decode(),
        size=int(head[2]),
        state=cast(State, head[3].decode()),
        fell=head[4] == b"true",
        text=line[head.end() : -1],
        trials=trials,
    )
