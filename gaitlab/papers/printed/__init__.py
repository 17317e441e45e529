"""Tables as papers print them; see the README beside this file. Read here, judged by the audits."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from functools import cache
from importlib import resources

from gaitlab.experiment.reference import ReferenceTable, load_reference
from gaitlab.statistics import stability_percent


@cache
def rows(name: str) -> tuple[Mapping[str, str], ...]:
    """Rows of `name`.csv in this folder, as text by the titles of the columns."""
    text = resources.files(__name__).joinpath(f"{name}.csv").read_text(encoding="utf-8")
    return tuple(csv.DictReader(text.splitlines()))


@cache
def pedestals() -> Mapping[str, str]:
    """Number of a pedestal of the EROS paper to the surface that stands for it."""
    return {
        row["pedestal"]: f"{row['surface'].split()[-1]}_{row['height_mm']}mm"
        for row in rows("eros_pedestals")
    }


def eros_tables() -> tuple[ReferenceTable, ReferenceTable]:
    """Tables 7 and 8 of the EROS paper: without and with its optimisation."""
    return load_reference("eros_table7"), load_reference("eros_table8")


def forward_counted(table: ReferenceTable) -> dict[str, float]:
    """Percentage of the forward cells that are stable, by ground."""
    ahead = {
        ground: [stable for place, stable in table.cells.items()
                 if place.surface == ground and place.direction == "forward"]
        for ground in table.stated
    }  # fmt: skip
    return {ground: stability_percent(cells) for ground, cells in ahead.items()}
