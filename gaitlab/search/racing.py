"""When a candidate is given up before it has walked with every seed.

All candidates walk with the same seeds, so two of them are compared seed by seed, as in
[Birattari2002]. A candidate is given up for certain, when nothing that its remaining seeds may
bring can help it, or with the confidence that the study asks for. Everything here is a pure
function of trials that are there, whatever order they ended in, so a search does not depend on
timing.

References:
    Wilcoxon1945: Wilcoxon, Individual comparisons by ranking methods, Biometrics Bulletin 1(6),
        1945.
    Student1908: Student, The probable error of a mean, Biometrika 6(1), 1908.
    Birattari2002: Birattari et al., A racing algorithm for configuring metaheuristics, GECCO 2002.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite, sqrt

from gaitlab.experiment.study import Constraint, Objective, Racing, Study
from gaitlab.search.candidates import costs, unbeaten
from gaitlab.search.objectives import TrialOutcome, counted, evaluate, score

Place = tuple[str, int]  # surface and seed
LEAST, MOST = -1e12, 1e12  # stand for the unbounded ends of a metric
SHARES = ("stable", "stable_strict", "fell", "stalled", "on_gantry", "pitch_settled")  # 0 or 1


@dataclass(frozen=True, kw_only=True)
class Rival:
    """A candidate to compare with.

    Attributes:
        number: Which one.
        outcomes: Its trials.
    """

    number: int
    outcomes: Sequence[TrialOutcome]


def hopeless(
    study: Study, outcomes: Sequence[TrialOutcome], places: Sequence[Place], rivals: Sequence[Rival]
) -> str:
    """Why a candidate is given up; empty if it is not.

    Args:
        study: What is searched.
        outcomes: Its trials so far.
        places: Surface and seed of every trial that it would have in the end.
        rivals: Candidates that break no constraint, and that walked on the same places at least:
            the best one, or with several objectives the front.
    """
    reason = _lost(outcomes) or _forbidden(study, outcomes, places)
    racing = study.racing
    if reason or racing is None:
        return reason
    for rival in rivals:
        beaten = [_beaten(o, racing, outcomes, places, rival) for o in study.objectives]
        if all(beaten):
            return f"{beaten[0]} than candidate {rival.number}"
    return ""


def _lost(outcomes: Sequence[TrialOutcome]) -> str:
    lost = next((outcome for outcome in outcomes if not outcome.walked), None)
    return f"{lost.state} on {lost.surface} with seed {lost.seed}" if lost else ""


def _forbidden(study: Study, outcomes: Sequence[TrialOutcome], places: Sequence[Place]) -> str:
    """A constraint that no remaining seed can save, or an objective without a value for good."""
    for objective in study.objectives:
        if not isfinite(score(objective, outcomes)) and not isfinite(
            reachable(objective, outcomes, places)
        ):
            return f"{objective.metric} has no value any more"
    if study.racing is None:
        return ""
    for constraint in study.constraints:
        if _out_of_reach(constraint, reachable(constraint, outcomes, places)):
            return f"{constraint.text} is out of reach"
    return ""


def _out_of_reach(constraint: Constraint, value: float) -> bool:
    return value < constraint.bound if constraint.at_least else value > constraint.bound


def reachable(
    wanted: Objective | Constraint, outcomes: Sequence[TrialOutcome], places: Sequence[Place]
) -> float:
    """The best that an objective or a constrained metric can become with the seeds that are left.

    Nothing is assumed of a metric but that a share lies between 0 and 1.
    """
    walked = {(outcome.surface, outcome.seed) for outcome in outcomes}
    best = _best(wanted)
    ideal = [
        TrialOutcome(surface=surface, seed=seed, state="DONE", metrics={wanted.metric: best})
        for surface, seed in places
        if (surface, seed) not in walked
    ]
    return score(wanted, [*outcomes, *ideal])


def _best(wanted: Objective | Constraint) -> float:
    share = wanted.metric in SHARES or wanted.metric.endswith("_share")
    if wanted.direction == "maximize":
        return 1.0 if share else MOST
    return 0.0 if share else LEAST


def _beaten(
    objective: Objective,
    racing: Racing,
    outcomes: Sequence[TrialOutcome],
    places: Sequence[Place],
    rival: Rival,
) -> str:
    """How a candidate is worse than a rival: certainly or probably; empty if neither is sure."""
    goal, best = score(objective, rival.outcomes), reachable(objective, outcomes, places)
    sign = 1.0 if objective.direction == "maximize" else -1.0
    if len(rival.outcomes) == len(places) and sign * best < sign * goal:
        return f"{objective.metric} is certainly worse"
    doubt = 1.0 - racing.confidence
    if objective.over_surfaces.kind == "mean":
        pairs = _pairs(objective, outcomes, rival.outcomes)
        return f"{objective.metric} is probably worse" if _worse(pairs, doubt) else ""
    surfaces = {outcome.surface for outcome in outcomes}
    for surface in sorted(surfaces):
        here = [outcome for outcome in outcomes if outcome.surface == surface]
        # Who is worse on one ground than the rival on its worst is worse on his own worst.
        pairs = _pairs(objective, here, _worst_ground(objective, rival.outcomes))
        if _worse(pairs, doubt / len(surfaces)):
            return f"{objective.metric} on {surface} is probably worse"
    return ""


def _worst_ground(objective: Objective, outcomes: Sequence[TrialOutcome]) -> list[TrialOutcome]:
    """A rival's trials on the ground that decides its worst value."""
    grounds: dict[str, list[TrialOutcome]] = {}
    for outcome in outcomes:
        grounds.setdefault(outcome.surface, []).append(outcome)
    sign = 1.0 if objective.direction == "maximize" else -1.0
    return min(grounds.values(), key=lambda trials: sign * score(objective, trials))


