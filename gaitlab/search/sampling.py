"""What to try next: a pure function of the study and of what is known of its candidates.

A sampler is made anew for every batch, from a seed that only hangs on the study's seed and on how
many candidates are finished. Whatever it must remember beyond that (the state of CMA-ES, the
generation of NSGA) stands in the candidates' own notes, so a search that was killed goes on as if
nothing had happened.

References:
    Watanabe2023: Watanabe et al., PED-ANOVA: Efficiently Quantifying Hyperparameter Importance in
        Arbitrary Subspaces, IJCAI 2023.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from importlib.util import find_spec
from math import isfinite
from typing import TypeAlias

import numpy as np
import optuna
from optuna.importance import PedAnovaImportanceEvaluator, get_param_importances
from optuna.samplers import BaseSampler
from optuna.trial import FrozenTrial, TrialState, create_trial

from gaitlab.errors import UsageError, WrongValue
from gaitlab.experiment import Value
from gaitlab.experiment.samplers import SAMPLERS
from gaitlab.experiment.study import Objective, Study
from gaitlab.search.candidates import History
from gaitlab.search.objectives import violation_names
from gaitlab.search.space import at, distributions, key, suggested

Note: TypeAlias = bool | int | float | str | list[float] | None
ATTEMPTS = 30  # proposals of a sampler that may all have been tried before
DRAWS = 1000  # uniform ones after that; the space is then taken for exhausted
QMC_PLACE = "qmc:place"  # note: position in the sequence
NOTES = ("cma", "sepcma", "cmawm", "x_for_tell", "NSGA")  # starts of what samplers keep
FEWEST = 10  # candidates; of fewer the best tenth is one


@dataclass(frozen=True, kw_only=True)
class Observation:
    """What a sampler knows of a finished candidate.

    Attributes:
        values: By dotted path.
        objectives: In the order of the file; infinite if there is no value.
        violations: As in `gaitlab.search.objectives.Evaluation`.
        notes: What the sampler noted when it proposed it.
    """

    values: Mapping[str, Value]
    objectives: tuple[float, ...]
    violations: tuple[float, ...]
    notes: Mapping[str, Note] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class Proposal:
    """A candidate to try.

    Attributes:
        values: By dotted path.
        notes: What the sampler wants to know of it again.
    """

    values: Mapping[str, Value]
    notes: Mapping[str, Note] = field(default_factory=dict)


def ask(
    study: Study,
    observations: Sequence[Observation],
    *,
    first: Mapping[str, Value] | None = None,
    running: Sequence[Mapping[str, Value]] = (),
    salt: int = 0,
) -> tuple[Proposal, ...]:
    """The next batch.

    Args:
        study: What is searched.
        observations: Every candidate of the batches before, in their order.
        first: Values to try before any others.
        running: Candidates that other processes are trying.
        salt: Tells processes apart that share a search.

    Returns:
        As many as a batch has, or fewer if the space holds no more; none was tried before.
    """
    seen = {key(known.values) for known in observations} | {key(values) for values in running}
    proposals = []
    if first is not None and key(first) not in seen:
        proposals.append(Proposal(values=first))
        seen.add(key(first))
    under_way = [*running, *(proposal.values for proposal in proposals)]
    for proposal in _stream(study, observations, under_way, salt):
        if len(proposals) == study.batch:
            break
        if key(proposal.values) not in seen:
            seen.add(key(proposal.values))
            proposals.append(proposal)
    return tuple(proposals[: study.batch])


def _stream(
    study: Study,
    observations: Sequence[Observation],
    running: Sequence[Mapping[str, Value]],
    salt: int,
) -> Iterator[Proposal]:
    """Proposals without an end to speak of, repetitions among them."""
    if study.sampler == "qmc":
        yield from _sequence(study, observations)
    else:
        seed = _seed(study, len(observations), salt)
        yield from _sampled(study, observations, running, seed)
    generator = np.random.default_rng(_seed(study, len(observations), salt + 1))
    for _ in range(DRAWS):
        yield Proposal(values=at(study, generator.random(len(study.search))))


def _seed(study: Study, finished: int, salt: int) -> int:
    """Seed of the batch that starts after this many candidates."""
    parts = [study.seed, finished, *([salt] if salt else [])]
    return int(np.random.SeedSequence(parts).generate_state(1)[0])


def _sequence(study: Study, observations: Sequence[Observation]) -> Iterator[Proposal]:
    """The next points of a low-discrepancy sequence, the same one over the whole search."""
    from scipy.stats import qmc

    options = dict(study.sampler_options)
    engines = {"sobol": qmc.Sobol, "halton": qmc.Halton}
    engine = engines[str(options.get("qmc_type", "sobol"))](
        len(study.search), scramble=bool(options.get("scramble", True)), rng=study.seed
    )
    places = [known.notes.get(QMC_PLACE) for known in observations]
    start = max((place for place in places if isinstance(place, int)), default=-1) + 1
    if start:
        engine.fast_forward(start)
    for place in range(start, start + study.batch + ATTEMPTS):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # it wants a power of two at once, and gets it in time
            point = engine.random(1)[0]
        yield Proposal(values=at(study, point), notes={QMC_PLACE: place})


def _sampled(
    study: Study,
    observations: Sequence[Observation],
    running: Sequence[Mapping[str, Value]],
    seed: int,
) -> Iterator[Proposal]:
    """What Optuna's sampler proposes, in a study in memory that knows this and nothing else."""
    with quiet():
        memory = optuna.create_study(
            sampler=_sampler(study, seed),
            directions=[objective.direction for objective in study.objectives],
        )
        memory.add_trials(_finished(study, observations))
        for values in running:
            memory.add_trial(
                create_trial(
                    state=TrialState.RUNNING,
                    params=dict(values),
                    distributions=distributions(study, values),
                )
            )
    for _ in range(study.batch + ATTEMPTS):
        with quiet():
            trial = memory.ask()
            values = suggested(study, trial)
            notes = memory.get_trials(deepcopy=False)[trial.number].system_attrs
        kept = {name: note for name, note in notes.items() if name.startswith(NOTES)}
        yield Proposal(values=values, notes=kept)


