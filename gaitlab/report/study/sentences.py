"""What a study found, what it cannot tell and what to do next, in a few plain sentences."""

from __future__ import annotations

from collections.abc import Iterator

from gaitlab.experiment.study import Numbers
from gaitlab.report.markdown import code, escape
from gaitlab.report.study.findings import Findings
from gaitlab.report.study.fresh import crossings, gain, optimism, score, stable_of
from gaitlab.report.study.tables import near_misses, share_moved
from gaitlab.report.study.words import (
    constraint_text,
    interval,
    metric_text,
    metric_unit,
    number,
    objective_text,
)
from gaitlab.report.words import percent, plural, share, surface_text
from gaitlab.search.candidates import edge_of
from gaitlab.search.fresh import DEFAULT, RANDOM, SEARCHED, WINNER, Rerun
from gaitlab.search.margins import Margin
from gaitlab.statistics import stable_cell, wilson

NARROW = 0.05  # of the range; a parameter that may move less than this must be set with care


def sentences(findings: Findings) -> str:
    """Paragraphs for the head of the page."""
    if findings.chosen is None:
        return "\n\n".join([_nothing(findings), _wider(findings)])
    winner = findings.rerun(WINNER)
    if winner is None or not winner.on(findings.grounds):
        said = ["The winner has not been walked on fresh seeds yet, so its numbers are optimistic."]
    else:
        up, n = stable_of(winner.on(findings.grounds))
        stays = share(up, n, wilson(up, n))
        kept = escape(f"On fresh seeds the winner stays up in {stays} of the walks.")
        said = [
            kept,
            _engines(findings, winner),
            _compared(findings, winner),
            _elsewhere(findings, winner),
        ]
    return " ".join(part for part in (*said, _margins(findings), _edges(findings)) if part)


def question(findings: Findings) -> str:
    """What was searched for, in a sentence."""
    count = len(findings.grounds)
    grounds = ", ".join(surface_text(name) for name in findings.grounds)
    wanted = " and ".join(objective_text(o, count) for o in findings.study.objectives)
    bounds = " and ".join(constraint_text(c, count) for c in findings.study.constraints)
    tried = plural(len(findings.candidates), "candidate")
    text = f"Of {tried} on {grounds} the search looked for the {wanted}"
    text = f"{text}, with {bounds}." if bounds else f"{text}."
    if findings.best is None and findings.chosen is not None:
        text += (
            f" The Pareto front has {plural(len(findings.front), 'candidate')}; number "
            f"{findings.chosen.number}, its middle, is called the winner here."
        )
    return escape(text)


def _engines(findings: Findings, winner: Rerun) -> str:
    """What the engine of the search says of the winner, where another one confirms."""
    searched = findings.rerun(SEARCHED)
    walks = searched.on(findings.grounds) if searched else ()
    if not walks:
        return ""
    here = {(walk.surface, walk.seed): walk.stable for walk in winner.on(findings.grounds)}
    there = {(walk.surface, walk.seed): walk.stable for walk in walks}
    pairs = [(there[place], here[place]) for place in here.keys() & there.keys()]
    alike = sum(one == other for one, other in pairs)
    up, n = stable_of(walks)
    return escape(
        f"That is in {findings.study.confirm}; in {findings.experiment.parts.engine.name}, where "
        f"it was searched, it stays up in {share(up, n, wilson(up, n))}, and {alike} of "
        f"{plural(len(pairs), 'walk')} of equal seed and ground end alike."
    )


def _compared(findings: Findings, winner: Rerun) -> str:
    """Against the default and random search, objective by objective."""
    said = []
    for label in (DEFAULT, RANDOM):
        other = findings.rerun(label)
        if other is None or not other.on(findings.grounds):
            continue
        for place, objective in enumerate(findings.study.objectives):
            lead = gain(findings.study, winner, other, place, findings.grounds)
            word = {"cannot tell": "cannot be told from", "better": "is better than"}.get(
                lead.verdict, "is worse than"
            )
            unit = metric_unit(objective.metric)
            size = escape(f"{number(lead.value, unit)} {interval(lead.interval)}".rstrip())
            what = escape(metric_text(objective.metric))
            said.append(f"its {what} {word} that of the {label} (lead {size})")
    text = ", ".join(said)
    return f"{text[:1].upper()}{text[1:]}." if text else ""


def _elsewhere(findings: Findings, winner: Rerun) -> str:
    """Grounds that the winner was not tuned on and on which it does not stay up."""
    elsewhere = [walk.surface for walk in winner.walks if walk.surface not in findings.grounds]
    counts = {ground: stable_of(winner.on([ground])) for ground in dict.fromkeys(elsewhere)}
    falls = [ground for ground, (up, n) in counts.items() if n and not stable_cell(up / n)]
    names = ", ".join(surface_text(ground) for ground in falls)
    return f"On {escape(names)} it falls in more than half of the walks." if falls else ""