def _pairs(
    objective: Objective, outcomes: Sequence[TrialOutcome], others: Sequence[TrialOutcome]
) -> list[float]:
    """Candidate minus rival of each shared seed, in the direction that is better."""
    sign = 1.0 if objective.direction == "maximize" else -1.0
    by_place = {(o.surface, o.seed): counted(objective, o) for o in others}
    single = len({surface for surface, _ in by_place}) == 1
    by_seed = {seed: value for (_, seed), value in by_place.items()} if single else {}
    pairs = []
    for outcome in outcomes:
        other = by_place.get((outcome.surface, outcome.seed), by_seed.get(outcome.seed))
        if other is not None:
            value = min(MOST, max(LEAST, counted(objective, outcome)))
            pairs.append(sign * (value - min(MOST, max(LEAST, other))))
    return pairs


def _worse(pairs: Sequence[float], doubt: float) -> bool:
    """Whether the pairs show a difference below zero: their ranks, or of few pairs their mean.

    [Wilcoxon1945] as soon as ranks can be that sure, for n pairs at best 1 in 2^n, else
    [Student1908]. Pairs that all agree to the last digit, as falls do, have no scatter: two are
    enough.
    """
    if len(pairs) < 2 or sum(pairs) >= 0.0:
        return False
    from scipy.stats import t, wilcoxon

    different = [pair for pair in pairs if pair]
    if 0.5 ** len(different) <= doubt:
        return bool(wilcoxon(different, alternative="less").pvalue <= doubt)
    n = len(pairs)
    mean = sum(pairs) / n
    scatter = sqrt(sum((pair - mean) ** 2 for pair in pairs) / (n - 1))
    return scatter == 0.0 or bool(t.cdf(mean / (scatter / sqrt(n)), n - 1) <= doubt)


def best_of(study: Study, rivals: Sequence[Rival]) -> tuple[Rival, ...]:
    """The rival, or with several objectives the rivals, that nobody who may win beats."""
    rated = []
    for rival in rivals:
        evaluation = evaluate(study, rival.outcomes)
        if evaluation.feasible:
            rated.append((costs(study, evaluation.objectives), rival))
    return unbeaten(sorted(rated, key=lambda pair: (pair[0], pair[1].number)))
