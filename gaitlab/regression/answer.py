"""The gate's answer as one JSON object, for a script."""

from __future__ import annotations

import json
from dataclasses import asdict
from math import isfinite

from gaitlab.regression.falls import Falls, Tally
from gaitlab.regression.gate import Outcome
from gaitlab.regression.page import headline
from gaitlab.regression.quantities import Quantity


def outcome_json(experiment: str, outcome: Outcome) -> str:
    """The same keys whatever was decided; `reason` is null if something was."""
    return json.dumps(
        {
            "verdict": outcome.verdict,
            "exit_code": outcome.exit_code,
            "headline": headline(experiment, outcome),
            "reason": outcome.undecided or None,
            "mode": outcome.mode,
            "compared": outcome.runs.n,
            "falls": _falls(outcome.falls),
            "equal_ids": outcome.compared,
            "other_bits": list(outcome.differing),
            "worse": [_told(quantity) for quantity in outcome.worse],
            "better": [_told(quantity) for quantity in outcome.improved],
            "declared": list(outcome.declared),
            "surroundings": [
                {"name": name, "before": then, "tonight": now}
                for name, then, now in outcome.surroundings
            ],
            "tests": [_finite(quantity) for quantity in outcome.quantities],
        }
    )


def _falls(falls: Falls) -> dict[str, object]:
    """Counts of all and of each cell, before and tonight; null where a side has no walks."""
    return {
        "before": _tally(falls.before),
        "tonight": _tally(falls.tonight),
        "alone_before": _tally(falls.alone_before),
        "alone_tonight": _tally(falls.alone_tonight),
        "cells": [
            {"cell": dict(c.cell), "before": _tally(c.before), "tonight": _tally(c.tonight)}
            for c in falls.cells
        ],
    }


def _tally(tally: Tally | None) -> dict[str, int] | None:
    return None if tally is None else {**asdict(tally), "n": tally.n}


def _told(quantity: Quantity) -> dict[str, str]:
    return {"quantity": quantity.name, "surface": quantity.surface or "all"}


def _finite(quantity: Quantity) -> dict[str, object]:
    return {
        name: None if isinstance(value, float) and not isfinite(value) else value
        for name, value in asdict(quantity).items()
    }
