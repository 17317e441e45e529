"""The metrics asked for, ground by ground: what the figure shows and the table of medians."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

from gaitlab.picture.figure_style import save
from gaitlab.report.falls import metrics_table, shown_unit, shown_values
from gaitlab.report.figures.measures import (
    MOST_POINTS,
    Panel,
    Sample,
    measures_figure,
    most_runs,
)
from gaitlab.report.markdown import details, image, section
from gaitlab.report.results import Results
from gaitlab.report.scores import truth
from gaitlab.report.words import plural, surface_text

USUAL = (
    "walking_speed",
    "pitch_amplitude",
    "roll_amplitude",
    "foot_clearance",
    "peak_plough_force",
    "cost_of_transport",
)
MOST_VARIANTS = 4  # side by side


def measures(results: Results, folder: Path) -> str:
    """The section with its figure written into the folder; empty if nothing was simulated."""
    panels = _panels(results)
    table = metrics_table(results)
    if not panels and not table:
        return ""
    picture = ""
    if panels:
        save(measures_figure(panels), folder, "measures")
        picture = image("Metrics of the single runs, one panel each, by ground", "measures.png")
    medians = details("Median [quartiles] over all simulated trials", table)
    return section(
        "Measures by ground", picture, _caption(results, panels) if panels else "", medians
    )


def _panels(results: Results) -> list[Panel]:
    names = [name for name in results.metrics or USUAL if name in results.trials.columns]
    panels = [_panel(results, name) for name in names]
    return [panel for panel in panels if _any(panel)]


def _any(panel: Panel) -> bool:
    return any(len(s.values) for grounds in panel.samples.values() for s in grounds.values())


def _panel(results: Results, name: str) -> Panel:
    label = f"{name.replace('_', ' ').replace('zmp', 'ZMP')} [{shown_unit(name)}]"
    grounds = list(dict.fromkeys(results.trials["surface"]))
    return Panel(
        label=label,
        samples={
            variant.label: {
                surface_text(ground): _sample(trials[trials["surface"] == ground], name)
                for ground in grounds
            }
            for variant in results.variants[:MOST_VARIANTS]
            for trials in [results.done_of(variant)]
        },
    )


def _sample(trials: pd.DataFrame, name: str) -> Sample:
    values = shown_values(name, trials[name])
    known = np.isfinite(values)
    return Sample(values=values[known], fell=truth(trials["fell"])[known])


def _caption(results: Results, panels: list[Panel]) -> str:
    rest = len(results.variants) - MOST_VARIANTS
    text = (
        "Every run up to its fall, all rows of the tables together: the line is the median, the "
        "box the middle half, the whiskers reach from the 5th to the 95th percentile."
    )
    if most_runs(panels) <= MOST_POINTS:
        text += " Runs far beyond the whiskers stand on the edge of the picture."
    return text if rest <= 0 else f"{text} {plural(rest, 'further variant')} not drawn."
