"""A gait tuned on one ground and run on others."""

from __future__ import annotations

import math
from dataclasses import dataclass

from gaitlab.report.markdown import escape, table
from gaitlab.report.study.findings import Findings
from gaitlab.report.study.fresh import score
from gaitlab.report.study.words import UNKNOWN
from gaitlab.report.words import share, surface_text
from gaitlab.search.fresh import DEFAULT, RANDOM, WINNER, Rerun
from gaitlab.statistics import wilson


@dataclass(frozen=True, kw_only=True)
class Crossing:
    """A gait tuned somewhere and run on one ground.

    Attributes:
        stable: Seeds on their feet to the horizon.
        n: Seeds with a result.
        objective: The first objective on this ground alone; NaN if it is not defined there.
        tuned: Whether this is a ground that it was tuned on.
    """

    stable: int
    n: int
    objective: float
    tuned: bool


def crossings(findings: Findings) -> dict[str, dict[str, Crossing]]:
    """The walked combinations by label and ground; only those that have any result."""
    rows = {}
    for rerun in findings.reruns:
        cells = {ground: _crossing(findings, rerun, ground) for ground in _grounds(rerun)}
        if any(cell.n for cell in cells.values()):
            rows[_row_label(findings, rerun)] = cells
    return rows


def _row_label(findings: Findings, rerun: Rerun) -> str:
    grounds = " + ".join(surface_text(name) for name in findings.grounds)
    if rerun.label == WINNER:
        return f"{grounds}, {findings.experiment.name}"
    if rerun.label == RANDOM:
        return f"{grounds}, random search"
    return "nothing, hand-set default"


def _grounds(rerun: Rerun) -> tuple[str, ...]:
    return tuple(dict.fromkeys(walk.surface for walk in rerun.walks))


def _crossing(findings: Findings, rerun: Rerun, ground: str) -> Crossing:
    walks = rerun.on([ground])
    found = score(findings.study, walks, 0).value if walks else math.nan
    return Crossing(
        stable=sum(walk.stable for walk in walks),
        n=len(walks),
        objective=found,
        tuned=rerun.label != DEFAULT and ground in findings.grounds,
    )


def crossings_table(rows: dict[str, dict[str, Crossing]]) -> str:
    """The same as a table, shares with n and interval; where it was tuned in bold."""
    grounds = list(dict.fromkeys(ground for row in rows.values() for ground in row))
    body = [
        [escape(label), *(_crossing_text(row.get(ground)) for ground in grounds)]
        for label, row in rows.items()
    ]
    return table(["tuned on", *(escape(surface_text(name)) for name in grounds)], body, "l")


def _crossing_text(cell: Crossing | None) -> str:
    if cell is None or not cell.n:
        return UNKNOWN
    text = share(cell.stable, cell.n, wilson(cell.stable, cell.n))
    return f"**{text}**" if cell.tuned else text
