"""The tables of what a study found: the winner, its proof on fresh seeds, its margins."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from gaitlab.experiment import Value
from gaitlab.experiment.study import Choices, Numbers
from gaitlab.report.markdown import code, escape, table
from gaitlab.report.study.findings import Findings
from gaitlab.report.study.fresh import constraint_value, gain, score, stable_of, verdict
from gaitlab.report.study.words import (
    UNKNOWN,
    better,
    constraint_text,
    interval,
    metric_text,
    metric_unit,
    number,
    objective_text,
    range_text,
    value,
)
from gaitlab.report.words import share
from gaitlab.search.fresh import DEFAULT, RANDOM, WINNER, Rerun
from gaitlab.search.margins import Margin, Reach
from gaitlab.statistics import wilson

AT_THE_EDGE = 0.02  # of the range; a winner so near its end may want more of it


def winner_table(findings: Findings) -> str:
    """Every searched parameter: default, range and the winner's value, a warning at the edge."""
    winner = findings.chosen
    if winner is None:
        return ""
    rows = [
        [
            code(item.path),
            escape(value(winner.values.get(item.path), findings.unit(item.path))),
            escape(value(findings.defaults.get(item.path), findings.unit(item.path))),
            escape(range_text(item, findings.unit(item.path))),
            _remark(item, winner.values.get(item.path)),
        ]
        for item in findings.study.search
    ]
    return table(["parameter", "winner", "hand-set default", "searched", ""], rows, "lrrll")


def _remark(item: Numbers | Choices, found: Value | None) -> str:
    if found is None:
        return "not used"
    edge = edge_of(item, found)
    return f"**at the {edge} edge of its range**" if edge else ""


def edge_of(item: Numbers | Choices, found: Value | None) -> str:
    """`lower` or `upper` if a value lies at the end of its range; empty elsewhere."""
    if isinstance(item, Choices) or found is None or isinstance(found, str):
        return ""
    low, high, at = item.low, item.high, float(found)
    if item.log:
        low, high, at = math.log(low), math.log(high), math.log(at)
    near = AT_THE_EDGE * (high - low)
    return "lower" if at - low <= near else "upper" if high - at <= near else ""


def fresh_table(findings: Findings) -> str:
    """Objectives in the search and on fresh seeds: what was promised and what is kept."""
    objectives = findings.study.objectives
    head = [
        "",
        "seeds",
        *(
            escape(f"{objective_text(o, len(findings.grounds))}{_unit(o.metric)}")
            for o in objectives
        ),
    ]
    rows = []
    if findings.chosen is not None:
        told = [number(found) for found in findings.chosen.objectives]
        rows.append(["winner in the search", f"{findings.chosen.seeds}, its own", *told])
    for rerun in findings.reruns:
        walks = rerun.on(findings.grounds)
        if walks:
            rows.append([f"{rerun.label} on fresh seeds", _seeds(walks), *_scores(findings, rerun)])
    return table([*head, "stable"], [[*row, _stable(findings, row[0])] for row in rows], "lr")


def _unit(metric: str) -> str:
    unit = metric_unit(metric)
    return f" [{unit}]" if unit else ""


def _seeds(walks: Sequence[object]) -> str:
    return str(len({getattr(walk, "seed", None) for walk in walks}))


def _scores(findings: Findings, rerun: Rerun) -> Iterator[str]:
    walks = rerun.on(findings.grounds)
    for place in range(len(findings.study.objectives)):
        found = score(findings.study, walks, place)
        yield f"{number(found.value)} {escape(interval(found.interval))}".rstrip()


def _stable(findings: Findings, label: str) -> str:
    rerun = findings.rerun(label.removesuffix(" on fresh seeds"))
    if rerun is None:
        return ""
    up, n = stable_of(rerun.on(findings.grounds))
    return share(up, n, wilson(up, n)) if n else UNKNOWN


def gains_table(findings: Findings) -> str:
    """The winner's lead over what it is compared with, paired by seed and ground."""
    winner = findings.rerun(WINNER)
    if winner is None:
        return ""
    rows = []
    for other in (findings.rerun(DEFAULT), findings.rerun(RANDOM)):
        if other is None or not other.on(findings.grounds):
            continue
        for place, objective in enumerate(findings.study.objectives):
            found = gain(findings.study, winner, other, place, findings.grounds)
            what = f"{metric_text(objective.metric)}, {better(objective)} is better"
            lead = f"{number(found.value)} {escape(interval(found.interval))}"
            rows.append([f"winner against {other.label}", escape(what), lead, verdict(found)])
    head = ["", "objective", "lead of the winner [95 %]", ""]
    return table(head, rows, "llrl") if rows else ""


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
    rows = [_margin_row(findings, margin) for margin in findings.margins.numbers]
    head = ["parameter", "winner", "lower limit", "share", "upper limit", "share"]
    return table(head, rows, "lrrrrr") if rows else ""


def _margin_row(findings: Findings, margin: Margin) -> list[str]:
    unit, item = findings.unit(margin.path), findings.parameter(margin.path)
    cells = [code(margin.path), escape(value(margin.value, unit))]
    for reach in (margin.below, margin.above):
        share_text = f"{share_moved(margin, reach, item):.0%}" if isinstance(item, Numbers) else ""
        cells += [_limit(reach), share_text]
    return cells


def _limit(reach: Reach) -> str:
    if reach.fails is None:
        return f"{number(reach.holds)}, {reach.ending}"
    verb = "falls" if reach.ending == "fell" else reach.ending
    return f"{number(reach.holds)}, {verb} at {number(reach.fails)}"


def share_moved(margin: Margin, reach: Reach, item: Numbers) -> float:
    """How far a parameter moves one way without a fall, as a share of its searched range."""
    if item.log:
        return abs(math.log(reach.holds / margin.value) / math.log(item.high / item.low))
    return abs(reach.holds - margin.value) / (item.high - item.low)


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
