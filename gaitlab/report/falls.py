"""Falls, trials that could not be run, and what the other metrics say, each with its n."""

from __future__ import annotations

import numpy as np
import pandas as pd

from gaitlab.metrics import lookup
from gaitlab.report.markdown import escape, table
from gaitlab.report.results import Results
from gaitlab.report.scores import fell_standing, truth
from gaitlab.report.words import NOTHING, plural

DIRECTIONS = ("forward", "backward", "left", "right")
SHOWN_METRICS = (
    "distance",
    "walking_speed",
    "pitch_amplitude",
    "roll_amplitude",
    "zmp_margin_p5",
    "zmp_inside_share",
    "foot_clearance",
    "toe_first_share",
    "peak_plough_force",
    "saturation_share",
    "cost_of_transport",
)
MOST_REASONS = 12  # rows; the rest is counted


def fallen(trials: pd.DataFrame) -> pd.DataFrame:
    """Trials that ended in a fall."""
    return trials[(trials["state"] == "DONE") & truth(trials["fell"])]


def falls_table(results: Results) -> str:
    """Falls of each variant by direction, with the time to the fall."""
    header = [
        "",
        "trials",
        "falls",
        "before the first step",
        *DIRECTIONS,
        "median time to fall [s]",
        "infeasible",
        "failed",
        "missing",
    ]
    rows = [_falls_row(escape(v.label), results.of(v)) for v in results.variants]
    if len(rows) > 1:
        rows.append(_falls_row("all", results.trials))
    # Columns of nothing but zeros say nothing.
    told = [k for k in range(len(header)) if any(row[k] not in ("0", NOTHING) for row in rows)]
    return table([header[k] for k in told], [[row[k] for k in told] for row in rows], "lr")


def _falls_row(label: str, trials: pd.DataFrame) -> list[str]:
    falls = fallen(trials)
    counts = [str(int((falls["fall_direction"] == name).sum())) for name in DIRECTIONS]
    states = [str(int((trials["state"] == s).sum())) for s in ("INFEASIBLE", "FAILED", "MISSING")]
    done = int((trials["state"] == "DONE").sum())
    time = quartiles(falls["time_to_fall"])
    early = str(fell_standing(falls))
    return [label, str(len(trials)), f"{len(falls)} of {done}", early, *counts, time, *states]


def quartiles(values: pd.Series) -> str:
    """Median, quartiles and n of the numbers that are defined."""
    known = numbers(values)
    if not len(known):
        return NOTHING
    low, middle, high = np.percentile(known, [25, 50, 75])
    return f"{middle:.3g} [{low:.3g}, {high:.3g}], n = {len(known)}"


def numbers(values: pd.Series) -> np.ndarray:
    """The finite numbers of a column, whatever else it holds. Shape (n,)."""
    known = pd.to_numeric(values, errors="coerce").to_numpy(dtype=float)
    return known[np.isfinite(known)]


def reasons(results: Results) -> str:
    """Why trials are infeasible or failed, the commonest first; empty when there are none."""
    odd = results.trials[results.trials["state"].isin(("INFEASIBLE", "FAILED"))]
    if odd.empty:
        return ""
    groups = odd.fillna({"reason": ""}).groupby(["state", "reason"], sort=True).size()
    ordered = groups.sort_values(ascending=False, kind="stable")
    rows = [[state, str(n), escape(_first_line(why))] for (state, why), n in ordered.items()]
    text = table(["state", "trials", "reason"], rows[:MOST_REASONS], "lrl")
    rest = len(rows) - MOST_REASONS
    return text if rest <= 0 else f"{text}\n\n{plural(rest, 'further reason')} not shown."


def _first_line(reason: object) -> str:
    lines = str(reason).strip().splitlines()
    return lines[0][:200] if lines else "no reason recorded"


def measures_of(results: Results) -> list[str]:
    """Metrics that a page shows: those that its experiments ask for, then the usual ones."""
    asked = dict.fromkeys((*results.metrics, *SHOWN_METRICS))
    return [name for name in asked if name in results.trials.columns]


def metrics_table(results: Results) -> str:
    """Median and quartiles of the other metrics, one column a variant, falls included."""
    names = measures_of(results)
    if results.done.empty or not names:
        return ""
    rows = []
    for name in names:
        done = [results.done_of(variant) for variant in results.variants]
        cells = [quartiles(pd.Series(shown_values(name, trials[name]))) for trials in done]
        rows.append([f"{escape(name)} [{shown_unit(name)}]", *cells])
    return table(["metric", *(escape(v.label) for v in results.variants)], rows, "l")


def shown_unit(name: str) -> str:
    """Unit in which a page gives a metric: angles in degrees, all else in SI units."""
    unit = lookup(name).unit
    return "°" if unit == "rad" else unit


def shown_values(name: str, values: pd.Series) -> np.ndarray:
    """A metric in the unit that the page gives it in; NaN where it is not defined. Shape (n,)."""
    found = pd.to_numeric(values, errors="coerce").to_numpy(dtype=float)
    return np.degrees(found) if lookup(name).unit == "rad" else found
