"""What a reader of the HTML form opens: the seeds of each cell, and one figure of any measure.

Here is the data of both, as JSON on the page; `explorer.js` shows it, and plotly draws. The page
stays one file, so plotly's script lies in it, packed, and is unpacked once the figure is seen. The
cells are those of an experiment; `gaitlab.report.study.explorer` has the candidates of a study.
"""

from __future__ import annotations

import base64
import json
import zlib
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from html import escape
from importlib import resources
from pathlib import Path
from typing import ClassVar
from urllib.parse import quote

import numpy as np
import pandas as pd

from gaitlab.metrics import lookup
from gaitlab.render.figure_style import CYCLE, GREEN, ORANGE, PURPLE, SKY, VERMILLION, YELLOW
from gaitlab.report.cells import cells_in_order
from gaitlab.report.falls import measures_of, shown_unit, shown_values
from gaitlab.report.maps import SHARES
from gaitlab.report.matching import places
from gaitlab.report.representative import shortened
from gaitlab.report.results import ONE_ROW, Results
from gaitlab.report.scores import ScoredCell
from gaitlab.report.variants import Value, value_text
from gaitlab.report.words import axis_text, column_text, path_text, place_text, with_unit

REPLAYS = "replays"  # folder beside a page, with a file a trial, ID.html
DIGITS = 5  # of a measure; a reader who needs all has `gaitlab query`
AIMS = {"higher": "More is better.", "lower": "Less is better.", "neither": ""}
COLOURS = 6  # of variants on a light page, and on a dark one in the same order
ON_DARK = (SKY, ORANGE, GREEN, PURPLE, YELLOW, VERMILLION)
PLOTLY = "package_data/plotly.min.js"
GZIP = 16 + zlib.MAX_WBITS  # a gzip header, which browsers unpack; without a time in it


