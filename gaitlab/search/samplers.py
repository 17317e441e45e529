"""The samplers that a study names.

Each is made anew for every batch, from a seed that only hangs on the study's seed and on how many
candidates were told before. Whatever a sampler must remember beyond that (the state of CMA-ES, the
generation of NSGA) stands in the candidates' own notes, so a search that was killed goes on as if
nothing had happened.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from importlib.util import find_spec
from typing import Any, TypeAlias

import numpy as np
from optuna.samplers import (
    BaseSampler,
    CmaEsSampler,
    GPSampler,
    NSGAIIISampler,
    NSGAIISampler,
    RandomSampler,
    TPESampler,
)

from gaitlab.errors import UsageError, WrongValue
from gaitlab.experiment.study import Study

Options: TypeAlias = Mapping[str, Any]  # of whatever type the option of Optuna's has
SMALLEST_POPULATION = 4  # of an evolution strategy that still learns a direction
NOTES = ("cma", "sepcma", "cmawm", "x_for_tell", "NSGA")  # starts of what samplers keep
CONSTRAINED = ("tpe", "gp", "nsga2", "nsga3")  # the others see a missed constraint as a bad value


def seed_of(study: Study, told: int, salt: int = 0) -> int:
    """Seed of the batch that starts after this many candidates."""
    parts = [study.seed, told, *([salt] if salt else [])]
    return int(np.random.SeedSequence(parts).generate_state(1)[0])


def sampler(study: Study, seed: int) -> BaseSampler:
    """The sampler of a study for one batch.

    Raises:
        UsageError: If its library is not installed.
        WrongValue: If its options do not go together.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # Optuna calls some of its options experimental
        try:
            return _MAKERS[study.sampler](study, seed, study.sampler_options)
        except ValueError as error:
            raise WrongValue(f"sampler {study.sampler}: {error}; change its options") from error


def _tpe(study: Study, seed: int, options: Options) -> BaseSampler:
    conditional = any(item.when is not None for item in study.search)
    grouped: Options = {"multivariate": True, "group": True} if conditional else {}
    return TPESampler(seed=seed, **{**grouped, **options})


def _cmaes(study: Study, seed: int, options: Options) -> BaseSampler:
    """A generation is a batch, so that no candidate is wasted."""
    population = max(study.batch, SMALLEST_POPULATION)
    given = {"popsize": population, **options}
    return CmaEsSampler(seed=seed, warn_independent_sampling=False, **given)


def _gp(study: Study, seed: int, options: Options) -> BaseSampler:
    if find_spec("torch") is None:
        raise UsageError(
            "sampler gp needs torch, which is not installed: `pip install 'gaitlab[gp]'`, or "
            "choose another sampler, `--set study.sampler=tpe` for instance"
        )
    return GPSampler(seed=seed, warn_independent_sampling=False, **options)


def _population(study: Study) -> int:
    """Two batches: small enough for several generations of a hundred candidates."""
    return max(2 * study.batch, SMALLEST_POPULATION)


def _nsga2(study: Study, seed: int, options: Options) -> BaseSampler:
    return NSGAIISampler(seed=seed, **{"population_size": _population(study), **options})


def _nsga3(study: Study, seed: int, options: Options) -> BaseSampler:
    return NSGAIIISampler(seed=seed, **{"population_size": _population(study), **options})


def _random(study: Study, seed: int, options: Options) -> BaseSampler:
    return RandomSampler(seed=seed)


_MAKERS: Mapping[str, Callable[[Study, int, Options], BaseSampler]] = {
    "tpe": _tpe,
    "cmaes": _cmaes,
    "gp": _gp,
    "nsga2": _nsga2,
    "nsga3": _nsga3,
    "random": _random,
}
