"""What the walks after a search found, in a few plain lines for a terminal."""

from __future__ import annotations

from collections.abc import Iterator

from gaitlab.experiment.study import Numbers
from gaitlab.report.study.findings import Findings
from gaitlab.report.study.fresh import crossings, gain, optimism, score, stable_of
from gaitlab.report.study.tables import share_moved
from gaitlab.report.study.words import interval, metric_text, metric_unit, number
from gaitlab.report.words import share
from gaitlab.search.fresh import DEFAULT, RANDOM, WINNER, Rerun
from gaitlab.statistics import wilson


def brief(findings: Findings) -> str:
    """A few lines; empty if nothing was walked after the search."""
    winner = findings.rerun(WINNER)
    if winner is None or not winner.on(findings.grounds):
        return ""
    lines = [*_fresh(findings, winner), *_against(findings, winner)]
    return "\n".join([*lines, *_elsewhere(findings), *_margins(findings)])


def _fresh(findings: Findings, winner: Rerun) -> Iterator[str]:
    walks = winner.on(findings.grounds)
    up, n = stable_of(walks)
    yield f"On fresh seeds: stable {share(up, n, wilson(up, n))}"
    for place, objective in enumerate(findings.study.objectives):
        again, unit = score(findings.study, walks, place), metric_unit(objective.metric)
        told = findings.chosen.objectives[place] if findings.chosen else float("nan")
        lost = optimism(told, again.value, objective)
        text = f"  {metric_text(objective.metric)} {number(again.value, unit)}"
        text += f" {interval(again.interval)}, in the search {number(told, unit)}"
        yield text if lost is None else f"{text}: optimism {number(lost, unit)}"


def _against(findings: Findings, winner: Rerun) -> Iterator[str]:
    for other in (findings.rerun(DEFAULT), findings.rerun(RANDOM)):
        if other is None or not other.on(findings.grounds):
            continue
        for place, objective in enumerate(findings.study.objectives):
            lead = gain(findings.study, winner, other, place, findings.grounds)
            text = f"Against the {other.label}: {metric_text(objective.metric)} {lead.verdict}, "
            unit = metric_unit(objective.metric)
            yield f"{text}lead {number(lead.value, unit)} {interval(lead.interval)}".rstrip()


def _elsewhere(findings: Findings) -> Iterator[str]:
    """The winner's stable share on each ground."""
    row = next(iter(crossings(findings).values()), {})
    cells = [f"{ground} {cell.stable}/{cell.n}" for ground, cell in row.items() if cell.n]
    if cells:
        yield f"Stable on: {', '.join(cells)}"


def _margins(findings: Findings) -> Iterator[str]:
    margins = findings.margins
    if margins is None or not margins.seeds or not margins.numbers:
        return
    yield f"May move alone before a fall, in shares of its range (n = {margins.seeds}):"
    for margin in margins.numbers:
        item = findings.parameter(margin.path)
        if isinstance(item, Numbers):
            down, up = (share_moved(margin, r, item) for r in (margin.below, margin.above))
            yield f"  {margin.path}  -{down:.0%}  +{up:.0%}"
