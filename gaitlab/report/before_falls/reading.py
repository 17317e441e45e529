"""From a store to numbers about many walks: each log is read once, and only what is needed."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import NamedTuple

import pandas as pd

from gaitlab.log import TrialLog
from gaitlab.log_columns import columns
from gaitlab.report.before_falls.courses import courses
from gaitlab.report.before_falls.measures import MEASURES, measured, piece_before
from gaitlab.report.before_falls.standing import (
    COLUMNS,
    first_axis,
    row_at,
    stand,
    support_at,
)
from gaitlab.store import Store

PLACES = 6  # decimals of a cycle count; two windows that agree in them are one

STORY = ["support", "axis", "pitch_growth", "roll_growth", "zmp_drift", "full_cycles"]


def body_log(store: Store, trial_id: str) -> TrialLog:
    """The log of a trial without its joints: trunk, CoM, ZMP and feet.

    Raises:
        UnknownName: If the store does not hold it.
        StoreError: If its file is damaged, or the trial ended without a log.
    """
    part = store.log_part(trial_id, [column.name for column in columns(())])
    header = replace(part.header, joints=(), torque_limits=())
    return TrialLog(header=header, arrays=part.arrays)


def stands(store: Store, trial_ids: Iterable[str]) -> pd.DataFrame:
    """Until when each robot stood well: `cycles` and `lead` of `stand`, by trial."""
    found = {}
    for trial_id in dict.fromkeys(trial_ids):
        until = stand(*store.log_part(trial_id, COLUMNS))
        found[trial_id] = (round(until.cycles, PLACES), until.lead)
    return pd.DataFrame.from_dict(found, orient="index", columns=["cycles", "lead"])


class Read(NamedTuple):
    """What one reading of the logs gave.

    Attributes:
        windows: One row a window: `trial_id`, `cycles` and every measure, in SI units.
        stories: By trial how a fall came: `support`, `axis`, `pitch_growth`, `roll_growth`,
            `zmp_drift`, `full_cycles`.
    """

    windows: pd.DataFrame
    stories: pd.DataFrame


def read(store: Store, asked: pd.DataFrame, falls: Mapping[str, float]) -> Read:
    """Every measure of the gait cycles asked for, and how every fall came.

    Args:
        store: Where the logs are.
        asked: `trial_id` and `cycles`, where the gait cycle ends; may repeat itself.
        falls: When each robot that fell last stood well, in cycles, by trial.
    """
    ends: dict[str, dict[float, None]] = {trial_id: {} for trial_id in falls}
    for trial_id, cycles in zip(asked["trial_id"], asked["cycles"], strict=True):
        ends.setdefault(str(trial_id), {})[float(cycles)] = None
    rows, told = [], {}
    for trial_id, at in ends.items():
        log = body_log(store, trial_id)
        for cycles in at:
            piece = piece_before(log, row_at(log.header, cycles))
            rows.append({"trial_id": trial_id, "cycles": cycles, **measured(piece)})
        if trial_id in falls:
            told[trial_id] = _story(log, row_at(log.header, falls[trial_id]))
    names = ["trial_id", "cycles", *MEASURES]
    found = pd.DataFrame(rows, columns=names).astype(dict.fromkeys(names[1:], float))
    return Read(found, pd.DataFrame.from_dict(told, orient="index", columns=STORY))


def _story(log: TrialLog, row: int) -> tuple[object, ...]:
    return (support_at(log, row), first_axis(log, row), *courses(log, row))
