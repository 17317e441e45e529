"""Simulated walks of the biped: what straight legs cost beside bent ones, and what the gantry does.

References:
    Wilson1927: E. B. Wilson, Probable inference, the law of succession, and statistical inference,
        Journal of the American Statistical Association, 1927.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from gaitlab.errors import StoreError, UsageError
from gaitlab.experiment import load_experiment
from gaitlab.papers.page import Table
from gaitlab.plan import plan
from gaitlab.report.gather import gather
from gaitlab.statistics import wilson
from gaitlab.store import Store

STRAIGHT, BENT, GANTRY = "biped_straight", "biped_bent_knee", "biped_gantry"
HIPS, RIG = "gait.hip_height", "robot.gantry"
STRAIGHT_LEGS = "straight legs"
FIGURES = (  # metric, title, factor to the unit shown, digits
    ("energy", "positive work [J]", 1.0, 1),
    ("absolute_work", "work either way [J]", 1.0, 1),
    ("cost_of_transport", "cost of transport [-]", 1.0, 3),
    ("peak_torque", "peak torque [N m]", 1.0, 1),
    ("rms_torque", "RMS torque [N m]", 1.0, 2),
    ("rms_balancing_moment", "RMS gantry moment [N m]", 1.0, 1),
    ("peak_balancing_moment", "peak gantry moment [N m]", 1.0, 1),
    ("distance", "distance [m]", 1.0, 3),
    ("sole_penetration", "stance sole in the floor [mm]", 1e3, 3),
    ("coupling_residual", "gear residual [deg]", float(np.degrees(1.0)), 3),
)
EFFORTS = ("energy", "cost_of_transport", "peak_torque", "rms_torque")


def trials(store: Path, experiment: str) -> pd.DataFrame:
    """Planned trials that ended by themselves; empty when none was simulated."""
    try:
        found = gather([load_experiment(experiment)], Store(store)).trials
    except (StoreError, UsageError):
        return pd.DataFrame()
    return found[found["state"].isin(("DONE", "INFEASIBLE"))]


def walks(store: Path) -> dict[str, pd.DataFrame]:
    """Trials of every way of walking by what it is called; empty when none was simulated."""
    straight, bent = trials(store, STRAIGHT), trials(store, BENT)
    found = {} if straight.empty else {STRAIGHT_LEGS: straight}
    if not bent.empty:
        for height in sorted(bent[HIPS].unique(), reverse=True):
            found[f"bent, hips {height} m up"] = bent[bent[HIPS] == height]
    return found


def effort_table(found: dict[str, pd.DataFrame]) -> Table:
    """Median and range of every figure, a column a way of walking."""
    text = (
        "The same robot, gantry, floor, speed and footholds; median [smallest, largest] over the "
        "seeds, measured over three cycles after the start-up. From the experiments "
        f"`{STRAIGHT}` and `{BENT}`."
    )
    if not found:
        text = f"Not simulated yet: `gaitlab run {STRAIGHT}`, `gaitlab run {BENT}`."
    table = [["n", *(str(len(walk)) for walk in found.values())]]
    table.append(["stayed up", *(_share(walk) for walk in found.values())])
    table += [
        [title, *(_spread(walk[name] * factor, digits) for walk in found.values())]
        for name, title, factor, digits in FIGURES
    ]
    return Table(
        title="Energy and torque beside walking on bent knees",
        text=text,
        header=["", *found],
        rows=table if found else [],
    )


def _share(walk: pd.DataFrame) -> str:
    stable, n = int(walk["stable"].astype(bool).sum()), len(walk)
    low, high = wilson(stable, n)
    return f"{stable} of {n} [{100.0 * low:.0f}, {100.0 * high:.0f}] %"


def _spread(values: pd.Series, digits: int) -> str:
    numbers = values.astype(float).dropna()
    if numbers.empty:
        return "–"
    middle, low, high = numbers.median(), numbers.min(), numbers.max()
    return f"{middle:.{digits}f} [{low:.{digits}f}, {high:.{digits}f}]"


def gantry_table(store: Path) -> Table:
    """How many seeds stay up with and without the gantry, and when the others fall."""
    found, planned = trials(store, GANTRY), plan(load_experiment(GANTRY)).size
    text = (
        "Straight legs; seeds that stayed up with a 95 % Wilson interval, median time from the end "
        f"of the starting stride to the fall; {len(found)} of {planned} planned trials are in the "
        "store."
    )
    if found.empty:
        text = f"Not simulated yet: `gaitlab run {GANTRY}`."
    grounds = [] if found.empty else list(dict.fromkeys(found["surface"]))
    table = [] if found.empty else list(_gantry_rows(found, grounds))
    return Table(
        title="With the gantry and without", text=text, header=["gantry", *grounds], rows=table
    )


def _gantry_rows(found: pd.DataFrame, grounds: Sequence[str]) -> Iterator[list[str]]:
    for rig in dict.fromkeys(found[RIG]):
        cells = [found[(found[RIG] == rig) & (found["surface"] == g)] for g in grounds]
        yield [str(rig), *(_standing(cell) for cell in cells)]


def _standing(cell: pd.DataFrame) -> str:
    if cell.empty:
        return "–"
    times = cell["time_to_fall"].astype(float).dropna()
    fallen = f", falls after {times.median():.2f} s" if len(times) else ""
    return _share(cell) + fallen


def verdict(found: dict[str, pd.DataFrame]) -> str:
    """Which way of walking needs less, figure by figure, with n; says so when nothing is there."""
    straight = found.get(STRAIGHT_LEGS)
    bent = {name: walk for name, walk in found.items() if name != STRAIGHT_LEGS}
    if straight is None or not bent:
        return "Whether straight legs cost less than bent ones has not been simulated yet."
    titles = {name: title.split(" [")[0] for name, title, _, _ in FIGURES}
    parts = [f"{titles[name]} {_changes(straight[name], bent, name)}" for name in EFFORTS]
    n = min(len(walk) for walk in found.values())
    heights = ", ".join(name.removeprefix("bent, ") for name in bent)
    return (
        f"Beside bent knees at the same speed and footholds ({heights}; n = {n} each) straight "
        f"legs take, in the median: {'; '.join(parts)}. Ranges that overlap count as no difference."
    )


def _changes(straight: pd.Series, bent: dict[str, pd.DataFrame], name: str) -> str:
    """Change from each bent walk to the straight one, in words."""
    ours, said = straight.astype(float), []
    for walk in bent.values():
        other = walk[name].astype(float)
        apart = ours.max() < other.min() or ours.min() > other.max()
        change = 100.0 * (ours.median() / other.median() - 1.0)
        said.append(f"{change:+.0f} %" if apart else "no difference")
    return ", ".join(said)
