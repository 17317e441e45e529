"""What a study found, what it cannot tell and what it assumed, in plain words."""

from __future__ import annotations

import math
from collections.abc import Iterator

from gaitlab.experiment.study import Numbers
from gaitlab.report.markdown import code, escape
from gaitlab.report.study.findings import Findings
from gaitlab.report.study.fresh import Score, gain, optimism, score, stable_of, verdict
from gaitlab.report.study.search_tables import near_misses, saving_text
from gaitlab.report.study.tables import edge_of, share_moved
from gaitlab.report.study.words import (
    constraint_text,
    interval,
    metric_text,
    metric_unit,
    number,
    objective_text,
)
from gaitlab.report.words import plural, share, surface_text
from gaitlab.search.fresh import DEFAULT, RANDOM, WINNER, Rerun
from gaitlab.search.margins import Margin
from gaitlab.statistics import stable_cell, wilson

FEW_SEEDS = 10  # fresh ones; fewer hardly tell anything
NARROW = 0.05  # of the range; a parameter that may move less than this must be set with care


def sentences(findings: Findings) -> str:
    """Paragraphs for the head of the page."""
    if findings.chosen is None:
        return "\n\n".join([_nothing(findings), *_wider(findings)])
    found = " ".join([_asked(findings), *_winner(findings), *_optimism(findings)])
    cannot = " ".join(_cannot_tell(findings))
    margins = " ".join(_margins(findings))
    return "\n\n".join(part for part in (found, margins, cannot, _assumed(findings)) if part)


def _asked(findings: Findings) -> str:
    tried = plural(len(findings.candidates), "candidate")
    grounds = ", ".join(surface_text(name) for name in findings.grounds)
    asked = " and ".join(
        objective_text(o, len(findings.grounds)) for o in findings.study.objectives
    )
    text = f"Of {tried} on {grounds} the search looked for the {asked}"
    bounds = " and ".join(
        constraint_text(c, len(findings.grounds)) for c in findings.study.constraints
    )
    return escape(f"{text}, with {bounds}." if bounds else f"{text}.")


def _winner(findings: Findings) -> Iterator[str]:
    winner = findings.rerun(WINNER)
    if findings.best is None and findings.chosen is not None:
        yield (
            f"Several objectives have no single best: {plural(len(findings.front), 'candidate')} "
            f"make the front, and number {findings.chosen.number}, its middle, was walked again."
        )
    if winner is None or not winner.on(findings.grounds):
        yield "The winner has not been walked on fresh seeds yet, so its numbers are optimistic."
        return
    up, n = stable_of(winner.on(findings.grounds))
    yield (
        "On fresh seeds, which the search never saw, the winner stays on its feet in "
        f"{escape(share(up, n, wilson(up, n)))} of the walks."
    )
    for label in (DEFAULT, RANDOM):
        other = findings.rerun(label)
        if other is not None and other.on(findings.grounds):
            yield from _against(findings, winner, other)
    yield from _elsewhere(findings, winner)


def _elsewhere(findings: Findings, winner: Rerun) -> Iterator[str]:
    """Grounds that the winner was not tuned on and on which it does not stay up."""
    elsewhere = [walk.surface for walk in winner.walks if walk.surface not in findings.grounds]
    counts = {ground: stable_of(winner.on([ground])) for ground in dict.fromkeys(elsewhere)}
    known = {ground: count for ground, count in counts.items() if count.n}
    falls = [g for g, (up, n) in known.items() if not stable_cell(up / n)]
    if falls:
        names = ", ".join(surface_text(ground) for ground in falls)
        yield (
            f"It does not carry over to every ground: on {escape(names)} it falls in more than "
            "half of the walks."
        )
    elif known:
        others = plural(len(known), "other ground")
        yield f"On {others} too it stays up in half of the walks or more."


def _against(findings: Findings, winner: Rerun, other: Rerun) -> Iterator[str]:
    for place, objective in enumerate(findings.study.objectives):
        found = gain(findings.study, winner, other, place, findings.grounds)
        word = verdict(found)
        is_word = "cannot be told apart from" if word == "cannot tell" else f"is {word} than"
        what = escape(metric_text(objective.metric))
        lead = _lead(found, objective.metric)
        yield f"Its {what} {is_word} that of the {other.label}{lead}."


def _lead(found: Score, metric: str) -> str:
    if not math.isfinite(found.value):
        return ""
    lead = number(found.value, metric_unit(metric))
    return " " + escape(f"(lead {lead} {interval(found.interval)}".rstrip()) + ")"


