"""The samplers that a study can ask for by name: their options, and what each can search.

Names and meanings of the options are Optuna's; its version 5 was asked what it refuses and what it
quietly replaces by random values.

References:
    Optuna: Akiba et al., Optuna: a next-generation hyperparameter optimization framework, KDD
        2019; samplers of version 5.0.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from gaitlab.documents import Node, build
from gaitlab.errors import FileError, Problem
from gaitlab.experiment.parts import Value
from gaitlab.experiment.study import Choices, Numbers, Objective
from gaitlab.parameters import parameter
from gaitlab.plugins import suggestion


def _candidates(default: int, doc: str, low: float = 1) -> int:
    found: int = parameter(default, unit="-", low=low, high=1e6, doc=doc)
    return found


def _probability(default: float, doc: str) -> float:
    found: float = parameter(default, unit="-", low=0.0, high=1.0, doc=doc)
    return found


def _switch(doc: str, default: bool = False) -> bool:
    found: bool = parameter(default, unit="-", doc=doc)
    return found


RANDOM_FIRST = "candidates at random before the sampler learns"


@dataclass(frozen=True, kw_only=True)
class Random:
    """Options of `random`."""


@dataclass(frozen=True, kw_only=True)
class Tpe:
    """Options of `tpe`, the tree-structured Parzen estimator."""

    n_startup_trials: int = _candidates(10, RANDOM_FIRST, low=0)
    n_ei_candidates: int = _candidates(24, "draws of which the most promising is proposed")
    multivariate: bool = _switch(
        "learn parameters together and not one by one; by default with one objective only", True
    )
    group: bool = _switch("learn the parameters of each condition together")


@dataclass(frozen=True, kw_only=True)
class Cmaes:
    """Options of `cmaes`, covariance matrix adaptation."""

    sigma0: float = parameter(
        1.0 / 6.0, unit="-", low=1e-3, high=1.0, doc="first spread, share of every range"
    )
    n_startup_trials: int = _candidates(1, RANDOM_FIRST, low=0)
    popsize: int = _candidates(0, "candidates a generation, a batch by default", 3)
    use_separable_cma: bool = _switch("parameters on their own, for many of them")
    with_margin: bool = _switch("whole numbers and steps never freeze")
    lr_adapt: bool = _switch("learn slower on noisy objectives")


@dataclass(frozen=True, kw_only=True)
class Gp:
    """Options of `gp`, Gaussian processes."""

    n_startup_trials: int = _candidates(10, RANDOM_FIRST)
    deterministic_objective: bool = _switch("take the objective to be free of noise")


@dataclass(frozen=True, kw_only=True)
class Nsga2:
    """Options of `nsga2`, a genetic search for Pareto fronts."""

    population_size: int = _candidates(16, "candidates a generation, two batches by default", low=2)
    mutation_prob: float = _probability(0.1, "of each parameter, 1 / parameters by default")
    crossover_prob: float = _probability(0.9, "that a child has two parents")
    swapping_prob: float = _probability(0.5, "that a parameter is the second parent's")


@dataclass(frozen=True, kw_only=True)
class Nsga3(Nsga2):
    """Options of `nsga3`, for three objectives and more."""

    dividing_parameter: int = _candidates(3, "density of the reference points")


@dataclass(frozen=True, kw_only=True)
class Qmc:
    """Options of `qmc`, a low-discrepancy sequence."""

    qmc_type: Literal["sobol", "halton"] = parameter("sobol", unit="-", doc="the sequence")
    scramble: bool = _switch("shuffle the sequence by the study's seed", True)


SAMPLERS: Mapping[str, type] = {
    "tpe": Tpe,
    "cmaes": Cmaes,
    "gp": Gp,
    "nsga2": Nsga2,
    "nsga3": Nsga3,
    "qmc": Qmc,
    "random": Random,
}
DEFAULT = "tpe"


def read_sampler(node: Node | None) -> tuple[str, dict[str, Value]]:
    """Name and given options of a sampler, `tpe` or `{type: tpe, n_startup_trials: 20}`.

    Raises:
        FileError: If there is no such sampler or option, or an option is out of range.
    """
    if node is None:
        return DEFAULT, {}
    name = node.mapping.get("type", node)
    if not isinstance(name.value, str) or name.value not in SAMPLERS:
        message = f"sampler: found {name.found()}{suggestion(str(name.value), SAMPLERS)}"
        if node.mapping and name is node:
            message = f"sampler: `type:` is missing, one of {', '.join(SAMPLERS)}"
        raise FileError([name.problem(message)])
    if not node.mapping:
        return name.value, {}
    options: object = build(SAMPLERS[name.value], node)
    return name.value, {key: getattr(options, key) for key in node.mapping if key != "type"}


def misfits(
    node: Node, sampler: str, search: Sequence[Numbers | Choices], objectives: Sequence[Objective]
) -> Iterator[Problem]:
    """Why a sampler cannot search this space for these objectives.

    Args:
        node: What the message is about.
        sampler: Its name.
        search: The space; empty if it was not read.
        objectives: What is better; empty if they were not read.
    """
    if sampler != "cmaes":
        return
    others = "; use tpe, gp, nsga2, nsga3, qmc or random"
    if len(objectives) > 1:
        message = f"sampler: cmaes takes one objective, found {len(objectives)}{others}"
        yield node.problem(message)
    choices = [item.path for item in search if isinstance(item, Choices)]
    if choices:
        message = f"sampler: cmaes searches numbers, {', '.join(choices)} would be drawn at random"
        yield node.problem(f"{message}{others}")
    bound = [item.path for item in search if isinstance(item, Numbers) and item.when]
    if bound:
        message = f"sampler: cmaes knows no `when`, {', '.join(bound)} would be drawn at random"
        yield node.problem(f"{message}{others}")
    if len(search) == 1 and not choices:
        yield node.problem(f"sampler: cmaes needs two numbers at least, found one{others}")
