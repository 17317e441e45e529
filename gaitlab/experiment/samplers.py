"""The samplers that a study can ask for by name: their options, and what each can search.

A sampler is one class here, entered in `SAMPLERS`. Names and meanings of the options are Optuna's;
its version 5 was asked what it refuses and what it quietly replaces by random values.

References:
    Optuna: Akiba et al., Optuna: a next-generation hyperparameter optimization framework, KDD
        2019; samplers of version 5.0.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, Literal

from gaitlab.documents import Node, build
from gaitlab.errors import FileError, Problem
from gaitlab.experiment.parts import Value
from gaitlab.experiment.study import Choices, Numbers, Objective, Study
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
SMALLEST_POPULATION = 4  # of an evolution strategy that still learns a direction


@dataclass(frozen=True, kw_only=True)
class Sampler:
    """Options of a sampler.

    Attributes:
        optuna: What Optuna calls it; empty for one that gaitlab draws itself.
        constrained: Whether it knows constraints; the others see a missed one as a bad value.
        module: Library that it needs beside Optuna and gaitlab does not install; empty for none.
    """

    optuna: ClassVar[str] = ""
    constrained: ClassVar[bool] = False
    module: ClassVar[str] = ""

    @staticmethod
    def usual(study: Study) -> dict[str, Value]:
        """Arguments that hang on the study, unless its file gives them."""
        del study
        return {}


@dataclass(frozen=True, kw_only=True)
class Random(Sampler):
    """Options of `random`."""

    optuna: ClassVar[str] = "RandomSampler"


@dataclass(frozen=True, kw_only=True)
class Tpe(Sampler):
    """Options of `tpe`, the tree-structured Parzen estimator."""

    optuna: ClassVar[str] = "TPESampler"
    constrained: ClassVar[bool] = True
    n_startup_trials: int = _candidates(10, RANDOM_FIRST, low=0)
    n_ei_candidates: int = _candidates(24, "draws of which the most promising is proposed")
    multivariate: bool = _switch(
        "learn parameters together and not one by one; by default with one objective only", True
    )
    group: bool = _switch("learn the parameters of each condition together")

    @staticmethod
    def usual(study: Study) -> dict[str, Value]:
        """Conditions ask for groups."""
        conditional = any(item.when is not None for item in study.search)
        return {"multivariate": True, "group": True} if conditional else {}


@dataclass(frozen=True, kw_only=True)
class Cmaes(Sampler):
    """Options of `cmaes`, covariance matrix adaptation."""

    optuna: ClassVar[str] = "CmaEsSampler"
    sigma0: float = parameter(
        1.0 / 6.0, unit="-", low=1e-3, high=1.0, doc="first spread, share of every range"
    )
    n_startup_trials: int = _candidates(1, RANDOM_FIRST, low=0)
    popsize: int = _candidates(0, "candidates a generation, a batch by default", 3)
    use_separable_cma: bool = _switch("parameters on their own, for many of them")
    with_margin: bool = _switch("whole numbers and steps never freeze")
    lr_adapt: bool = _switch("learn slower on noisy objectives")

    @staticmethod
    def usual(study: Study) -> dict[str, Value]:
        """A generation is a batch, so that no candidate is wasted."""
        population = max(study.batch, SMALLEST_POPULATION)
        return {"popsize": population, "warn_independent_sampling": False}


@dataclass(frozen=True, kw_only=True)
class Gp(Sampler):
    """Options of `gp`, Gaussian processes."""

    optuna: ClassVar[str] = "GPSampler"
    constrained: ClassVar[bool] = True
    module: ClassVar[str] = "torch"
    n_startup_trials: int = _candidates(10, RANDOM_FIRST)
    deterministic_objective: bool = _switch("take the objective to be free of noise")

    @staticmethod
    def usual(study: Study) -> dict[str, Value]:
        """A parameter under a condition is drawn at random, which needs no warning."""
        return {"warn_independent_sampling": False}


@dataclass(frozen=True, kw_only=True)
class Nsga2(Sampler):
    """Options of `nsga2`, a genetic search for Pareto fronts."""

    optuna: ClassVar[str] = "NSGAIISampler"
    constrained: ClassVar[bool] = True
    population_size: int = _candidates(16, "candidates a generation, two batches by default", low=2)
    mutation_prob: float = _probability(0.1, "of each parameter, 1 / parameters by default")
    crossover_prob: float = _probability(0.9, "that a child has two parents")
    swapping_prob: float = _probability(0.5, "that a parameter is the second parent's")

    @staticmethod
    def usual(study: Study) -> dict[str, Value]:
        """Two batches: small enough for several generations of a hundred candidates."""
        return {"population_size": max(2 * study.batch, SMALLEST_POPULATION)}


@dataclass(frozen=True, kw_only=True)
class Nsga3(Nsga2):
    """Options of `nsga3`, for three objectives and more."""

    optuna: ClassVar[str] = "NSGAIIISampler"
    dividing_parameter: int = _candidates(3, "density of the reference points")


@dataclass(frozen=True, kw_only=True)
class Qmc(Sampler):
    """Options of `qmc`, a low-discrepancy sequence."""

    qmc_type: Literal["sobol", "halton"] = parameter("sobol", unit="-", doc="the sequence")
    scramble: bool = _switch("shuffle the sequence by the study's seed", True)


SAMPLERS: Mapping[str, type[Sampler]] = {
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
