"""The tables of a study: the winner, its proof on fresh seeds, its margins, and the search."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from gaitlab.experiment import Value
from gaitlab.experiment.study import Choices, Numbers
from gaitlab.report.markdown import code, escape, table
from gaitlab.report.study.findings import Findings
from gaitlab.report.study.fresh import constraint_value, gain, score, stable_of
from gaitlab.report.study.words import (
    UNKNOWN,
    constraint_text,
    interval,
    metric_text,
    metric_unit,
    number,
    objective_text,
    range_text,
    value,
    with_unit,
)
from gaitlab.report.words import percent, share
from gaitlab.search import Candidate
from gaitlab.search.candidates import edge_of, moved
from gaitlab.search.fresh import WINNER, Rerun
from gaitlab.search.margins import Margin, Reach
from gaitlab.search.objectives import misses
from gaitlab.statistics import wilson

NEAREST = 5  # candidates that nearly fulfilled the constraints
SHOWN_FRONT = 12  # candidates of a Pareto front


def winner_table(findings: Findings) -> str:
    """Every searched parameter: the winner's value, default, range, importance, a warning."""
    winner = findings.chosen
    if winner is None:
        return ""
    rows = [
        [
            code(item.path),
            escape(value(winner.values.get(item.path), findings.unit(item.path))),
            escape(value(findings.defaults.get(item.path), findings.unit(item.path))),
            escape(range_text(item, findings.unit(item.path))),
            ", ".join(percent(100.0 * of.get(item.path, 0.0)) for of in findings.importance if of),
            _remark(item, winner.values.get(item.path)),
        ]
        for item in findings.study.search
    ]
    return table(
        ["parameter", "winner", "hand-set default", "searched", "importance", ""], rows, "lrrlrl"
    )


def _remark(item: Numbers | Choices, found: Value | None) -> str:
    if found is None:
        return "not used"
    edge = edge_of(item, found)
    return f"**at the {edge} edge of its range**" if edge else ""


def fresh_table(findings: Findings) -> str:
    """What the search promised and fresh seeds keep, and the winner's lead over the others."""
    objectives = findings.study.objectives
    head = ["", "seeds"]
    for objective in objectives:
        text = objective_text(objective, len(findings.grounds))
        head.append(escape(with_unit(text, metric_unit(objective.metric))))
        head.append("lead of the winner [95 %]")
    rows = []
    if findings.chosen is not None:
        told = [cell for found in findings.chosen.objectives for cell in (number(found), "")]
        rows.append(["winner in the search", f"{findings.chosen.seeds}, its own", *told, ""])
    for rerun in findings.reruns:
        if walks := rerun.on(findings.grounds):
            seeds = str(len({walk.seed for walk in walks}))
            up, n = stable_of(walks)
            cells = [cell for pair in _scores(findings, rerun) for cell in pair]
            stable = share(up, n, wilson(up, n))
            rows.append([f"{rerun.label} on fresh seeds", seeds, *cells, stable])
    head.append("stable")
    filled = [place for place in range(len(head)) if place < 2 or any(row[place] for row in rows)]
    kept = [[row[place] for place in filled] for row in [head, *rows]]
    return table(kept[0], kept[1:], "lr")


def _scores(findings: Findings, rerun: Rerun) -> Iterator[tuple[str, str]]:
    """Each objective of a gait on fresh seeds, and how far the winner leads it on the same ones."""
    winner, walks = findings.rerun(WINNER), rerun.on(findings.grounds)
    for place in range(len(findings.study.objectives)):
        found = score(findings.study, walks, place)
        text = f"{number(found.value)} {escape(interval(found.interval))}".rstrip()
        if winner is None or rerun.label == WINNER:
            yield text, ""
            continue
        lead = gain(findings.study, winner, rerun, place, findings.grounds)
        told = lead.verdict if lead.verdict == "cannot tell" else f"**{lead.verdict}**"
        yield text, f"{number(lead.value)} {escape(interval(lead.interval))} {told}"


def constraints_table(findings: Findings) -> str:
    """Every constraint with what the winner reaches on fresh seeds."""
    study, winner = findings.study, findings.rerun(WINNER)
    if not study.constraints or findings.chosen is None:
        return ""
    rows = []
    for place, constraint in enumerate(study.constraints):
        again = UNKNOWN
        if winner is not None and winner.on(findings.grounds):
            found = constraint_value(constraint, winner.on(findings.grounds))
            kept = found >= constraint.bound if constraint.at_least else found <= constraint.bound
            text = number(found, metric_unit(constraint.metric))
            again = f"{text}, {'holds' if kept else '**broken**'}"
        holds = findings.chosen.violations[place] <= 0.0
        rows.append(
            [
                escape(constraint_text(constraint, len(findings.grounds))),
                "holds" if holds else "broken",
                again,
            ]
        )
    return table(["constraint", "in the search", "on fresh seeds"], rows, "lcr")


def margins_table(findings: Findings) -> str:
    """How far each parameter moves before a fall, in its unit and as shares of its range."""
    if findings.margins is None:
        return ""
    rows = []
    for margin in findings.margins.numbers:
        unit, item = findings.unit(margin.path), findings.parameter(margin.path)
        cells = [code(margin.path), escape(value(margin.value, unit))]
        for reach in (margin.below, margin.above):
            moved = share_moved(margin, reach, item) if isinstance(item, Numbers) else None
            cells += [_limit(reach), "" if moved is None else percent(100.0 * moved)]
        rows.append(cells)
    head = ["parameter", "winner", "lower limit", "share", "upper limit", "share"]
    return table(head, rows, "lrrrrr") if rows else ""


def _limit(reach: Reach) -> str:
    if reach.fails is None:
        return f"{number(reach.holds)}, {reach.ending}"
    verb = "falls" if reach.ending == "fell" else reach.ending
    return f"{number(reach.holds)}, {verb} at {number(reach.fails)}"


def share_moved(margin: Margin, reach: Reach, item: Numbers) -> float:
    """How far a parameter moves one way without a fall, as a share of its searched range."""
    return abs(moved(item, margin.value, reach.holds))


def switches_table(findings: Findings) -> str:
    """What each other option of a choice does."""
    if findings.margins is None:
        return ""
    rows = [
        [
            code(switch.path),
            escape(value(switch.value)),
            escape(value(option)),
            "no fall" if holds else "falls",
        ]
        for switch in findings.margins.switches
        for option, holds in switch.holds.items()
    ]
    return table(["choice", "winner", "instead", ""], rows, "lccc") if rows else ""


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
        findings.candidates, key=lambda c: (c.state == "infeasible", c.missed_by, c.number)
    )
    return order[:NEAREST]


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
        ["simulated", f"{findings.used:.0f} s of {findings.planned:.0f} s"],
        ["saved by racing", saving_text(findings)],
    ]
    return table(["", ""], rows, "lr")


def saving_text(findings: Findings) -> str:
    """Share of the simulated time that giving up early saved."""
    if findings.study.racing is None:
        return "racing was off"
    if not findings.planned:
        return UNKNOWN
    return f"{percent(100.0 * (1.0 - findings.used / findings.planned))} of the simulated time"
