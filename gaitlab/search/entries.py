"""What one candidate is in the database, there and back."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import inf, isfinite
from typing import cast

from optuna.trial import FrozenTrial

from gaitlab.experiment import Value
from gaitlab.experiment.study import Study
from gaitlab.search.asking import Told
from gaitlab.search.candidates import Candidate, State
from gaitlab.search.space import in_order

BATCH, ASKED_BY, OWNER, RESULT = "batch", "asked by", "owner", "result"  # attributes of a trial


@dataclass(frozen=True, kw_only=True)
class Pending:
    """A candidate under way.

    Attributes:
        number: Position in the order of the search.
        values: By dotted path.
        batch: Number of candidates before those proposed together with it.
        asked_by: Coordinator that proposed it.
        owner: Coordinator that walks it.
    """

    number: int
    values: Mapping[str, Value]
    batch: int
    asked_by: str
    owner: str


def pending_of(study: Study, trial: FrozenTrial) -> Pending:
    """A candidate under way."""
    return Pending(
        number=trial.number,
        values=in_order(study, trial.params),
        batch=int(trial.user_attrs[BATCH]),
        asked_by=str(trial.user_attrs[ASKED_BY]),
        owner=str(trial.user_attrs[OWNER]),
    )


def told_of(study: Study, trial: FrozenTrial) -> Told:
    """A candidate as a sampler is told of it."""
    candidate = candidate_of(study, trial)
    return Told(
        values=candidate.values,
        objectives=candidate.objectives,
        violations=candidate.violations,
        notes={k: v for k, v in trial.system_attrs.items() if not k.startswith("constraints")},
    )


def result_of(candidate: Candidate) -> dict[str, object]:
    """What there is to know, as JSON that a browser reads too: it knows no infinity."""
    return {
        "state": candidate.state,
        "reason": candidate.reason,
        "seeds": candidate.seeds,
        "simulated seconds": candidate.simulated,
        "objectives": [value if isfinite(value) else None for value in candidate.objectives],
        "violations": list(candidate.violations),
        "trials": list(candidate.trial_ids),
    }


def candidate_of(study: Study, trial: FrozenTrial) -> Candidate:
    """A candidate that was told."""
    result = trial.user_attrs[RESULT]
    violations = tuple(float(violation) for violation in result["violations"])
    state = cast(State, result["state"])
    return Candidate(
        number=trial.number,
        values=in_order(study, trial.params),
        state=state,
        objectives=tuple(
            _bad(objective.direction) if value is None else float(value)
            for objective, value in zip(study.objectives, result["objectives"], strict=True)
        ),
        violations=violations,
        feasible=state != "infeasible" and all(violation <= 0.0 for violation in violations),
        seeds=int(result["seeds"]),
        trial_ids=tuple(result["trials"]),
        batch=int(trial.user_attrs[BATCH]),
        simulated=float(result["simulated seconds"]),
        reason=str(result["reason"]),
    )


def _bad(direction: str) -> float:
    return -inf if direction == "maximize" else inf