def _optimism(findings: Findings) -> Iterator[str]:
    """How much better the search made the winner look than it is."""
    winner, chosen = findings.rerun(WINNER), findings.chosen
    if winner is None or chosen is None or not winner.on(findings.grounds):
        return
    for place, objective in enumerate(findings.study.objectives):
        again = score(findings.study, winner.on(findings.grounds), place)
        told = float(chosen.objectives[place])
        lost = optimism(told, again.value, objective)
        if lost is None:
            continue
        unit = metric_unit(objective.metric)
        yield escape(
            f"The search promised {number(told, unit)} {metric_text(objective.metric)} and fresh "
            f"seeds give {number(again.value, unit)} {interval(again.interval)}: an optimism of "
            f"{number(lost, unit)}."
        )


def _margins(findings: Findings) -> Iterator[str]:
    margins = findings.margins
    if margins is None or not margins.complete:
        return
    if not margins.seeds:
        yield "The winner falls with every seed of the margin walks, so no margin can be given."
        return
    ordered = sorted((_narrowest(findings, margin), margin.path) for margin in margins.numbers)
    narrow = [code(path) for width, path in ordered if width < NARROW]
    if narrow:
        yield (
            f"Set with care: {', '.join(narrow)}; moved by less than {NARROW:.0%} of the searched "
            f"range, one of {plural(margins.seeds, 'seed')} falls."
        )
    elif ordered:
        yield (
            f"The most delicate parameter is {code(ordered[0][1])}: it may move by "
            f"{ordered[0][0]:.0%} of the searched range before one of "
            f"{plural(margins.seeds, 'seed')} falls."
        )


def _narrowest(findings: Findings, margin: Margin) -> float:
    item = findings.parameter(margin.path)
    reaches = [reach for reach in (margin.below, margin.above) if reach.ending == "fell"]
    if not isinstance(item, Numbers):
        return 1.0
    return min((share_moved(margin, reach, item) for reach in reaches), default=1.0)


def _cannot_tell(findings: Findings) -> Iterator[str]:
    winner = findings.rerun(WINNER)
    seeds = len({walk.seed for walk in winner.on(findings.grounds)}) if winner else 0
    if 0 < seeds < FEW_SEEDS:
        yield f"Only {plural(seeds, 'fresh seed')}: the intervals are wide."
    for item in findings.study.search:
        chosen = findings.chosen
        edge = edge_of(item, chosen.values.get(item.path)) if chosen else ""
        if edge:
            yield (
                f"{code(item.path)} lies at the {edge} edge of its range; a wider range might "
                "hold a better gait."
            )
    yield from _chance(findings)


def _chance(findings: Findings) -> Iterator[str]:
    """What is known of whether the sampler did better than drawing at random."""
    if findings.rerun(RANDOM) is not None:
        yield (
            f"Random search tried {plural(findings.drawn, 'candidate')}, this one "
            f"{len(findings.candidates)}; one search of each does not show which is better as a "
            "rule."
        )
    elif findings.drawn:
        yield (
            f"Random search with {plural(findings.drawn, 'candidate')} found none that walks with "
            "all seeds and breaks no constraint."
        )
    else:
        yield (
            "Whether the sampler did better than chance is not known: nothing was drawn at "
            f"random with the same budget yet ({code(random_command(findings))})."
        )


def random_command(findings: Findings) -> str:
    """What searches at random with the same budget."""
    return f"{findings.commands[0]} --baseline random"


def _assumed(findings: Findings) -> str:
    study = findings.study
    saved = saving_text(findings)
    racing = f" Giving up hopeless candidates saved {saved}." if study.racing else ""
    return (
        "The numbers hold for the simulated robot and grounds; what they assume stands in "
        "`gaitlab show` of each. Candidates walk with the same seeds, so they are compared in "
        f"pairs.{racing} Importance and margins look at one parameter at a time and miss what two "
        "do together."
    )


def _nothing(findings: Findings) -> str:
    states = [candidate.state for candidate in findings.candidates]
    walked = [c for c in findings.candidates if c.state != "infeasible"]
    broken = sum(not c.feasible for c in walked)
    bounds = (
        " and ".join(constraint_text(c, len(findings.grounds)) for c in findings.study.constraints)
        or "no constraint"
    )
    return escape(
        f"No candidate of {len(states)} is good enough: {states.count('infeasible')} cannot be "
        f"walked at all, {broken} miss something ({bounds}, and to walk to the end), "
        f"{states.count('pruned')} were given up early. The nearest misses stand below; "
        "nothing was walked again."
    )


def _wider(findings: Findings) -> Iterator[str]:
    """Which range to widen: where the nearest misses crowd at an edge."""
    crowded = []
    for item in findings.study.search:
        edges = [edge_of(item, c.values.get(item.path)) for c in near_misses(findings)]
        for edge in ("lower", "upper"):
            if edges.count(edge) * 2 >= max(1, len(edges)):
                crowded.append(f"{code(item.path)} beyond its {edge} end")
    if crowded:
        yield f"The nearest misses crowd at an edge: widen {', '.join(crowded)}."
    else:
        loosen = "loosen a constraint, " if findings.study.constraints else ""
        yield (
            f"The nearest misses crowd at no edge: {loosen}search another parameter, "
            "or try an easier ground."
        )
