"""What a study asks for, so that a search never goes on with another one's candidates."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import asdict

from gaitlab.canonical import canonical_json
from gaitlab.experiment import Experiment
from gaitlab.experiment.study import Aggregate, Choices, Constraint, Numbers, Objective, Study

SHORT = 16  # hex digits of a digest


def asks_for(experiment: Experiment, basis: Mapping[str, str]) -> dict[str, str]:
    """Everything that must be the same whenever a search goes on, each as a text to be shown.

    The number of trials may change, and after how many without an improvement it ends.

    Args:
        experiment: A study.
        basis: Digest of every part that its candidates start from.
    """
    study = experiment.study
    if study is None:
        raise ValueError(f"{experiment.name} is no study")
    seeds = list(experiment.seeds)
    return {
        **dict(_of_study(study)),
        "seeds": f"{len(seeds)} from {min(seeds)} to {max(seeds)} ({_digest(seeds)})",
        **{f"digest of {part}": text for part, text in basis.items()},
    }


def _of_study(study: Study) -> Iterator[tuple[str, str]]:
    options = canonical_json(dict(study.sampler_options)) if study.sampler_options else ""
    yield "sampler", f"{study.sampler} {options}".strip()
    yield "study.seed", str(study.seed)
    yield "study.batch", str(study.batch)
    for item in study.search:
        yield f"search {item.path}", _space(item)
    yield "objectives", "; ".join(map(_objective, study.objectives))
    yield "constraints", "; ".join(map(_constraint, study.constraints)) or "none"
    racing = study.racing
    rounds = f"{list(racing.rounds)}, confidence {racing.confidence:g}" if racing else "off"
    yield "racing", rounds


def _space(item: Numbers | Choices) -> str:
    given = {name: value for name, value in asdict(item).items() if value not in (None, False)}
    given.pop("path")
    return ", ".join(f"{name} {value}" for name, value in given.items())


def _objective(item: Objective) -> str:
    return f"{item.direction} {item.metric}{_how(item)}"


def _constraint(item: Constraint) -> str:
    return f"{item.text}{_how(item)}"


def _how(item: Objective | Constraint) -> str:
    fallen = "" if item.fallen is None else f", a fall counts as {item.fallen:g}"
    seeds, grounds = _aggregate(item.over_seeds), _aggregate(item.over_surfaces)
    return f" ({seeds} of seeds, {grounds} of grounds{fallen})"


def _aggregate(item: Aggregate) -> str:
    return item.kind if item.kind in ("mean", "worst") else f"{item.kind} {item.share:g}"


def _digest(content: object) -> str:
    return hashlib.sha256(canonical_json(content).encode()).hexdigest()[:SHORT]
