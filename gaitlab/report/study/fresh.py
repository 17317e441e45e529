"""Gaits on seeds that the search never saw, and on grounds that it was not tuned on.

A seed stands for one draw of everything that differs between replicates, so whole seeds are drawn
again for an interval, with all grounds they walked on, and two gaits are compared seed by seed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import isfinite, nan
from typing import NamedTuple

from gaitlab.experiment.study import Constraint, Objective, Study
from gaitlab.report.markdown import escape, table
from gaitlab.report.study.findings import Findings
from gaitlab.report.study.words import UNKNOWN
from gaitlab.report.words import share, surface_text
from gaitlab.search.fresh import DEFAULT, RANDOM, SEARCHED, WINNER, Rerun
from gaitlab.search.objectives import TrialOutcome, combined, counted
from gaitlab.search.objectives import score as scored
from gaitlab.statistics import Count, Interval, Verdict, seed_interval, verdict_of, wilson


class Score(NamedTuple):
    """A number with the interval that drawing the seeds again gives it, and the seeds drawn."""

    value: float
    interval: Interval
    seeds: int

    @property
    def verdict(self) -> Verdict:
        """Of a lead, by whether its interval excludes zero."""
        return verdict_of(self.interval)


def score(study: Study, walks: Sequence[TrialOutcome], place: int) -> Score:
    """One objective of some walks, in the metric's unit.

    Raises:
        ValueError: If there are no walks.
    """
    objective = study.objectives[place]
    by_seed = _by_seed(objective, walks)
    return _resampled(sorted(by_seed), lambda seeds: _value(objective, by_seed, seeds))


def gain(study: Study, one: Rerun, other: Rerun, place: int, grounds: Sequence[str]) -> Score:
    """How much better one combination is than another on the same seeds; above 0 is better.

    Raises:
        ValueError: If they share no seed.
    """
    objective = study.objectives[place]
    sign = 1.0 if objective.direction == "maximize" else -1.0
    first, second = (_by_seed(objective, rerun.on(grounds)) for rerun in (one, other))

    def lead(seeds: Sequence[int]) -> float:
        here, there = _value(objective, first, seeds), _value(objective, second, seeds)
        return 0.0 if here == there else sign * (here - there)  # equally infinite is equal

    return _resampled(sorted(first.keys() & second.keys()), lead)


def constraint_value(constraint: Constraint, walks: Sequence[TrialOutcome]) -> float:
    """What a constraint bounds, over some walks, in the metric's unit."""
    return scored(constraint, walks)


def stable_of(walks: Sequence[TrialOutcome]) -> Count:
    """Walks that stayed on their feet among all."""
    return Count(sum(walk.stable for walk in walks), len(walks))


def optimism(told: float, again: float, objective: Objective) -> float | None:
    """How much better the search made a gait look than it is; None if that has no value."""
    if not (isfinite(told) and isfinite(again)):
        return None
    return told - again if objective.direction == "maximize" else again - told


def _by_seed(
    wanted: Objective, walks: Sequence[TrialOutcome]
) -> dict[int, list[tuple[str, float]]]:
    """Ground and number of each walk by seed, only those seeds that have walked on every ground."""
    grounds = {walk.surface for walk in walks}
    found: dict[int, list[tuple[str, float]]] = {}
    for walk in walks:
        found.setdefault(walk.seed, []).append((walk.surface, counted(wanted, walk)))
    return {seed: numbers for seed, numbers in found.items() if len(numbers) == len(grounds)}


def _value(
    wanted: Objective, by_seed: dict[int, list[tuple[str, float]]], seeds: Sequence[int]
) -> float:
    return combined(wanted, [number for seed in seeds for number in by_seed[seed]])


def _resampled(seeds: Sequence[int], value: Callable[[Sequence[int]], float]) -> Score:
    """A value of all seeds with its interval."""
    interval = seed_interval(seeds, value)
    return Score(value(seeds), interval, len(seeds))


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
        grounds = dict.fromkeys(walk.surface for walk in rerun.walks)
        cells = {ground: _crossing(findings, rerun, ground) for ground in grounds}
        if any(cell.n for cell in cells.values()):
            rows[_row_label(findings, rerun)] = cells
    return rows


def _row_label(findings: Findings, rerun: Rerun) -> str:
    grounds = " + ".join(surface_text(name) for name in findings.grounds)
    if rerun.label == WINNER:
        return f"{grounds}, {findings.experiment.name}"
    if rerun.label == SEARCHED:
        return f"{grounds}, {findings.experiment.name} in {findings.experiment.parts.engine.name}"
    if rerun.label == RANDOM:
        return f"{grounds}, random search"
    return "nothing, hand-set default"


def _crossing(findings: Findings, rerun: Rerun, ground: str) -> Crossing:
    walks = rerun.on([ground])
    objective = findings.study.objectives[0]
    by_seed = _by_seed(objective, walks)
    found = _value(objective, by_seed, sorted(by_seed)) if walks else nan
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
