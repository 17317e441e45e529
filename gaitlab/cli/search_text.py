"""What `gaitlab optimize` prints: the plan of a search, and its result."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import suppress
from math import isfinite

from gaitlab.cli.printing import columns, duration, number, plural, size
from gaitlab.cli.search_progress import with_unit
from gaitlab.errors import UnknownName
from gaitlab.experiment import Experiment, study_of
from gaitlab.experiment.plan import plan
from gaitlab.experiment.study import Choices, Constraint, Numbers, Study
from gaitlab.running import cost
from gaitlab.search import Candidate, History
from gaitlab.search.candidates import edges
from gaitlab.search.database import history
from gaitlab.search.objectives import misses
from gaitlab.search.search import SearchResult
from gaitlab.search.winner import objective_text
from gaitlab.store import Store

SHOWN_FRONT = 10  # candidates of a Pareto front
NEAREST = 5  # misses that are looked at
SHOWN_MISSES = 3


def plan_text(
    wanted: Experiment, results: Store, storage: str | None, jobs: int, as_json: bool
) -> str:
    """What a search takes at most, before anything walks."""
    study, planned = study_of(wanted), plan(wanted, programs=False)
    finished = 0
    with suppress(UnknownName):  # nothing was searched yet
        finished = len(history(wanted, results, storage).candidates)
    left = max(0, study.trials - finished)
    needed = cost(planned, left * planned.size, jobs)
    if as_json:
        counts = {"candidates": study.trials, "told": finished, "trials": needed.trials}
        rest = {"seconds": round(needed.seconds), "bytes": round(needed.size)}
        return json.dumps({"study": wanted.name, **counts, **rest})
    rows = [[item.path, _range(item)] for item in study.search]
    objectives = "; ".join(f"{o.direction} {o.metric}" for o in study.objectives)
    constraints = "; ".join(c.text for c in study.constraints) or "none"
    rounds = f"after {', '.join(map(str, study.racing.rounds))} seeds" if study.racing else "off"
    total = f"{plural(left, 'candidate')} to try of {study.trials}: at most "
    total += f"{plural(needed.trials, 'trial')}, {duration(needed.seconds)} and {size(needed.size)}"
    return "\n".join(
        [
            columns(("searched", "range"), rows),
            "",
            f"objectives   {objectives}",
            f"constraints  {constraints}",
            f"sampler      {study.sampler}, seed {study.seed}, batches of {study.batch}",
            f"racing       {rounds}",
            "",
            f"{total}; racing and falls make it less",
        ]
    )


def _range(item: Numbers | Choices) -> str:
    return item.text if item.when is None else f"{item.text} (when {item.when.text})"


def result_json(result: SearchResult) -> str:
    """The result as one JSON object."""
    status, history = result.status, result.history
    states = {state: status.count(state) for state in ("done", "pruned", "infeasible")}
    best = history.best
    return json.dumps(
        {
            "study": history.experiment.name,
            "ending": result.ending,
            "total": status.total,
            "told": status.finished,
            **states,
            "best": None if best is None else _candidate_json(best),
            "front": [_candidate_json(candidate) for candidate in history.front],
            "walked": status.walked,
            "cached": result.cached,
            "seconds": round(status.seconds, 3),
            "simulated_seconds": round(status.simulated, 3),
            "saving": round(history.saving, 4),
            "interrupted": result.ending == "stopped",
        }
    )


def _candidate_json(candidate: Candidate) -> dict[str, object]:
    return {
        "number": candidate.number,
        "values": dict(candidate.values),
        "objectives": [value if isfinite(value) else None for value in candidate.objectives],
        "violations": list(candidate.violations),
        "seeds": candidate.seeds,
        "trials": list(candidate.trial_ids),
    }


def result_text(result: SearchResult, again: str, report: str, why: Sequence[str] = ()) -> str:
    """The result for reading.

    Args:
        result: The search.
        again: The command line that goes on.
        report: The one that writes its page.
        why: What stood in the way where no candidate is allowed.
    """
    history = result.history
    parts = [_ending(result), *nothing_allowed(history), *why, *_winners(history)]
    parts += ["", _effort(result)]
    parts.append(f"Report: {report}" if result.over else f"Go on: {again}")
    return "\n".join(parts)


def nothing_allowed(history: History) -> list[str]:
    """Lines about a search in which no candidate is both finished and allowed."""
    candidates = history.candidates
    if not candidates or history.front:
        return []
    lines = [f"No candidate of {len(candidates)} fulfils what the study asks for."]
    reasons = Counter(c.reason for c in candidates if c.state == "infeasible")
    if reasons:
        lines.append(f"{reasons.total()} of them cannot be walked at all; the commonest reason:")
        lines.append(f"  {reasons.most_common(1)[0][0]}")
    lines.append("Nearest misses, in brackets by how much, 1 being the size of the bound:")
    for candidate in history.nearest_misses(SHOWN_MISSES):
        values = ", ".join(f"{path} = {number(value)}" for path, value in candidate.values.items())
        broken = misses(history.study, candidate.objectives, candidate.violations)
        lines.append(f"  candidate {candidate.number}: {values}")
        lines.append(f"    misses {'; '.join(broken)}")
    return [*lines, *_widen(history.study, history.nearest_misses(NEAREST))]


def _widen(study: Study, nearest: Sequence[Candidate]) -> Iterator[str]:
    if not nearest or nearest[0].missed_by == 0.0:
        return
    ends = Counter(end for candidate in nearest for end in edges(study, candidate).items())
    if not ends:
        relax = "relax a constraint, or " if study.constraints else ""
        yield f"None of them lies at an end of a range: {relax}search another one."
    for (path, end), count in ends.most_common(SHOWN_MISSES):
        yield f"Widen {path}: {count} of the {len(nearest)} nearest lie at its {end}."


def _ending(result: SearchResult) -> str:
    status = result.status
    states = ", ".join(f"{status.count(s)} {s}" for s in ("done", "pruned", "infeasible"))
    finished = f"{status.finished} of {plural(status.total, 'candidate')} finished: {states}."
    why = {
        "complete": "",
        "stopped": " Stopped.",
        "no improvement": " Ended early: the last "
        f"{status.history.study.early_stop} brought no improvement.",
        "exhausted": " The space holds no more: every combination was tried.",
        "elsewhere": f" The rest is walked by {', '.join(result.elsewhere) or 'another machine'}.",
    }
    return finished + why[result.ending]


def _winners(history: History) -> list[str]:
    if not history.front:
        return []
    shown = history.front[:SHOWN_FRONT]
    if history.best is not None:
        head = f"\nBest: candidate {history.best.number}{_final(history)}"
        return [head, *_winner(history, history.best)]
    left = len(history.front) - len(shown)
    more = [f"... and {left} more, see the report"] if left else []
    return [f"\nFront of {plural(len(history.front), 'candidate')}:", _front(history), *more]


def _final(history: History) -> str:
    """How the final came out."""
    if not history.finals:
        return ""
    places = ", ".join(f"{c.number}: {c.objectives[0]:.4g}" for c in history.finals)
    return f" (final with {plural(history.finals[0].seeds, 'seed')}: {places})"


def _winner(history: History, best: Candidate) -> list[str]:
    study, ends = history.study, edges(history.study, best)
    grounds = ", ".join(history.experiment.parts.surfaces)
    rows = [
        [
            item.path,
            number(best.values.get(item.path)) or "-",
            _range(item),
            _warning(ends, item.path),
        ]
        for item in study.search
    ]
    return [
        f"  {objective_text(history, best, 0)}, n = {plural(best.seeds, 'seed')} on {grounds}",
        *(f"  {line}" for line in _constraints(history, best)),
        *(f"  {row}" for row in columns(("parameter", "value", "searched", ""), rows).split("\n")),
    ]


def _constraints(history: History, best: Candidate) -> list[str]:
    pairs = zip(history.study.constraints, best.violations, strict=False)
    return [f"{c.metric} {bounded(c, missed):.4g}, asked for {c.text}" for c, missed in pairs]


def _warning(ends: dict[str, str], path: str) -> str:
    return f"at the {ends[path]}: widen it" if path in ends else ""


def bounded(constraint: Constraint, violation: float) -> float:
    """What a constrained metric was, from how far it misses its bound."""
    amount = violation * (abs(constraint.bound) or 1.0)
    return constraint.bound - amount if constraint.at_least else constraint.bound + amount


def _front(history: History) -> str:
    study = history.study
    head = ["candidate", *(with_unit(o.metric) for o in study.objectives)]
    head += [item.path for item in study.search]
    rows = [
        [
            str(candidate.number),
            *(f"{value:.4g}" for value in candidate.objectives),
            *(number(candidate.values.get(item.path)) or "-" for item in study.search),
        ]
        for candidate in history.front[:SHOWN_FRONT]
    ]
    return columns(head, rows)


def _effort(result: SearchResult) -> str:
    status, history = result.status, result.history
    lines = [
        f"{plural(status.walked, 'trial')} walked, {result.cached} from the store; "
        f"{duration(status.seconds)}"
    ]
    if status.walked and status.seconds:
        lines[0] += (
            f", {status.simulated:.0f} robot-seconds: {status.rate:.2g} robot-seconds a second"
        )
    if history.study.racing and history.planned:
        lines.append(
            f"Racing walked {history.used:.0f} of about {history.planned:.0f} robot-seconds that "
            f"every seed of every candidate would have taken: {100.0 * history.saving:.0f} % saved"
        )
    lines.append(f"Database: {result.place}")
    return "\n".join(lines)
