"""What a study file asks for: a space to search, what is better, and what is not allowed.

The file's section `study:` becomes one `Study`. It says nothing of how the search is done; the
candidates that it proposes are ordinary cells of the experiment, see `gaitlab.experiment.plan`.

What a trial that fell, or never walked, counts as when candidates are compared: a robot that falls
at once has spent little energy, saturated no servo and leant on no edge of its soles, so most
metrics of a fallen trial flatter it. A fall must never make a candidate look better, so only
metrics of falling itself are taken as measured. Of all others a fallen trial is lost: it counts as
the worst there is, or as a value of the study's own (`fallen: 0.0`), and then no other trial
counts as worse than that. The same holds for a trial that is INFEASIBLE or FAILED and for one
whose metric is not defined.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import inf
from typing import Literal

from gaitlab.experiment.parts import Value
from gaitlab.model.settings import EngineName

Direction = Literal["maximize", "minimize"]
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


@dataclass(frozen=True, kw_only=True)
class Condition:
    """A parameter that is searched only while another one has certain values.

    Attributes:
        path: Dotted path of the other parameter, a `Choices` of the same space.
        values: Its values for which the parameter is searched; else it keeps its base.
    """

    path: str
    values: tuple[Value, ...]

    @property
    def text(self) -> str:
        """The condition as a sentence says it: `gait.heel_strike = add`."""
        return f"{self.path} = {' or '.join(map(_shown, self.values))}"


@dataclass(frozen=True, kw_only=True)
class Numbers:
    """A number that is searched.

    Attributes:
        path: Dotted path.
        low: Smallest value, in the parameter's unit.
        high: Largest value.
        step: Distance of the allowed values; None for any.
        log: Whether ratios count and not differences.
        integer: Whether only whole numbers are allowed.
        when: Restriction to some values of another parameter.
    """

    path: str
    low: float
    high: float
    step: float | None = None
    log: bool = False
    integer: bool = False
    when: Condition | None = None

    @property
    def ends(self) -> tuple[Value, ...]:
        """Smallest and largest value."""
        kind = int if self.integer else float
        return (kind(self.low), kind(self.high))

    @property
    def text(self) -> str:
        """The range in words: `0.01 to 0.06 in steps of 0.01`."""
        steps = f" in steps of {self.step:g}" if self.step else ""
        kind = ", whole" if self.integer else ""
        return f"{self.low:g} to {self.high:g}{steps}{kind}{', by ratio' if self.log else ''}"


@dataclass(frozen=True, kw_only=True)
class Choices:
    """One of several values that is searched.

    Attributes:
        path: Dotted path.
        options: The values, at least two.
        when: Restriction to some values of another parameter.
    """

    path: str
    options: tuple[Value, ...]
    when: Condition | None = None

    @property
    def ends(self) -> tuple[Value, ...]:
        """The options, of which none is an end."""
        return self.options

    @property
    def text(self) -> str:
        """The choices in words: `none, add`."""
        return ", ".join(map(_shown, self.options))


@dataclass(frozen=True, kw_only=True)
class Aggregate:
    """How many numbers become one.

    Attributes:
        kind: `mean`, `worst` (of the objective's direction), `quantile` or `cvar`, the mean of the
            worst share.
        share: For a quantile its place counted from the worst, for `cvar` the share; in (0, 1].
    """

    kind: Literal["mean", "worst", "quantile", "cvar"] = "mean"
    share: float = 1.0

    @property
    def text(self) -> str:
        """The aggregate in words: `mean`, `worst`, `25 % quantile`, `mean of the worst 25 %`."""
        if self.kind == "quantile":
            return f"{100.0 * self.share:g} % quantile"
        return f"mean of the worst {100.0 * self.share:g} %" if self.kind == "cvar" else self.kind


@dataclass(frozen=True, kw_only=True)
class Objective:
    """What is better.

    Attributes:
        metric: Name of a metric.
        direction: Which way is better.
        over_seeds: From the replicates on one surface to one number.
        over_surfaces: From the surfaces to one number.
        fallen: What a trial that fell counts as, in the metric's unit, and no trial counts as
            less; None for the metric's own rule, see the text above.
    """

    metric: str
    direction: Direction
    over_seeds: Aggregate = field(default_factory=Aggregate)
    over_surfaces: Aggregate = field(default_factory=Aggregate)
    fallen: float | None = None

    @property
    def text(self) -> str:
        """The objective in words: `maximize walking_speed (seeds mean, surfaces worst)`."""
        return f"{self.direction} {self.metric} ({_aggregates(self)})"


@dataclass(frozen=True, kw_only=True)
class Constraint:
    """What is not allowed.

    Attributes:
        metric: Name of a metric.
        bound: Largest or smallest value allowed, in the metric's unit.
        at_least: Whether the bound is the smallest value allowed, and not the largest.
        over_seeds: As of an objective.
        over_surfaces: As of an objective.
        fallen: As of an objective.
    """

    metric: str
    bound: float
    at_least: bool
    over_seeds: Aggregate = field(default_factory=Aggregate)
    over_surfaces: Aggregate = field(default_factory=Aggregate)
    fallen: float | None = None

    @property
    def direction(self) -> Direction:
        """Which way the metric has to go."""
        return "maximize" if self.at_least else "minimize"

    @property
    def text(self) -> str:
        """The constraint as a file writes it: `walking_speed >= 0.15`.

        Aggregates follow unless both are the mean.
        """
        how = _aggregates(self)
        more = "" if how == _aggregates(Objective(metric="", direction="maximize")) else f" ({how})"
        return f"{self.metric} {'>=' if self.at_least else '<='} {self.bound:g}{more}"


@dataclass(frozen=True, kw_only=True)
class Racing:
    """When a hopeless candidate is given up before it has walked with every seed.

    Attributes:
        rounds: Seeds after which candidates are judged, rising; the last is the number of seeds.
        confidence: How sure it must be that a candidate is worse than the best before it stops.
    """

    rounds: tuple[int, ...]
    confidence: float = 0.9


@dataclass(frozen=True, kw_only=True)
class Study:
    """A search over the parameters of an experiment.

    Attributes:
        sampler: tpe, cmaes, gp, nsga2, nsga3, qmc or random.
        sampler_options: Options of the sampler, by name.
        trials: Candidates to try in total.
        seed: Of the sampler.
        batch: Candidates that are proposed together, so that the search does not depend on how
            many workers there are.
        search: The space.
        objectives: One, or several for a Pareto front.
        constraints: All must hold.
        racing: None to walk every candidate with every seed.
        early_stop: Candidates without an improvement after which the search ends; None for never.
        confirm: Engine of the final and of all that checks the winner; None for the search's own.
    """

    sampler: str
    sampler_options: Mapping[str, Value]
    trials: int
    seed: int
    batch: int
    search: tuple[Numbers | Choices, ...]
    objectives: tuple[Objective, ...]
    constraints: tuple[Constraint, ...]
    racing: Racing | None
    early_stop: int | None
    confirm: EngineName | None = None


def _shown(value: Value) -> str:
    """A value as a file writes it."""
    return str(value).lower() if isinstance(value, bool) else str(value)


def _aggregates(wanted: Objective | Constraint) -> str:
    fallen = "" if wanted.fallen is None else f", a fall counts {wanted.fallen:g}"
    return f"seeds {wanted.over_seeds.text}, surfaces {wanted.over_surfaces.text}{fallen}"


def is_measured(metric: str, direction: Direction) -> bool:
    """Whether a trial that fell counts as what was measured of it."""
    return (metric, direction) in MEASURED


def worst(metric: str, direction: Direction) -> float:
    """What a lost trial counts as unless a study says otherwise, in the metric's unit."""
    beyond = -inf if direction == "maximize" else inf
    return {**NOWHERE, **MEASURED}.get((metric, direction), beyond)
