"""What became of a trial: the one record that the store keeps of it, besides the log."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias, get_args

VOLATILE = (
    "host",
    "finished",
    "wall_time",
    "processor_time",
)  # of the provenance: differs between equal runs
LARGEST_INTEGER = 1 << 63  # of a table
VOLATILE_WIDTH = 512  # characters they are padded to, so that equal trials have equally long files
State: TypeAlias = Literal["DONE", "INFEASIBLE", "FAILED"]
Scalar: TypeAlias = float | int | bool | str | None


@dataclass(frozen=True, kw_only=True)
class TrialRecord:
    """Outcome of one trial.

    Attributes:
        trial_id: Identity of the trial, 32 hexadecimal digits.
        state: `DONE` (a fall is done), `INFEASIBLE` or `FAILED`.
        reason: Why it is not `DONE`; empty when it is.
        trial: The whole trial as plain data, enough to run it again.
        metrics: Metric name to value; None where a metric is not defined.
        provenance: Versions, host and time of the run; no part of the identity.
    """

    trial_id: str
    state: State
    reason: str
    trial: Mapping[str, Any]
    metrics: Mapping[str, Scalar]
    provenance: Mapping[str, Scalar]


def finite(value: Scalar) -> Scalar:
    """The value itself, or None for a number that JSON cannot hold (NaN, infinity)."""
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def to_json(record: TrialRecord) -> tuple[str, str]:
    """The record as two lines of canonical JSON: what equal trials share, and the rest, padded."""
    provenance = {name: finite(value) for name, value in record.provenance.items()}
    content = {
        "trial_id": record.trial_id,
        "state": record.state,
        "reason": record.reason,
        "trial": record.trial,
        "metrics": {name: finite(value) for name, value in record.metrics.items()},
        "provenance": lasting(provenance),
    }
    volatile = {name: value for name, value in provenance.items() if name in VOLATILE}
    return canonical(content), canonical(volatile).ljust(VOLATILE_WIDTH)


def from_json(text: str, volatile: str) -> TrialRecord:
    """The inverse of `to_json`.

    Raises:
        ValueError: If the text is no record.
    """
    try:
        content = json.loads(text)
        provenance = {**content.pop("provenance"), **json.loads(volatile)}
        record = TrialRecord(**content, provenance=provenance)
    except (TypeError, KeyError, AttributeError, RecursionError) as error:
        raise ValueError(f"not a trial record: {error}") from error
    _require_kinds(record)
    return record


def _require_kinds(record: TrialRecord) -> None:
    """A seal says that nothing was damaged, not that gaitlab wrote what it seals."""
    trial = record.trial
    sound = (
        isinstance(record.trial_id, str)
        and record.state in get_args(State)
        and isinstance(record.reason, str)
        and is_flat(record.metrics)
        and is_flat(record.provenance)
        and isinstance(trial, dict)
        and is_flat(trial.get("names", {}))
        and is_scalar(trial.get("seed"))
        and isinstance(trial.get("horizon", {}), dict)
    )
    if not sound:
        raise ValueError("not a trial record: a value is of another kind")


def is_flat(content: object) -> bool:
    """Whether something read from JSON is a mapping of names to single values."""
    return isinstance(content, dict) and all(map(is_scalar, content.values()))


def is_scalar(value: object) -> bool:
    """Whether something read from JSON is a single value, and finite if it is a number."""
    if isinstance(value, float):
        return math.isfinite(value)
    if isinstance(value, int):
        return -LARGEST_INTEGER <= value < LARGEST_INTEGER
    return value is None or isinstance(value, str)


def lasting(provenance: Mapping[str, Scalar]) -> dict[str, Scalar]:
    """The provenance without what differs between two equal runs."""
    return {name: finite(value) for name, value in provenance.items() if name not in VOLATILE}


def canonical(content: object) -> str:
    """JSON with sorted keys and no spaces, the same text for the same content."""
    return json.dumps(content, sort_keys=True, separators=(",", ":"), allow_nan=False)