def _sampler(study: Study, seed: int) -> BaseSampler:
    """The sampler of a study for one batch.

    Raises:
        UsageError: If its library is not installed.
        WrongValue: If its options do not go together.
    """
    kind = SAMPLERS[study.sampler]
    if kind.module and find_spec(kind.module) is None:
        raise UsageError(
            f"sampler {study.sampler} needs {kind.module}, which is not installed: `pip install "
            f"'gaitlab[{study.sampler}]'`, or choose another sampler, `--set study.sampler=tpe` "
            "for instance"
        )
    make = getattr(optuna.samplers, kind.optuna)
    try:
        sampler: BaseSampler = make(seed=seed, **{**kind.usual(study), **study.sampler_options})
        return sampler
    except ValueError as error:
        raise WrongValue(f"sampler {study.sampler}: {error}; change its options") from error


def _finished(study: Study, observations: Sequence[Observation]) -> list[FrozenTrial]:
    worst = [
        _worst(objective, [known.objectives[place] for known in observations])
        for place, objective in enumerate(study.objectives)
    ]
    return [_finished_trial(study, known, worst) for known in observations]


def _finished_trial(study: Study, known: Observation, worst: Sequence[float]) -> FrozenTrial:
    constrained = SAMPLERS[study.sampler].constrained
    missed = sum(max(0.0, violation) for violation in known.violations)
    if missed and not constrained:
        pairs = zip(study.objectives, worst, strict=True)
        values = [_worsened(objective, value, missed) for objective, value in pairs]
    else:
        values = [v if isfinite(v) else w for v, w in zip(known.objectives, worst, strict=True)]
    named = dict(zip(violation_names(study), known.violations, strict=True))
    return create_trial(
        params=dict(known.values),
        distributions=distributions(study, known.values),
        values=values,
        system_attrs=dict(known.notes),
        constraints=named if constrained else None,
    )


def _worst(objective: Objective, values: Sequence[float]) -> float:
    pick = min if objective.direction == "maximize" else max
    return pick(filter(isfinite, values), default=0.0)


def _worsened(objective: Objective, worst: float, missed: float) -> float:
    """A value worse than any that was seen, the more so the more is missed."""
    amount = (1.0 + missed) * max(1.0, abs(worst))
    return worst - amount if objective.direction == "maximize" else worst + amount


def importance(history: History, place: int = 0) -> Mapping[str, float]:
    """Share of each parameter in how the better candidates differ from all, [Watanabe2023].

    PED-ANOVA compares where the best tenth lies with where everything lies, one parameter at a
    time; it is blind to interactions, and to regions that the search left early. A candidate that
    has no value counts as bad as the worst that has one.

    Args:
        history: The search.
        place: Position of the objective.

    Returns:
        Share by dotted path, the largest first; they add up to one. Empty if there are fewer than
        ten candidates, or none is better than the others.
    """
    values = [candidate.objectives[place] for candidate in history.candidates]
    if len(values) < FEWEST or len(set(filter(isfinite, values))) < 2:
        return {}
    study, objective = history.study, history.study.objectives[place]
    worst = _worst(objective, values)
    with quiet():
        memory = optuna.create_study(direction=objective.direction)
        for candidate, value in zip(history.candidates, values, strict=True):
            trial = create_trial(
                params=dict(candidate.values),
                distributions=distributions(study, candidate.values),
                value=value if isfinite(value) else worst,
            )
            memory.add_trial(trial)
        shares = get_param_importances(memory, evaluator=PedAnovaImportanceEvaluator())
    return {path: float(share) for path, share in shares.items() if isfinite(share)}


@contextmanager
def quiet() -> Iterator[None]:
    """Without Optuna's notes to its own users, its warnings of experimental parts among them."""
    with unlogged(), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


@contextmanager
def unlogged() -> Iterator[None]:
    """Without what Optuna logs below an error."""
    before = optuna.logging.get_verbosity()
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    try:
        yield
    finally:
        optuna.logging.set_verbosity(before)
