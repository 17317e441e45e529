"""What `gaitlab optimize` prints: the plan of a search, and its result."""

from __future__ import annotations

import json
from math import isfinite

from gaitlab.cli.printing import columns, duration, number, plural, size
from gaitlab.cli.search_progress import with_unit
from gaitlab.dispatch import cost
from gaitlab.errors import UnknownName
from gaitlab.experiment import Experiment
from gaitlab.experiment.purposes import study_of
from gaitlab.experiment.study import Choices, Constraint, Numbers
from gaitlab.plan import plan
from gaitlab.search import Candidate, History, history
from gaitlab.search.advice import edges, nothing_allowed
from gaitlab.search.tally import Searched
from gaitlab.search.winner import objective_text
from gaitlab.store import Store

SHOWN_FRONT = 10  # candidates of a Pareto front


def plan_text(
    wanted: Experiment, results: Store, storage: str | None, jobs: int, as_json: bool
) -> str:
    """What a search takes at most, before anything walks."""
    study, planned = study_of(wanted), plan(wanted)
    told = _told(wanted, results, storage)
    left = max(0, study.trials - told)
    needed = cost(planned, left * planned.size, jobs)
    if as_json:
        counts = {"candidates": study.trials, "told": told, "trials": needed.trials}
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


def _told(wanted: Experiment, results: Store, storage: str | None) -> int:
    try:
        return len(history(wanted, results, storage).candidates)
    except UnknownName:
        return 0


def _range(item: Numbers | Choices) -> str:
    if isinstance(item, Choices):
        text = ", ".join(map(str, item.options))
    else:
        text = f"{item.low:g} to {item.high:g}"
        text += ", logarithmic" if item.log else ""
        text += ", whole numbers" if item.integer else ""
        text += f", steps of {item.step:g}" if item.step and not item.integer else ""
    when = item.when
    return (
        text
        if when is None
        else f"{text} (when {when.path} is {' or '.join(map(str, when.values))})"
    )


def result_json(found: Searched) -> str:
    """The result as one JSON object."""
    tally, history = found.tally, found.tally.history
    states = {state: tally.count(state) for state in ("done", "pruned", "infeasible")}
    best = history.best
    return json.dumps(
        {
            "study": history.experiment.name,
            "ending": found.ending,
            "total": tally.total,
            "told": tally.told,
            **states,
            "best": None if best is None else _candidate_json(best),
            "front": [_candidate_json(candidate) for candidate in history.front],
            "walked": tally.walked,
            "cached": found.used_before,
            "seconds": round(tally.seconds, 3),
            "simulated_seconds": round(tally.simulated, 3),
            "saving": round(history.saving, 4),
            "interrupted": found.ending == "stopped",
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


def result_text(found: Searched, again: str, report: str) -> str:
    """The result for reading.

    Args:
        found: The search.
        again: Arguments with which `gaitlab optimize` goes on.
        report: Arguments with which `gaitlab report` knows the study.
    """
    history = found.tally.history
    parts = [_ending(found), *nothing_allowed(history), *_winners(history)]
    parts += ["", _effort(found)]
    if found.ending == "stopped" or found.ending == "elsewhere":
        return "\n".join([*parts, f"Go on: gaitlab optimize {again}"])
    return "\n".join([*parts, f"Report: gaitlab report {report}"])


def _ending(found: Searched) -> str:
    tally = found.tally
    states = ", ".join(f"{tally.count(s)} {s}" for s in ("done", "pruned", "infeasible"))
    told = f"{tally.told} of {plural(tally.total, 'candidate')} told: {states}."
    why = {
        "complete": "",
        "stopped": " Stopped.",
        "no improvement": " Ended early: the last "
        f"{tally.history.study.early_stop} brought no improvement.",
        "exhausted": " The space holds no more: every combination was tried.",
        "elsewhere": f" The rest is walked by {', '.join(found.elsewhere) or 'another machine'}.",
    }
    return told + why[found.ending]


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
    places = ", ".join(f"{one.number}: {one.objectives[0]:.4g}" for one in history.finals)
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


def _effort(found: Searched) -> str:
    tally, history = found.tally, found.tally.history
    lines = [
        f"{plural(tally.walked, 'trial')} walked, {found.used_before} from the store; "
        f"{duration(tally.seconds)}"
    ]
    if tally.walked and tally.seconds:
        lines[0] += (
            f", {tally.simulated:.0f} robot-seconds: {tally.rate:.2g} robot-seconds a second"
        )
    if history.study.racing and history.planned:
        lines.append(
            f"Racing walked {history.used:.0f} of about {history.planned:.0f} robot-seconds that "
            f"every seed of every candidate would have taken: {100.0 * history.saving:.0f} % saved"
        )
    lines.append(f"Database: {found.place}")
    return "\n".join(lines)
