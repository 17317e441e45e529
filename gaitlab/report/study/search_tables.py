"""The tables of a search: how it went, its Pareto front, and the nearest misses."""

from __future__ import annotations

import math
from collections.abc import Sequence

from gaitlab.report.markdown import code, escape, table
from gaitlab.report.study.findings import Findings
from gaitlab.report.study.words import UNKNOWN, metric_text, metric_unit, number, value, with_unit
from gaitlab.search import Candidate
from gaitlab.search.objectives import misses

NEAREST = 5  # candidates that nearly fulfilled the constraints
SHOWN_FRONT = 12  # candidates of a Pareto front


def front_table(findings: Findings) -> str:
    """The candidates of the Pareto front with their values."""
    if len(findings.study.objectives) < 2 or not findings.front:
        return ""
    ordered = sorted(findings.front, key=lambda candidate: candidate.objectives)
    return _candidates_table(findings, ordered[:: max(1, len(ordered) // SHOWN_FRONT)])


def final_table(findings: Findings) -> str:
    """The finalists by what they did in the search and with all seeds of the final."""
    told = {candidate.number: candidate for candidate in findings.candidates}
    objective = findings.study.objectives[0]
    what = escape(with_unit(metric_text(objective.metric), metric_unit(objective.metric)))
    rows = [
        [
            f"{one.number}" + (", winner" if one == findings.chosen else ""),
            f"{number(told[one.number].objectives[0])}, n = {told[one.number].seeds}",
            f"{number(one.objectives[0])}, n = {one.seeds}",
            "hold" if one.feasible else "**broken**",
        ]
        for one in findings.finals
    ]
    head = ["candidate", f"{what} in the search", "with the seeds of the final", "constraints"]
    return table(head, rows, "lrrc")


def near_misses(findings: Findings) -> list[Candidate]:
    """Candidates that walked, the least broken first; those that cannot be walked last."""
    order = sorted(
        findings.candidates, key=lambda c: (c.state == "infeasible", _broken(c), c.number)
    )
    return order[:NEAREST]


def _broken(candidate: Candidate) -> float:
    return sum(max(0.0, found) for found in candidate.violations if math.isfinite(found))


def near_misses_table(findings: Findings) -> str:
    """The nearest misses with how far they break the constraints."""
    missed = [
        escape("; ".join(misses(findings.study, c.objectives, c.violations)))
        for c in near_misses(findings)
    ]
    return _candidates_table(findings, near_misses(findings), missed)


def _candidates_table(
    findings: Findings, chosen: Sequence[Candidate], missed: Sequence[str] = ()
) -> str:
    search, study = findings.study.search, findings.study
    head = [
        "candidate",
        *(
            escape(with_unit(metric_text(o.metric), metric_unit(o.metric)))
            for o in study.objectives
        ),
        *(["misses"] if missed else []),
        *(code(item.path) for item in search),
    ]
    rows = [
        [
            f"{c.number}",
            *(number(found) for found in _objectives(c, len(study.objectives))),
            *missed[place : place + 1],
            *(escape(value(c.values.get(item.path))) for item in search),
        ]
        for place, c in enumerate(chosen)
    ]
    return table(head, rows, "r" * len(head))


def _objectives(candidate: Candidate, count: int) -> list[float]:
    return [*map(float, candidate.objectives), *[math.nan] * count][:count]


def search_table(findings: Findings) -> str:
    """How the search went: candidates by how they ended, and what racing saved."""
    states = [candidate.state for candidate in findings.candidates]
    rows = [
        ["candidates", str(len(states))],
        ["walked with all seeds", str(states.count("done"))],
        ["given up early", str(states.count("pruned"))],
        ["cannot be walked", str(states.count("infeasible"))],
        ["simulated", f"{number(findings.used)} s of {number(findings.planned)} s"],
        ["saved by racing", saving_text(findings)],
    ]
    return table(["", ""], rows, "lr")


def saving_text(findings: Findings) -> str:
    """Share of the simulated time that giving up early saved."""
    if findings.study.racing is None:
        return "racing was off"
    if not findings.planned:
        return UNKNOWN
    return f"{1.0 - findings.used / findings.planned:.0%} of the simulated time"
