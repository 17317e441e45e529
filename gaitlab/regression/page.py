"""The gate's answer as a page of Markdown, for a terminal, a mail or a job's summary."""

from __future__ import annotations

from collections.abc import Sequence
from math import degrees, isfinite

from gaitlab.metrics import better, unit_of
from gaitlab.regression.baseline import Baseline
from gaitlab.regression.gate import Outcome
from gaitlab.regression.quantities import FALSE_ALARMS, Quantity

SHOWN = 10  # trials that are named
NOTHING = "—"
HEADER = ("quantity", "on", "baseline", "tonight", "change", "p worse", "finding", "would notice")


def summary_page(before: Baseline, tonight: Baseline, outcome: Outcome) -> str:
    """The whole answer: verdict first, then the tests, then what was compared with what."""
    blocks = [
        f"# {tonight.experiment}: {_verdict(outcome)}",
        _sentence(outcome),
        _table(outcome.quantities),
        _how(outcome),
        _changes(outcome),
        _trials(outcome),
        _seams(before, tonight, outcome),
    ]
    return "\n\n".join(block for block in blocks if block)


def undecided_page(experiment: str, reason: str) -> str:
    """The answer when there is none: why, and what to do."""
    return f"# {experiment}: the gate could not decide\n\n{reason}"


def _verdict(outcome: Outcome) -> str:
    if outcome.mode == "exact":
        return "nothing changed"
    return "worse than the baseline" if outcome.worse else "as good as the baseline"


def _sentence(outcome: Outcome) -> str:
    if outcome.mode == "exact":
        return f"Nothing changed, bit for bit, in {outcome.compared} trials."
    parts = []
    if outcome.worse:
        parts.append(f"**Worse: {listed(outcome.worse)}.**")
    if outcome.improved:
        parts.append(f"Better: {listed(outcome.improved)}.")
    return " ".join(parts) or "No quantity is significantly worse or better."


def listed(quantities: Sequence[Quantity]) -> str:
    """Quantities with what they were and are, for a sentence."""
    return "; ".join(
        f"{_name(q)}{_where(q)} {_value(q, q.before)} -> {_value(q, q.tonight)}" for q in quantities
    )


def _where(quantity: Quantity) -> str:
    return f" on {quantity.surface}" if quantity.surface else ""


def _table(quantities: Sequence[Quantity]) -> str:
    if not quantities:
        return ""
    rows = [HEADER, ["---"] * len(HEADER), *(_row(quantity) for quantity in quantities)]
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


def _row(quantity: Quantity) -> list[str]:
    loud = quantity.finding != "as before"
    return [
        _name(quantity),
        quantity.surface or "all",
        _value(quantity, quantity.before),
        _value(quantity, quantity.tonight),
        _change(quantity, quantity.difference),
        "< 0.0001" if quantity.p_worse < 1e-4 else f"{quantity.p_worse:.2g}",
        f"**{quantity.finding}**" if loud else quantity.finding,
        _detectable(quantity),
    ]


def _detectable(quantity: Quantity) -> str:
    if not isfinite(quantity.detectable):
        return "no change at this n"
    sign = 1.0 if quantity.name != "stable" and better(quantity.name) == "lower" else -1.0
    return _change(quantity, sign * quantity.detectable)


def _name(quantity: Quantity) -> str:
    return "stable walks" if quantity.name == "stable" else quantity.name.replace("_", " ")


def _unit(quantity: Quantity) -> str:
    return {"rad": " °", "-": ""}.get(unit_of(quantity.name), f" {unit_of(quantity.name)}")


def _value(quantity: Quantity, value: float) -> str:
    if quantity.name == "stable":
        return f"{100.0 * value:.1f} %"
    shown = degrees(value) if unit_of(quantity.name) == "rad" else value
    return f"{shown:.4g}{_unit(quantity)}"


def _change(quantity: Quantity, value: float) -> str:
    if quantity.name == "stable":
        return f"{100.0 * value:+.1f} points"
    shown = degrees(value) if unit_of(quantity.name) == "rad" else value
    return f"{shown:+.2g}{_unit(quantity)}"


def _how(outcome: Outcome) -> str:
    if outcome.mode == "exact":
        return ""
    runs = outcome.runs
    matching = (
        "pairs of equal cell and seed" if runs.paired else "walks a side, without common seeds"
    )
    unshared = f" {runs.unshared} cells only one side has are left out." if runs.unshared else ""
    return (
        f"Compared: {runs.n} {matching}, in {len(runs.cells)} cells.{unshared} All tests of a "
        f"night together raise a false alarm in at most {FALSE_ALARMS:.0%} of nights in which "
        "nothing changed (Holm). *Would notice*: the smallest change for the worse, alike in all "
        "cells, that is found in four nights of five at this n. Stable walks and distance count "
        "falls; the others compare walks that stayed up and covered half of the commanded distance."
    )


def _changes(outcome: Outcome) -> str:
    """What differs on purpose, and which trials differ without one."""
    lines = []
    if outcome.declared:
        lines.append(f"- Declared: {', '.join(outcome.declared)} changed since the baseline.")
    for name, then, now in outcome.surroundings:
        lines.append(f"- {name.replace('_', ' ')}: {then} -> {now}")
    return "\n".join(lines)


def _trials(outcome: Outcome) -> str:
    if not outcome.differing:
        return ""
    named = ", ".join(trial_id[:8] for trial_id in outcome.differing[:SHOWN])
    more = len(outcome.differing) - SHOWN
    named += f" and {more} more" if more > 0 else ""
    why = (
        "the versions, the processor or the code above did"
        if outcome.surroundings
        else "nothing that is known did: the simulation does not repeat itself here"
    )
    return (
        f"Other bits in {len(outcome.differing)} of {outcome.compared} trials whose declared "
        f"values have not changed; {why}. They are {named}."
    )


def _seams(before: Baseline, tonight: Baseline, outcome: Outcome) -> str:
    """From which code to which, for whoever looks for the culprit."""
    commits = [each.provenance.get("git_commit", ()) for each in (before, tonight)]
    if not all(commits) or outcome.mode == "exact":
        return ""
    first, last = (", ".join(commit) for commit in commits)
    return f"Code: {first} -> {last}"