@dataclass(frozen=True, kw_only=True, eq=False)
class Explorer(ABC):
    """What a reader of the HTML form opens and draws.

    Attributes:
        picture: Name of the figure of the page whose place the one that it draws takes.
        replays: Link to the replay of a trial by its id, relative to the page.
        options: What a command on a trial needs besides its id, ` --store DIR` for instance.
    """

    picture: ClassVar[str]
    replays: Mapping[str, str]
    options: str = ""

    @abstractmethod
    def data(self) -> dict[str, object]:
        """What `explorer.js` shows, as JSON's own types; a number that is not known is None."""

    def bar(self, number: int) -> str:
        """What stands in a table beside the words of a cell; nothing by default."""
        del number
        return ""

    def below(self) -> str:
        """HTML below the figure; nothing by default."""
        return ""

    @property
    def walks(self) -> str:
        """The file that holds all replays; empty where there is none, or each has its own."""
        files = {link.partition("#")[0] for link in self.replays.values()}
        return files.pop() if len(files) == 1 else ""

    def figure(self, name: str) -> str:
        """Where the figure is drawn, and what chooses its measure.

        Args:
            name: What a reader gets who cannot see it.
        """
        return (
            f'<figure class="plot"><figcaption><label>Show <select id="measure"></select></label> '
            f'<span id="meaning"></span></figcaption><div id="plot" role="group" '
            f'aria-label="{escape(name)}"></div></figure>\n{self.below()}'
        )

    def blocks(self) -> str:
        """The dialog of a cell, the data, and plotly, for the end of the page."""
        data = json.dumps(self.data(), ensure_ascii=False, separators=(",", ":"), allow_nan=False)
        safe = data.replace("<", "\\u003c")  # nothing in it can end the element
        packed = zlib.compressobj(9, zlib.DEFLATED, GZIP)
        script = packed.compress(plotly().encode()) + packed.flush()
        return "\n".join(
            [
                DIALOG,
                f'<script type="application/json" id="data">{safe}</script>',
                f'<script type="text/plain" id="plotly">{base64.b64encode(script).decode()}'
                "</script>",
            ]
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class CellExplorer(Explorer):
    """The cells and trials of an experiment.

    Attributes:
        results: What the page was computed from.
    """

    picture: ClassVar[str] = SHARES
    results: Results

    @cached_property
    def cells(self) -> list[tuple[str, Value, Value]]:
        """Variant, row and column of every cell, in the order of the tables of cells."""
        return [
            (variant.label, row, column) for variant, row, column in cells_in_order(self.results)
        ]

    def scored(self, number: int) -> ScoredCell:
        """The cell of a number."""
        label, row, column = self.cells[number]
        variant = next(v for v in self.results.variants if v.label == label)
        return self.results.cell(variant, row, column)

    def bar(self, number: int) -> str:
        """The share of a cell and its interval as a bar; empty where there is none to draw."""
        cell = self.scored(number)
        if not cell.n or not cell.feasible:
            return ""
        low, high = (100.0 * end for end in cell.interval())
        span = f"left:{low:.0f}%;right:{100.0 - high:.0f}%"
        mark = f"left:{100.0 * cell.share():.0f}%"
        inside = f'<i style="{span}"></i><b style="{mark}"></b>'
        return f'<span class="bar" aria-hidden="true">{inside}</span>'

    def data(self) -> dict[str, object]:
        """Rows, columns, cells and trials of the experiment."""
        results = self.results
        one_row = results.rows == ONE_ROW
        return {
            "rows": ["" if one_row else _tick(row) for row in results.row_values],
            "row": "" if one_row else axis_text(results, results.rows),
            "columns": [column_text(results, value) for value in results.column_values],
            "variants": [variant.label for variant in results.variants],
            "colours": {"light": CYCLE[:COLOURS], "dark": ON_DARK},
            "cells": list(self._cells()),
            "measures": [measure(name) for name in measures_of(results)],
            "options": self.options,
            "trials": self._trials(),
        }

    def _cells(self) -> Iterator[dict[str, object]]:
        results = self.results
        labels = [variant.label for variant in results.variants]
        for number, (label, row, column) in enumerate(self.cells):
            cell, title = self.scored(number), place_text(results, row, column)
            row_number, column_number = results.row_values.index, results.column_values.index
            yield {
                "title": f"{label}: {title}" if len(labels) > 1 else title,
                "place": [labels.index(label), row_number(row), column_number(column)],
                "stable": cell.count(),
                "n": cell.n,
                "interval": list(cell.interval()) if cell.n else None,
                "stands": cell.stands,
            }

    def _trials(self) -> dict[str, object]:
        """Every planned trial, a list a quantity."""
        results, trials = self.results, self.results.trials
        numbers = {place: number for number, place in enumerate(self.cells)}
        where = zip(trials["variant"], trials[results.rows], trials[results.columns], strict=True)
        ids = [str(name) for name in trials["trial_id"]]
        apart = [path for path in places(results) if path not in (results.rows, results.columns)]
        return {
            "cell": [numbers.get(place) for place in where],
            "seed": [int(seed) for seed in trials["seed"]],
            "id": shortened(ids, ids),
            "ended": [ended(row) for row in trials.to_dict("records")],
            "more": {
                path_text(path): [with_unit(results, path, value) for value in trials[path]]
                for path in apart
                if path != ONE_ROW and trials[path].nunique() > 1
            },
            "time": rounded(pd.to_numeric(trials["time_to_fall"], errors="coerce")),
            "values": {
                name: rounded(shown_values(name, trials[name])) for name in measures_of(results)
            },
            "replay": [self.replays.get(name) for name in ids],
        }


def replays_beside(folder: Path, ids: Sequence[str]) -> dict[str, str]:
    """Link to the replay of each trial that has one in the folder of a page.

    A replay is the file `replays/ID.html`, where ID is the trial's id or enough of its first
    digits.
    """
    files = {path.stem: path.name for path in sorted((folder / REPLAYS).glob("*.html"))}
    found = {}
    for trial in ids:
        stem = next((stem for stem in files if len(stem) >= 8 and trial.startswith(stem)), None)
        if stem is not None:
            found[trial] = f"{REPLAYS}/{quote(files[stem])}"
    return found


def plotly() -> str:
    """The script that draws figures, as the package plotly ships it."""
    return resources.files("plotly").joinpath(PLOTLY).read_text(encoding="utf-8")


def ended(trial: Mapping[str, object]) -> str:
    """How a trial of the table of trials ended, in words."""
    state = trial["state"]
    if state != "DONE":
        why = str(trial.get("reason") or "").partition("\n")[0]
        named = {"MISSING": "not run yet"}.get(str(state), str(state).lower())
        return f"{named}: {why}" if why and state != "MISSING" else named
    if trial["fell"]:
        where = trial.get("fall_direction")
        early = ", before its first step" if trial.get("fell_standing") is True else ""
        return f"fell {where}{early}" if isinstance(where, str) else f"fell{early}"
    return "stayed up" if trial["stable_strict"] else "stayed up, stalled"


def _tick(value: Value) -> str:
    """A value of the rows on an axis, whose title has the unit."""
    return value_text(value).replace("_", " ")


def measure(name: str) -> dict[str, str]:
    """Name, title and meaning of a metric."""
    item, unit = lookup(name), shown_unit(name)
    meaning = " ".join(item.doc.partition("\n\n")[0].split())
    return {
        "name": name,
        "title": path_text(name) + ("" if unit == "-" else f" [{unit}]"),
        "meaning": " ".join(text for text in (meaning, AIMS[item.better]) if text),
    }


def rounded(values: Iterable[float]) -> list[float | None]:
    """Numbers to the digits of a page; None for those that are not known."""
    return [float(f"{v:.{DIGITS}g}") if np.isfinite(v) else None for v in map(float, values)]


DIALOG = """\
<dialog id="cell" aria-labelledby="cell-title">
<form method="dialog"><h2 id="cell-title"></h2><button aria-label="Close">\u00d7</button></form>
<p id="cell-text"></p>
<div class="scroll" tabindex="0" role="region" aria-label="Seeds of the cell"><table></table></div>
<p id="cell-watch"></p>
</dialog>"""
