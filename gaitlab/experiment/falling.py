"""What a trial that fell, or never walked, counts as when candidates are compared.

A robot that falls at once has spent little energy, saturated no servo and leant on no edge of its
soles: most metrics of a fallen trial flatter it. A fall must never make a candidate look better,
so only metrics of falling itself are taken as measured. Of all others a fallen trial is lost: it
counts as the worst there is, or as a value of the study's own (`fallen: 0.0`), and then no other
trial counts as worse than that. The same holds for a trial that is INFEASIBLE or FAILED and for
one whose metric is not defined.
"""

from __future__ import annotations

from math import inf

from gaitlab.experiment.study import Direction

# Value in a trial that did not walk at all; in one that fell they are what was measured.
MEASURED: dict[tuple[str, Direction], float] = {
    ("stable", "maximize"): 0.0,
    ("stable_strict", "maximize"): 0.0,
    ("fell", "minimize"): 1.0,
    ("upright_time", "maximize"): 0.0,  # s
    ("distance_before_fall", "maximize"): 0.0,  # m
}
# Value in every lost trial: the robot gets nowhere.
NOWHERE: dict[tuple[str, Direction], float] = {
    ("distance", "maximize"): 0.0,  # m
    ("walking_speed", "maximize"): 0.0,  # m/s
    ("footsteps", "maximize"): 0.0,
}
# Metrics that candidates are not compared by: why, and what to ask for instead.
MISLEADING: dict[str, tuple[str, str]] = {
    "time_to_fall": ("only a trial that fell has it", "upright_time"),
    "fall_phase": ("only a trial that fell has it", "upright_time"),
    "walked_time": ("a walk that ends early because it is fast has less of it", "upright_time"),
}
# Of falling, asked for the other way round.
BACKWARDS: dict[tuple[str, Direction], str] = {
    (metric, "minimize" if direction == "maximize" else "maximize"): f"{direction} {metric}"
    for metric, direction in MEASURED
}


def is_measured(metric: str, direction: Direction) -> bool:
    """Whether a trial that fell counts as what was measured of it."""
    return (metric, direction) in MEASURED


def worst(metric: str, direction: Direction) -> float:
    """What a lost trial counts as unless a study says otherwise, in the metric's unit."""
    beyond = -inf if direction == "maximize" else inf
    return {**NOWHERE, **MEASURED}.get((metric, direction), beyond)
