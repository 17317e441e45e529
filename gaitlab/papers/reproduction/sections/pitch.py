"""Pitch and falls of a paper's single experiments beside the simulated ones.

References:
    EROS2018: D. Pristovani R. et al., Walking Trajectory Optimization Algorithm for Robot Humanoid
        on Synthetic Grass, EMITTER International Journal of Engineering Technology, 2018. Figs. 24,
        26 and 28 and the text beside them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import degrees

import numpy as np
import pandas as pd

from gaitlab.experiment import Experiment
from gaitlab.papers.printed import eros_tables, pedestals
from gaitlab.papers.printed import rows as rows_of
from gaitlab.papers.reproduction.answers import table_of
from gaitlab.papers.reproduction.section import Context, Section, option
from gaitlab.report.cells import STEP
from gaitlab.report.falls import numbers
from gaitlab.report.markdown import escape, table
from gaitlab.report.results import Results
from gaitlab.report.scores import truth
from gaitlab.report.words import NOTHING, share
from gaitlab.statistics import wilson

OPTIONS = (option("labels", dict[str, str], {}, "words for variants, {variant: words}"),)
SWAY = "gait.lateral_sway"
NEAR = 1e-6  # m, rounding of a step length or a sway that is the published one
READ = {
    "foot_travel": "foot travel in cm",
    "cm": "step length in cm",
    "mm": "step length in mm",
}
HOW_TO_READ = """\
The paper gives one walk without and one with optimisation at each of three settings, on pedestal 1.
*Amplitude* is half the range of the trunk's pitch in a gait cycle, averaged over the cycles from
the third on, that of a fall left out: median [lower, upper quartile] over the n runs that walked a
whole cycle. A run is *short* if it fell before two such cycles; then its earlier cycles count, with
none of them the last before the fall. The paper does not say how it measured. *Distance* is what
was covered before the fall or the end, likewise, over all runs; behind it stands what the horizon
allows. The paper's distances do not fit its step lengths: its walks would take 670 to 740 mm a
step."""


@dataclass(frozen=True, kw_only=True)
class Published:
    """One setting of the paper, without or with optimisation."""

    experiment: int
    figure: str
    ground: str
    x: float  # as printed, mm
    y: float  # m
    amplitude: float  # deg
    fell: bool
    distance: float  # m, as printed
    optimised: bool


def published_settings() -> dict[int, dict[bool, Published]]:
    """The paper's settings by number, each without and with optimisation."""
    found: dict[int, dict[bool, Published]] = {}
    for row in rows_of("eros_experiments"):
        item = Published(
            experiment=int(row["experiment"]),
            figure=row["figure"],
            ground=pedestals()[row["pedestal"]],
            x=float(row["X_mm"]),
            y=1e-3 * float(row["Y_mm"]),
            amplitude=float(row["avg_pitch_vibration_deg_plusminus"]),
            fell=row["fell"] == "yes",
            distance=float(row["distance_m"]),
            optimised=row["optimization"] == "with",
        )
        found.setdefault(item.experiment, {})[item.optimised] = item
    return found


def pitch_section(section: Section, context: Context) -> str:
    """Amplitude, falls and distance of each setting, reading and variant, as Markdown."""
    labels = section.options["labels"]
    words = labels if isinstance(labels, Mapping) else {}
    rows = [
        row
        for name in section.experiments
        for row in _rows(context.results[name], context.experiments[name], words)
    ]
    if not rows:
        return "No walk here has the step length and the sway of one of the paper's settings."
    head = [
        "setting", "read as", "variant", "engine", "amplitude, paper", "simulated", "falls, paper",
        "simulated", "distance, paper", "simulated, of at most",
    ]  # fmt: skip
    walks = list(dict.fromkeys(tuple(row[:3]) for row in rows))  # engines of one stand together
    rows.sort(key=lambda row: (row[0], walks.index(tuple(row[:3]))))
    if len({row[3] for row in rows}) == 1:
        head, rows = [*head[:3], *head[4:]], [[*row[:3], *row[4:]] for row in rows]
    return table(head, rows, "lll")


def _rows(results: Results, member: Experiment, words: Mapping[str, object]) -> Iterator[list[str]]:
    """A row for each setting, reading and variant that a member has."""
    cycles, engine = member.parts.horizon.cycles, "/".join(sorted(member.engines))
    for setting in published_settings().values():
        for reading, meant in eros_tables()[0].readings.items():
            step = setting[False].x * meant.one
            for variant in results.variants:
                trials = walks_of(results.of(variant), setting[False], step)
                if len(trials[trials["state"] == "DONE"]):
                    label = escape(str(words.get(variant.label, variant.label)))
                    found = table_of(variant)
                    answered = None if found is None else found is eros_tables()[1]
                    printed = None if answered is None else setting[answered]
                    head = [f"{setting[False].figure}, {_setting(setting[False])}", READ[reading]]
                    yield [*head, label, engine, *_cells(trials, printed, 2.0 * cycles * step)]


def walks_of(trials: pd.DataFrame, setting: Published, step: float) -> pd.DataFrame:
    """Runs on the setting's ground with its sway and this step length, in [m]."""
    on_ground = trials["surface"] == setting.ground
    steps = (trials[STEP].astype(float) - step).abs() < NEAR
    return trials[on_ground & steps & ((trials[SWAY].astype(float) - setting.y).abs() < NEAR)]


def _setting(setting: Published) -> str:
    return f"X = {setting.x:g}, Y = {1e3 * setting.y:g}"


def _cells(trials: pd.DataFrame, printed: Published | None, longest: float) -> list[str]:
    done = trials[trials["state"] == "DONE"]
    falls, n = int(truth(done["fell"]).sum()), len(done)
    measured = done[done["pitch_amplitude"].notna()] if "pitch_amplitude" in done else done[:0]
    amplitudes = [degrees(value) for value in _numbers(measured, "pitch_amplitude")]
    short = len(measured) - int(truth(measured["pitch_settled"]).sum())
    distances = list(_numbers(done, "distance_before_fall"))
    return [
        NOTHING if printed is None else f"±{printed.amplitude:g}°",
        _quartiles(amplitudes, "°", 1) + (f", {short} short" if short else ""),
        NOTHING if printed is None else ("falls" if printed.fell else "no fall"),
        share(falls, n, wilson(falls, n)),
        NOTHING if printed is None else f"{printed.distance:.2f} m",
        f"{_quartiles(distances, ' m', 2)}, of {longest:.2f} m",
    ]


def _numbers(trials: pd.DataFrame, metric: str) -> np.ndarray:
    """Values of a metric in the runs that have it. Shape (n,)."""
    return numbers(trials[metric]) if metric in trials.columns else np.empty(0)


def _quartiles(values: Sequence[float], unit: str, digits: int) -> str:
    if not len(values):
        return NOTHING
    low, middle, high = np.percentile(values, [25.0, 50.0, 75.0])
    between = f"[{low:.{digits}f}, {high:.{digits}f}]"
    return f"{middle:.{digits}f}{unit} {between}, n = {len(values)}"
