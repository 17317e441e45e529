"""What to try next: a pure function of the study and of what it was told."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import repeat
from math import isfinite
from typing import TypeAlias

import numpy as np
import optuna
from optuna.trial import FrozenTrial, TrialState, create_trial

from gaitlab.experiment import Value
from gaitlab.experiment.study import Objective, Study
from gaitlab.search.objectives import violation_names
from gaitlab.search.samplers import CONSTRAINED, NOTES, sampler, seed_of
from gaitlab.search.space import at, distributions, key, suggested

Note: TypeAlias = bool | int | float | str | list[float] | None
ATTEMPTS = 30  # proposals of a sampler that may all have been tried before
DRAWS = 1000  # uniform ones after that; the space is then taken for exhausted
QMC_PLACE = "qmc:place"  # note: position in the sequence


@dataclass(frozen=True, kw_only=True)
class Told:
    """What a sampler is told of a candidate.

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
    told: Sequence[Told],
    *,
    first: Mapping[str, Value] | None = None,
    running: Sequence[Mapping[str, Value]] = (),
    salt: int = 0,
) -> tuple[Proposal, ...]:
    """The next batch.

    Args:
        study: What is searched.
        told: Every candidate of the batches before, in their order.
        first: Values to try before any others.
        running: Candidates that other coordinators are trying.
        salt: Tells coordinators apart that share a search.

    Returns:
        As many as a batch has, or fewer if the space holds no more; none was told before.
    """
    seen = {key(each.values) for each in told} | {key(values) for values in running}
    proposals = []
    if first is not None and key(first) not in seen:
        proposals.append(Proposal(values=first))
        seen.add(key(first))
    for proposal in _stream(study, told, [*running, *(p.values for p in proposals)], salt):
        if len(proposals) == study.batch:
            break
        if key(proposal.values) not in seen:
            seen.add(key(proposal.values))
            proposals.append(proposal)
    return tuple(proposals[: study.batch])


def _stream(
    study: Study, told: Sequence[Told], running: Sequence[Mapping[str, Value]], salt: int
) -> Iterator[Proposal]:
    """Proposals without an end to speak of, repetitions among them."""
    if study.sampler == "qmc":
        yield from _sequence(study, told)
    else:
        yield from _sampled(study, told, running, salt)
    generator = np.random.default_rng(seed_of(study, len(told), salt + 1))
    for _ in range(DRAWS):
        yield Proposal(values=at(study, generator.random(len(study.search))))


def _sequence(study: Study, told: Sequence[Told]) -> Iterator[Proposal]:
    """The next points of a low-discrepancy sequence, the same one over the whole search."""
    from scipy.stats import qmc

    options = dict(study.sampler_options)
    engines = {"sobol": qmc.Sobol, "halton": qmc.Halton}
    engine = engines[str(options.get("qmc_type", "sobol"))](
        len(study.search), scramble=bool(options.get("scramble", True)), rng=study.seed
    )
    noted = [place for each in told if isinstance(place := each.notes.get(QMC_PLACE), int)]
    place = max(noted, default=-1) + 1
    if place:
        engine.fast_forward(place)
    for number in range(place, place + study.batch + ATTEMPTS):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # it wants a power of two at once, and gets it in time
            found = engine.random(1)[0]
        yield Proposal(values=at(study, found), notes={QMC_PLACE: number})


def _sampled(
    study: Study, told: Sequence[Told], running: Sequence[Mapping[str, Value]], salt: int
) -> Iterator[Proposal]:
    memory = _memory(study, told, running, seed_of(study, len(told), salt))
    for _ in range(study.batch + ATTEMPTS):
        with _quiet():
            trial = memory.ask()
            values = suggested(study, trial)
            notes = memory.get_trials(deepcopy=False)[trial.number].system_attrs
        yield Proposal(values=values, notes=_kept(notes))


def _kept(notes: Mapping[str, Note]) -> dict[str, Note]:
    return {name: note for name, note in notes.items() if name.startswith(NOTES)}


def _memory(
    study: Study, told: Sequence[Told], running: Sequence[Mapping[str, Value]], seed: int
) -> optuna.Study:
    """A study in memory that knows what was told and nothing else."""
    with _quiet():
        memory = optuna.create_study(
            sampler=sampler(study, seed),
            directions=[objective.direction for objective in study.objectives],
        )
        memory.add_trials(_finished(study, told))
        memory.add_trials([_under_way(study, values) for values in running])
    return memory


def _finished(study: Study, told: Sequence[Told]) -> list[FrozenTrial]:
    worst = [
        _worst(objective, [each.objectives[i] for each in told])
        for i, objective in enumerate(study.objectives)
    ]
    return [_told_trial(study, each, worst) for each in told]


def _told_trial(study: Study, each: Told, worst: Sequence[float]) -> FrozenTrial:
    constrained = study.sampler in CONSTRAINED
    missed = sum(max(0.0, violation) for violation in each.violations)
    if missed and not constrained:
        values = list(map(_worsened, study.objectives, worst, repeat(missed)))
    else:
        values = [v if isfinite(v) else w for v, w in zip(each.objectives, worst, strict=True)]
    named = dict(zip(violation_names(study), each.violations, strict=True))
    return create_trial(
        params=dict(each.values),
        distributions=distributions(study, each.values),
        values=values,
        system_attrs=dict(each.notes),
        constraints=named if constrained else None,
    )


def _worst(objective: Objective, values: Sequence[float]) -> float:
    pick = min if objective.direction == "maximize" else max
    return pick(filter(isfinite, values), default=0.0)


def _worsened(objective: Objective, worst: float, missed: float) -> float:
    """A value worse than any that was seen, the more so the more is missed."""
    amount = (1.0 + missed) * max(1.0, abs(worst))
    return worst - amount if objective.direction == "maximize" else worst + amount


def _under_way(study: Study, values: Mapping[str, Value]) -> FrozenTrial:
    return create_trial(
        state=TrialState.RUNNING,
        params=dict(values),
        distributions=distributions(study, values),
    )


@contextmanager
def _quiet() -> Iterator[None]:
    """Without Optuna's notes to its own users."""
    before = optuna.logging.get_verbosity()
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        optuna.logging.set_verbosity(before)
