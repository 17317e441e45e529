"""The walks of an audit: what a store holds of a shipped experiment, in the words of its pages.

References:
    Wilson1927: E. B. Wilson, Probable inference, the law of succession, and statistical inference,
        Journal of the American Statistical Association, 1927.
"""

from __future__ import annotations

import shlex
from collections.abc import Collection
from pathlib import Path

import pandas as pd

from gaitlab.errors import StoreError, UnknownName, UsageError
from gaitlab.experiment import load_experiment
from gaitlab.experiment.shell import store_option
from gaitlab.report.gather import gather
from gaitlab.statistics import wilson
from gaitlab.store import Store


def trials(store: Path, experiment: str, states: Collection[str] = ("DONE",)) -> pd.DataFrame:
    """Planned trials of an experiment that are in these states; empty when none was simulated."""
    try:
        found = gather([load_experiment(experiment)], Store(store)).trials
    except (StoreError, UsageError, UnknownName):
        return pd.DataFrame()
    return found[found["state"].isin(tuple(states))]


def share_text(up: pd.Series) -> str:
    """How many of the walks, with n and the interval of [Wilson1927]."""
    count, n = int(up.fillna(value=False).astype(bool).sum()), len(up)
    low, high = wilson(count, n)
    return f"{count} of {n} [{100.0 * low:.0f}, {100.0 * high:.0f}] %"


def spread_text(values: pd.Series, digits: int, factor: float = 1.0) -> str:
    """Median [smallest, largest]."""
    numbers = factor * values.astype(float).dropna()
    if numbers.empty:
        return "–"
    middle, low, high = numbers.median(), numbers.min(), numbers.max()
    return f"{middle:.{digits}f} [{low:.{digits}f}, {high:.{digits}f}]"


def not_simulated(paper: str, store: Path, *experiments: str) -> str:
    """That walks are missing, and the commands that bring them onto the page."""
    option = store_option(store)
    lines = [["gaitlab", "run", name, *option] for name in experiments]
    lines.append(["gaitlab", "audit", paper, *option])
    commands = ", then ".join(f"`{shlex.join(line)}`" for line in lines)
    return f"Not simulated in this store: {commands}."
