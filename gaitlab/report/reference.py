"""Published tables of stable and unstable cells, to stand beside simulated ones.

References:
    EROS2018: D. Pristovani R., A. Wijayanto, A. H. Alasiry and A. S. Khalilullah, Walking
        Trajectory Optimization Algorithm for Robot Humanoid on Synthetic Grass, EMITTER
        International Journal of Engineering Technology, 2018. Tables 7 and 8.
"""

from __future__ import annotations

import csv
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import Literal, NamedTuple

from gaitlab.errors import UnknownName
from gaitlab.statistics import efficiency, stability_percent

Direction = Literal["forward", "backward"]
DistanceReading = Literal["foot_travel", "cm", "mm"]

# How long a step is, in [m], when the tables print 1: as the world travel of the swing foot (two
# step lengths) in cm, as the step length in cm, or in mm as the experiments of the same paper.
STEP_LENGTH_OF_ONE: Mapping[DistanceReading, float] = {
    "foot_travel": 0.005,
    "cm": 0.01,
    "mm": 0.001,
}
TABLES = {"eros_table7": "without", "eros_table8": "with"}
OPTIMISATION = ("gait.heel_strike", "gait.landing_deceleration")  # its two halves


class Place(NamedTuple):
    """One cell of a printed table."""

    direction: Direction
    distance: int
    surface: str


@dataclass(frozen=True, kw_only=True)
class Published:
    """A printed table.

    Attributes:
        name: File in `gaitlab/papers/printed`.
        title: How the paper calls it.
        cells: True where the paper prints STABLE.
        stated: Percentage the text states for a surface.
        stated_efficiency: Mean of those as the text states it, in percent.
    """

    name: str
    title: str
    cells: Mapping[Place, bool]
    stated: Mapping[str, float]
    stated_efficiency: float

    def counted(self, surface: str) -> float:
        """Percentage of printed cells of a surface that are stable."""
        return stability_percent([v for k, v in self.cells.items() if k.surface == surface])

    @property
    def all_counted(self) -> dict[str, float]:
        """Counted percentage of every surface."""
        return {surface: self.counted(surface) for surface in self.stated}

    @property
    def counted_efficiency(self) -> float:
        """Mean of the counted percentages over the surfaces."""
        return efficiency(list(self.all_counted.values()))


@cache
def rows_of(name: str) -> tuple[Mapping[str, str], ...]:
    """Rows of a CSV file shipped in `gaitlab/papers/printed`, as text."""
    file = resources.files("gaitlab.papers.printed").joinpath(f"{name}.csv")
    return tuple(csv.DictReader(file.read_text(encoding="utf-8").splitlines()))


@cache
def pedestals() -> Mapping[str, str]:
    """Pedestal number to the surface that stands for it, `1` to `grass_50mm` for instance."""
    return {
        row["pedestal"]: f"{row['surface'].split()[-1]}_{row['height_mm']}mm"
        for row in rows_of("eros_pedestals")
    }


@cache
def published(name: str) -> Published:
    """A printed table by the name that `compare` gives.

    Raises:
        UnknownName: If there is no such table.
    """
    if name not in TABLES:
        raise UnknownName(
            f"report.compare: no published table {name!r}; known: {', '.join(sorted(TABLES))}"
        )
    stated = [row for row in rows_of("eros_efficiency") if row["optimization"] == TABLES[name]]
    (summary,) = (
        row for row in rows_of("eros_efficiency_summary") if row["optimization"] == TABLES[name]
    )
    return Published(
        name=name,
        title=f"Table {stated[0]['table']}",
        cells=_cells(name),
        stated={
            pedestals()[row["pedestal"]]: float(row["stability_pct_as_stated"]) for row in stated
        },
        stated_efficiency=float(summary["efficiency_pct_as_stated"]),
    )


def _cells(name: str) -> dict[Place, bool]:
    cells = {}
    for row in rows_of(name):
        direction: Direction = "backward" if row["direction"] == "backward" else "forward"
        distance = int(row["distance_cm_as_printed"])
        for number, surface in pedestals().items():
            place = Place(direction, distance, surface)
            cells[place] = row[f"pedestal_{number}"] == "STABLE"
    return cells


def place_of(step_length: float, surface: str, reading: DistanceReading) -> Place | None:
    """Cell of the printed tables that a step length in [m] stands for; None if between cells."""
    printed = abs(step_length) / STEP_LENGTH_OF_ONE[reading]
    distance = round(printed)
    if abs(printed - distance) > 1e-6:
        return None
    return Place("backward" if step_length < 0 else "forward", distance, surface)


def table_of_optimisation(values: Mapping[str, object]) -> str | None:
    """Table that a gait answers to: with both halves of the optimisation, without, or neither."""
    halves = [values.get(path, "none") != "none" for path in OPTIMISATION]
    if any(halves) != all(halves):
        return None
    return next(name for name, kind in TABLES.items() if (kind == "with") == all(halves))
