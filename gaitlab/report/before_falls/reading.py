"""From a store to numbers about many walks: each log is read once, and only what is needed."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

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


def windows(store: Store, asked: pd.DataFrame) -> pd.DataFrame:
    """Every measure of the gait cycle that ends so many cycles after the start-up.

    Args:
        store: Where the logs are.
        asked: `trial_id` and `cycles`; the same window may be asked for twice.

    Returns:
        One row a window, `trial_id`, `cycles` and a column a measure, in SI units.
    """
    rows = []
    wanted = asked[["trial_id", "cycles"]].drop_duplicates()
    for trial_id, group in wanted.groupby("trial_id", sort=False):
        log = body_log(store, str(trial_id))
        for cycles in group["cycles"]:
            piece = piece_before(log, row_at(log.header, cycles))
            rows.append({"trial_id": trial_id, "cycles": cycles, **measured(piece)})
    names = ["trial_id", "cycles", *MEASURES]
    return pd.DataFrame(rows, columns=names).astype(dict.fromkeys(names[1:], float))


def stories(store: Store, found: pd.DataFrame) -> pd.DataFrame:
    """How each walk went up to where it last stood well, by trial.

    Args:
        store: Where the logs are.
        found: `cycles` by trial, as of `stands`.

    Returns:
        Columns `support`, `axis`, `pitch_growth`, `roll_growth`, `zmp_drift`, `full_cycles`.
    """
    told = {}
    for trial_id, cycles in found["cycles"].items():
        log = body_log(store, str(trial_id))
        row = row_at(log.header, cycles)
        course = courses(log, row)
        told[trial_id] = (support_at(log, row), first_axis(log, row), *course)
    names = ["support", "axis", "pitch_growth", "roll_growth", "zmp_drift", "full_cycles"]
    return pd.DataFrame.from_dict(told, orient="index", columns=names)
