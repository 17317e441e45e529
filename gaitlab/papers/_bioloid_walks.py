"""The Bioloid's walks as simulated: what a store holds of its experiments, with n and intervals.

References:
    Wilson1927: E. B. Wilson, Probable inference, the law of succession, and statistical inference,
        Journal of the American Statistical Association, 1927.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from gaitlab.errors import StoreError, UsageError
from gaitlab.experiment import load_experiment
from gaitlab.papers.page import Table
from gaitlab.report.gather import gather
from gaitlab.statistics import wilson
from gaitlab.store import Store

WALK, POSES, COPIES, DANCE = "bioloid_walk", "bioloid_poses", "bioloid_robots", "bioloid_dance"
LATENCY, SPREAD = "servo.latency", "spread.servo_latency"
TITLES = {LATENCY: "latency [s]", SPREAD: "spread of latency [s]"}
LAWS = ("gait.ankle_law", "gait.coupling", "gait.stance_omega_sign")
FIGURES = (  # metric, title, factor to the unit shown, digits
    ("time_to_fall", "falls at [s]", 1.0, 2),
    ("distance", "distance [m]", 1.0, 3),
    ("heading_drift", "turned by [deg]", float(np.degrees(1.0)), 1),
    ("roll_amplitude", "roll amplitude [deg]", float(np.degrees(1.0)), 1),
)


def trials(store: Path, experiment: str) -> pd.DataFrame:
    """Trials that ended by themselves; empty when none was simulated."""
    try:
        found = gather([load_experiment(experiment)], Store(store)).trials
    except (StoreError, UsageError):
        return pd.DataFrame()
    return found[found["state"] == "DONE"]


def tables(store: Path) -> list[Table]:
    """One table an experiment."""
    return [
        _table(store, POSES, "The five poses as printed, simulated", LAWS),
        _table(store, WALK, "Poses found here, simulated", ("surface",)),
        _table(store, COPIES, "Robot 1 and robot 2: late servos", (LATENCY, SPREAD)),
        _table(store, DANCE, "The dance", ("gait.tempo", "surface")),
    ]


def _table(store: Path, experiment: str, title: str, paths: Sequence[str]) -> Table:
    found = trials(store, experiment)
    text = (
        f"`gaitlab run {experiment}`; stayed up with a 95 % Wilson interval [Wilson1927], medians "
        "[smallest, largest] over the seeds. A time of a fall counts from the start of measured "
        "walking; a negative one lies in the steps before."
    )
    if found.empty:
        text = f"Not simulated yet: `gaitlab run {experiment}`."
    header = [*(TITLES.get(path, path.split(".")[-1]) for path in paths), "stayed up"]
    header += [title for _, title, _, _ in FIGURES]
    groups = [] if found.empty else list(found.groupby(list(paths), sort=False))
    rows = [
        [*map(str, key), stayed_up(cell), *(_spread(cell[m], f, d) for m, _, f, d in FIGURES)]
        for key, cell in groups
    ]
    return Table(title=title, text=text, header=header, rows=rows)


def stayed_up(cell: pd.DataFrame) -> str:
    """Share of walks without a fall, with n and interval."""
    fallen = cell["fell"].astype(bool)
    up, n = int((~fallen).sum()), len(cell)
    low, high = wilson(up, n)
    return f"{up} of {n} [{100.0 * low:.0f}, {100.0 * high:.0f}] %"


def _spread(values: pd.Series, factor: float, digits: int) -> str:
    numbers = factor * values.astype(float).dropna()
    if numbers.empty:
        return "–"
    middle, low, high = numbers.median(), numbers.min(), numbers.max()
    return f"{middle:.{digits}f} [{low:.{digits}f}, {high:.{digits}f}]"


def verdict(store: Path) -> str:
    """What the simulation says of the servo delays, with n."""
    found = trials(store, COPIES)
    if found.empty:
        return (
            "Whether late servos make the walk fall has not been simulated yet "
            f"(`gaitlab run {COPIES}`)."
        )
    parts = [
        f"{stayed_up(cell)} stayed up with servos {1e3 * latency:.0f} ± {1e3 * spread:.0f} ms late"
        for (latency, spread), cell in found.groupby([LATENCY, SPREAD], sort=False)
    ]
    return (
        f"In simulation {', '.join(parts)}; the delays are ours, the paper gives none, so this "
        "shows what delays of that size do and not what robot 2 suffered from."
    )
