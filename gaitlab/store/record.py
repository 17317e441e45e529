"""What became of a trial: the one record that the store keeps of it, besides the log."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

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


def to_json(record: TrialRecord) -> str:
    """The record as one line of canonical JSON: sorted keys, no spaces, no NaN."""
    content = {
        "trial_id": record.trial_id,
        "state": record.state,
        "reason": record.reason,
        "trial": record.trial,
        "metrics": {name: finite(value) for name, value in record.metrics.items()},
        "provenance": {name: finite(value) for name, value in record.provenance.items()},
    }
    return canonical(content)


def from_json(text: str) -> TrialRecord:
    """The inverse of `to_json`.

    Raises:
        ValueError: If the text is no record.
    """
    try:
        return TrialRecord(**json.loads(text))
    except TypeError as error:
        raise ValueError(f"not a trial record: {error}") from error


def canonical(content: object) -> str:
    """JSON with sorted keys and no spaces, the same text for the same content."""
    return json.dumps(content, sort_keys=True, separators=(",", ":"), allow_nan=False)