def _margins(findings: Findings) -> str:
    """Which parameter must be set with most care."""
    margins = findings.margins
    if margins is None or not margins.complete:
        return ""
    if not margins.seeds:
        return "The winner falls with every seed of the margin walks, so no margin can be given."
    ordered = sorted((_narrowest(findings, margin), margin.path) for margin in margins.numbers)
    if not ordered:
        return ""
    narrow = [code(path) for width, path in ordered if width < NARROW]
    names = ", ".join(narrow or [code(ordered[0][1])])
    reach = f"less than {percent(100.0 * NARROW)}" if narrow else percent(100.0 * ordered[0][0])
    return (
        f"Set with most care: {names}; moved by {reach} of the searched range, one of "
        f"{plural(margins.seeds, 'seed')} falls."
    )


def _narrowest(findings: Findings, margin: Margin) -> float:
    item = findings.parameter(margin.path)
    reaches = [reach for reach in (margin.below, margin.above) if reach.ending == "fell"]
    if not isinstance(item, Numbers):
        return 1.0
    return min((share_moved(margin, reach, item) for reach in reaches), default=1.0)


def _edges(findings: Findings) -> str:
    """Ranges that the winner lies at the end of."""
    chosen = findings.chosen
    found = [
        f"{code(item.path)} beyond its {edge} end"
        for item in findings.study.search
        if chosen and (edge := edge_of(item, chosen.values.get(item.path)))
    ]
    return f"A wider range might hold a better gait: {', '.join(found)}." if found else ""


def random_command(findings: Findings) -> str:
    """What searches at random with the same budget."""
    return f"{findings.commands[0]} --baseline random"


def chance(findings: Findings) -> str:
    """What is known of whether the sampler did better than drawing at random."""
    if findings.rerun(RANDOM) is not None:
        return (
            f"Random search tried {plural(findings.drawn, 'candidate')}, this one "
            f"{len(findings.candidates)}; one search of each does not show which is better as a "
            "rule."
        )
    return (
        f"Random search with {plural(findings.drawn, 'candidate')} found none that walks with all "
        "seeds and breaks no constraint."
        if findings.drawn
        else ""
    )


def _nothing(findings: Findings) -> str:
    states = [candidate.state for candidate in findings.candidates]
    walked = [c for c in findings.candidates if c.state != "infeasible"]
    broken = sum(not c.feasible for c in walked)
    return (
        f"No candidate of {len(states)} is good enough: {states.count('infeasible')} cannot be "
        f"walked at all, {broken} miss something, {states.count('pruned')} were given up early. "
        "Nothing was walked again."
    )


def _wider(findings: Findings) -> str:
    """Which range to widen: where the nearest misses crowd at an edge."""
    crowded = []
    for item in findings.study.search:
        edges = [edge_of(item, c.values.get(item.path)) for c in near_misses(findings)]
        for edge in ("lower", "upper"):
            if edges.count(edge) * 2 >= max(1, len(edges)):
                crowded.append(f"{code(item.path)} beyond its {edge} end")
    if crowded:
        return f"The nearest misses crowd at an edge: widen {', '.join(crowded)}."
    loosen = "loosen a constraint, " if findings.study.constraints else ""
    return (
        f"The nearest misses crowd at no edge: {loosen}search another parameter, or try an easier "
        "ground."
    )


def brief(findings: Findings) -> str:
    """A few lines; empty if nothing was walked after the search."""
    winner = findings.rerun(WINNER)
    if winner is None or not winner.on(findings.grounds):
        return ""
    lines = [*_fresh_lines(findings, winner), *_lead_lines(findings, winner)]
    return "\n".join([*lines, *_stable_line(findings), *_margin_lines(findings)])


def _fresh_lines(findings: Findings, winner: Rerun) -> Iterator[str]:
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


def _lead_lines(findings: Findings, winner: Rerun) -> Iterator[str]:
    for other in (findings.rerun(DEFAULT), findings.rerun(RANDOM)):
        if other is None or not other.on(findings.grounds):
            continue
        for place, objective in enumerate(findings.study.objectives):
            lead = gain(findings.study, winner, other, place, findings.grounds)
            text = f"Against the {other.label}: {metric_text(objective.metric)} {lead.verdict}, "
            unit = metric_unit(objective.metric)
            yield f"{text}lead {number(lead.value, unit)} {interval(lead.interval)}".rstrip()


def _stable_line(findings: Findings) -> Iterator[str]:
    """The winner's stable share on each ground."""
    row = next(iter(crossings(findings).values()), {})
    cells = [f"{ground} {cell.stable}/{cell.n}" for ground, cell in row.items() if cell.n]
    if cells:
        yield f"Stable on: {', '.join(cells)}"


def _margin_lines(findings: Findings) -> Iterator[str]:
    margins = findings.margins
    if margins is None or not margins.seeds or not margins.numbers:
        return
    yield f"May move alone before a fall, in shares of its range (n = {margins.seeds}):"
    for margin in margins.numbers:
        item = findings.parameter(margin.path)
        if isinstance(item, Numbers):
            down, up = (share_moved(margin, r, item) for r in (margin.below, margin.above))
            yield f"  {margin.path}  -{percent(100.0 * down)}  +{percent(100.0 * up)}"
