"""The gate's answer: a page of Markdown for people, one JSON object for a script."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from math import degrees, isfinite

from gaitlab.metrics import lookup
from gaitlab.regression.falls import Falls, WalkCounts
from gaitlab.regression.gate import GateResult
from gaitlab.regression.quantities import FALSE_ALARMS, Quantity
from gaitlab.store import Scalar

SHOWN = 10  # trials that are named
HEADER = ("quantity", "on", "baseline", "tonight", "change", "p worse", "finding", "would notice")


def outcome_page(experiment: str, outcome: GateResult) -> str:
    """The whole answer: verdict, falls and bits in the first line, then what they rest on."""
    lines = []
    if outcome.declared:
        lines.append(f"- Declared: {', '.join(outcome.declared)} changed since the baseline.")
    for name, then, now in outcome.surroundings:
        lines.append(f"- {name.replace('_', ' ')}: {then} -> {now}")
    code = f"Code: {' -> '.join(outcome.commits)}"  # for whoever looks for the culprit
    blocks = [
        f"# {headline(experiment, outcome)}",
        _sentence(outcome),
        _falls_table(outcome.falls),
        _table(outcome.quantities),
        _how(outcome),
        "\n".join(lines),
        _trials(outcome),
        code if outcome.commits and outcome.mode != "exact" else "",
    ]
    return "\n\n".join(block for block in blocks if block)


def headline(experiment: str, outcome: GateResult) -> str:
    """Verdict, falls before and tonight, and bits that differ, in one line."""
    joint = ", but " if outcome.undecided and outcome.falls.rose else "; "
    parts = [f"{_verdict(outcome)}{joint}{_fell(outcome.falls)}", _jump(outcome.falls)]
    if outcome.differing:
        parts.append(
            f"other bits in {len(outcome.differing)} of {outcome.compared} trials with equal ids"
        )
    return f"{experiment}: {'; '.join(part for part in parts if part)}"


def _verdict(outcome: GateResult) -> str:
    if outcome.undecided:
        return "the gate could not decide"
    if outcome.mode == "exact":
        return "nothing changed"
    return "worse than the baseline" if outcome.worse else "as good as the baseline"


def _fell(falls: Falls) -> str:
    before, tonight = falls.before, falls.tonight
    if before and tonight:
        return f"falls went from {_of(before)} to {_of(tonight)}{_alone(falls)}"
    parts = [
        f"{_of(before)} before" if before else "no baseline",
        f"{_of(tonight)} tonight" if tonight else "nothing walked tonight",
    ]
    return f"falls: {', '.join(parts)}"


def _alone(falls: Falls) -> str:
    """Falls of walks that have no partner: in new cells and seeds, and in those that are gone."""
    parts = [
        f"{_of(counts)} {where}"
        for counts, where in (
            (falls.alone_tonight, "that only tonight has"),
            (falls.alone_before, "that only the baseline has"),
        )
        if counts
    ]
    return f", besides {' and '.join(parts)}" if parts else ""


def _of(counts: WalkCounts) -> str:
    out = f" ({counts.out_of_reach} out of reach)" if counts.out_of_reach else ""
    return f"{counts.fell} of {counts.n}{out}"


def _jump(falls: Falls) -> str:
    """The cell that changed most, where the sum over several may hide it."""
    most = falls.jump
    if most is None or most.before is None or most.tonight is None or len(falls.cells) < 2:
        return ""
    return f"most at {_cell(most.cell)}, from {_of(most.before)} to {_of(most.tonight)}"


def _cell(values: Mapping[str, Scalar]) -> str:
    return ", ".join(f"{name} {value}" for name, value in values.items())


def _falls_table(falls: Falls) -> str:
    """Stable walks of each cell that changed, and of all."""
    if falls.before is None or falls.tonight is None:
        return ""
    if not falls.changed:
        text = f"Stable walks: {_stable(falls.before)} before, {_stable(falls.tonight)} tonight"
        return f"{text}; {'no cell changed' if falls.together else 'no cell is in both'}."
    rows = [
        ["cell", "stable before", "stable tonight"],
        ["---"] * 3,
        *(
            [_cell(cell.cell), _stable(cell.before), _stable(cell.tonight)]
            for cell in falls.changed
            if cell.before and cell.tonight
        ),
    ]
    if len(falls.cells) > 1:
        total = [_stable(falls.before), _stable(falls.tonight)]
        rows.append([f"all {len(falls.cells)} cells", *total])
    return _markdown(rows)


def _stable(counts: WalkCounts) -> str:
    return f"{counts.stable} of {counts.n}"


def _sentence(outcome: GateResult) -> str:
    if outcome.undecided:
        return outcome.undecided
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
    return _markdown([HEADER, ["---"] * len(HEADER), *(_row(each) for each in quantities)])


def _markdown(rows: Sequence[Sequence[str]]) -> str:
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


def _row(quantity: Quantity) -> list[str]:
    loud = quantity.finding in ("worse", "better")
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
        return "no change with so few seeds"
    sign = 1.0 if quantity.name != "stable" and lookup(quantity.name).better == "lower" else -1.0
    return _change(quantity, sign * quantity.detectable)


def _name(quantity: Quantity) -> str:
    return "stable walks" if quantity.name == "stable" else quantity.name.replace("_", " ")


def _unit(quantity: Quantity) -> str:
    return {"rad": " °", "-": ""}.get(lookup(quantity.name).unit, f" {lookup(quantity.name).unit}")


def _value(quantity: Quantity, value: float) -> str:
    if quantity.name == "stable":
        return f"{100.0 * value:.1f} %"
    shown = degrees(value) if lookup(quantity.name).unit == "rad" else value
    return f"{shown:.4g}{_unit(quantity)}"


def _change(quantity: Quantity, value: float) -> str:
    if quantity.name == "stable":
        return f"{100.0 * value:+.1f} points"
    shown = degrees(value) if lookup(quantity.name).unit == "rad" else value
    return f"{shown:+.2g}{_unit(quantity)}"


def _how(outcome: GateResult) -> str:
    if not outcome.quantities:
        return ""
    runs, seeds = outcome.runs, outcome.quantities[0].seeds
    matching = (
        f"pairs of equal cell and seed, of {seeds} seeds,"
        if runs.paired
        else f"walks a side, of {seeds} seeds, without common seeds"
    )
    test = "sign-flip test over seeds" if runs.paired else "rank sums, whole seeds shuffled"
    unshared = f" {runs.unshared} cells only one side has are left out." if runs.unshared else ""
    return (
        f"Compared: {runs.n} {matching} in {len(runs.cells)} cells.{unshared} A seed draws the "
        f"same servos and ground in every cell, so seeds count as independent, not walks ({test}). "
        "All tests of a night together raise a false alarm in at most "
        f"{100.0 * FALSE_ALARMS:.0f} % of nights in which nothing changed (Holm). "
        "*Would notice*: the smallest change for the worse, alike in all cells, "
        "that is found in four nights of five with so many seeds. "
        "Stable walks and distance count falls; the others compare walks that stayed up and "
        "covered half of the commanded distance."
    )


def _trials(outcome: GateResult) -> str:
    if not outcome.differing:
        return ""
    named = ", ".join(trial_id[:8] for trial_id in outcome.differing[:SHOWN])
    more = len(outcome.differing) - SHOWN
    named += f" and {more} more" if more > 0 else ""
    why = (
        "the versions, the processor or the code above did"
        if outcome.surroundings
        else "nothing that is known did: code of one's own goes by the clock, by chance or by what "
        "this machine is set to, or the simulation does not repeat itself here"
    )
    return (
        f"Other bits in {len(outcome.differing)} of {outcome.compared} trials whose declared "
        f"values have not changed; {why}. They are {named}."
    )


def outcome_json(experiment: str, outcome: GateResult) -> str:
    """The same keys whatever was decided; `reason` is null if something was."""
    return json.dumps(
        {
            "verdict": outcome.verdict,
            "exit_code": outcome.exit_code,
            "headline": headline(experiment, outcome),
            "reason": outcome.undecided or None,
            "mode": outcome.mode,
            "compared": outcome.runs.n,
            "falls": _falls_json(outcome.falls),
            "equal_ids": outcome.compared,
            "other_bits": list(outcome.differing),
            "worse": [_named(quantity) for quantity in outcome.worse],
            "better": [_named(quantity) for quantity in outcome.improved],
            "declared": list(outcome.declared),
            "surroundings": [
                {"name": name, "before": then, "tonight": now}
                for name, then, now in outcome.surroundings
            ],
            "tests": [_finite(quantity) for quantity in outcome.quantities],
        }
    )


def _falls_json(falls: Falls) -> dict[str, object]:
    """Counts of all and of each cell, before and tonight; null where a side has no walks."""
    return {
        "before": _counts_json(falls.before),
        "tonight": _counts_json(falls.tonight),
        "alone_before": _counts_json(falls.alone_before),
        "alone_tonight": _counts_json(falls.alone_tonight),
        "cells": [
            {
                "cell": dict(c.cell),
                "before": _counts_json(c.before),
                "tonight": _counts_json(c.tonight),
            }
            for c in falls.cells
        ],
    }


def _counts_json(counts: WalkCounts | None) -> dict[str, int] | None:
    return None if counts is None else {**asdict(counts), "n": counts.n}


def _named(quantity: Quantity) -> dict[str, str]:
    return {"quantity": quantity.name, "surface": quantity.surface or "all"}


def _finite(quantity: Quantity) -> dict[str, object]:
    return {
        name: None if isinstance(value, float) and not isfinite(value) else value
        for name, value in asdict(quantity).items()
    }
