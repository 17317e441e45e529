"""The paper's three walks on pedestal 1, beside trials with the same step length and sway.

References:
    EROS2018: D. Pristovani R. et al., Walking Trajectory Optimization Algorithm for Robot Humanoid
        on Synthetic Grass, EMITTER International Journal of Engineering Technology, 2018.
        Experiments 1 to 3, Figures 24, 26 and 28.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import isclose

import numpy as np
import pandas as pd

from gaitlab.report.falls import fallen, numbers, quartiles
from gaitlab.report.markdown import escape, table
from gaitlab.report.reference import STEP_LENGTH_OF_ONE, TABLES, pedestals, rows_of
from gaitlab.report.reference import table_of_optimisation as table_of
from gaitlab.report.results import Results, Variant
from gaitlab.report.words import NOTHING, share
from gaitlab.statistics import wilson

STEP, SWAY = "gait.step_length", "gait.lateral_sway"
HEADER = (
    "",
    "figure",
    "pitch amplitude [°]",
    "paper [°]",
    "runs that fell",
    "paper",
    "distance before the fall [m]",
    "paper [m]",
)


BESIDE_WALKS = """\
Beside the walks that the paper describes. Its fall distances of 2680, 3570 and 4460 mm are 890
apart whatever the step length, so they may be times in ms; read them with that doubt."""


def walks_table(results: Results) -> str:
    """One row a variant and printed walk that it repeats; empty when it repeats none."""
    if not {STEP, SWAY, "surface"} <= set(results.trials.columns):
        return ""
    rows = [
        _row(variant, trials, printed)
        for variant in results.variants
        for _, trials in results.done_of(variant).groupby([STEP, SWAY, "surface"], sort=False)
        if (printed := _printed(results, trials)) is not None
    ]
    return table(list(HEADER), rows, "l") if rows else ""


def _printed(results: Results, trials: pd.DataFrame) -> Mapping[str, str] | None:
    """The printed walk with the step length, sway, ground and optimisation of these trials."""
    first = trials.iloc[0].to_dict()
    answer = table_of(first)
    if answer is None:
        return None
    numeral = first[STEP] / STEP_LENGTH_OF_ONE[results.reading]
    for walk in rows_of("eros_experiments"):
        same = (
            isclose(float(walk["X_mm"]), numeral, abs_tol=1e-6),
            isclose(float(walk["Y_mm"]) / 1000.0, first[SWAY], abs_tol=1e-6),
            pedestals()[walk["pedestal"]] == first["surface"],
            walk["optimization"] == TABLES[answer],
        )
        if all(same):
            return walk
    return None


def _row(variant: Variant, trials: pd.DataFrame, printed: Mapping[str, str]) -> list[str]:
    falls, n = len(fallen(trials)), len(trials)
    return [
        escape(variant.label),
        escape(printed["figure"]),
        "± " + _degrees(trials),
        f"± {printed['avg_pitch_vibration_deg_plusminus']}",
        share(falls, n, wilson(falls, n)),
        "fell" if printed["fell"] == "yes" else "did not fall",
        quartiles(trials["distance_before_fall"]) if "distance_before_fall" in trials else NOTHING,
        printed["distance_m"],
    ]


def _degrees(trials: pd.DataFrame) -> str:
    return quartiles(pd.Series(np.degrees(numbers(trials["pitch_amplitude"]))))
