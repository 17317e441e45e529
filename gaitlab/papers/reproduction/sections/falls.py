"""Why a cell falls and what the optimisation changes, from the logs: three tables and a strip."""

from __future__ import annotations

from typing import cast

from gaitlab.papers.reproduction.section import Context, Section, option
from gaitlab.report.before_falls import (
    Pairs,
    body_log,
    contrast_table,
    contrasts_of,
    falls_table,
    firmness,
    firmness_table,
    last_stands,
    pairs_of,
)
from gaitlab.report.gather import gather
from gaitlab.report.markdown import escape
from gaitlab.report.motion import strip_blocks
from gaitlab.report.results import Results
from gaitlab.report.words import surface_text

OPTIONS = (
    option("reference", str, "", "ground to compare with; by default the one with fewest falls"),
    option("variants", tuple[str, ...], (), "labels of the variants to look at; all by default"),
    option("film", bool, True, "draw one fall and the same seed with the second variant"),
)
METHOD = """\
A walk that falls is looked at in the gait cycle that ends where it last stood well: ZMP at least
5 mm inside the support polygon and the trunk tilted by no more than 20°; landings over two cycles.
Its partner of equal step and seed is looked at in the same cycle, of two falls in that of the
earlier one. Means differ with 95 % intervals over seeds; **bold** where all differences of the
table together (Holm) tell the two apart. What differs before falls need not be their cause: walks
picked because they fall look worse just then than almost any others."""
FIRMNESS = """\
*Holds* is the moment that the settled sole puts up against tipping over that of gravity on a stiff
robot above one foot, by the law of the pile, not simulated. Below 1 it cannot stand; servos that
yield take from it."""
BEGINNING = """\
*First* is the axis in which the trunk first left what it did in the cycle before; in the start-up,
where the sway still grows, it says little."""


def falls_section(section: Section, context: Context) -> str:
    """Why walks fall on each ground, as Markdown; the strip goes beside the page."""
    results = _together(section, context)
    named = cast(tuple[str, ...], section.options["variants"])
    labels = [] if results is None else _simulated(results, named)
    if results is None or not labels:
        return "Nothing was simulated yet."
    done = last_stands(results, context.store, labels)
    grounds = [str(name) for name in dict.fromkeys(done["surface"])]
    base = done[done["variant"] == labels[0]]
    shares = base.groupby("surface", sort=False)["fell"].mean()
    reference = str(section.options["reference"]) or str(shares.idxmin())
    falls = base[base["fell"]]
    elsewhere, changed = {}, {}
    for ground in grounds:
        here = falls[falls["surface"] == ground]
        if ground != reference:
            there = base[base["surface"] == reference]
            elsewhere[surface_text(ground)] = pairs_of(there, here, results.rows)
        for label in labels[1:]:
            other = done[(done["surface"] == ground) & (done["variant"] == label)]
            changed[f"{label}, {surface_text(ground)}"] = pairs_of(here, other, results.rows)
    what, place = escape(labels[0]), escape(surface_text(reference))
    blocks = [
        METHOD,
        falls_table(done, grounds, labels),
        BEGINNING,
        *_block(context, f"Falls of *{what}* less the same step and seed on {place}", elsewhere),
        *_block(context, f"Other variants less the same walk of *{what}*, where it falls", changed),
        *_ground_holds(results, context, grounds, labels[0]),
        *(strip_blocks(results, context.folder) if section.options["film"] else []),
    ]
    return "\n\n".join(block for block in blocks if block)


def _together(section: Section, context: Context) -> Results | None:
    """One table of all members of the section that the store holds trials of."""
    names = [name for name in section.experiments if name in context.results]
    if len(names) <= 1:
        return context.results[names[0]] if names else None
    return gather([context.experiments[name] for name in names], context.store)


def _simulated(results: Results, named: tuple[str, ...]) -> list[str]:
    """Variants of which a trial was simulated, and that are asked for if any are."""
    return [
        variant.label
        for variant in results.variants
        if (not named or variant.label in named) and len(results.done_of(variant))
    ]


def _block(context: Context, title: str, compared: dict[str, Pairs]) -> list[str]:
    table = contrast_table(contrasts_of(context.store, compared))
    return [f"### {title}", table] if table else []


def _ground_holds(results: Results, context: Context, grounds: list[str], label: str) -> list[str]:
    held, fell = {}, {}
    for ground in grounds:
        walks = results.done[results.done["surface"] == ground]
        name = str(walks["trial_id"].iloc[0])
        held[ground] = firmness(results.trial(name), body_log(context.store, name))
        ours = walks[walks["variant"] == label]
        fell[ground] = f"{int(ours['fell'].astype(bool).sum())} of {len(ours)}"
    return ["### What the ground holds", firmness_table(held, fell, label), FIRMNESS]
