"""The page of a report: one screen with the answer, and a second page with everything behind it.

Its sentences say in plain words what the tables show; every claim is computed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

from gaitlab.documents.steps import expect, step
from gaitlab.report.agreement import agreement, agreement_blocks, agreement_sentence
from gaitlab.report.cells import (
    CELLS,
    HOW_TO_READ,
    PRINTED_ROWS,
    cell_tables,
    headline,
    legend,
    reference_tables,
    runs_table,
    seeds_text,
    verdicts_note,
)
from gaitlab.report.comparison import (
    Comparison,
    compared_grounds,
    compared_variants,
    comparison_blocks,
    difference,
)
from gaitlab.report.falls import falls_table, metrics_table, reasons
from gaitlab.report.maps import cells_map, pair_maps
from gaitlab.report.markdown import DETAILS, details, escape, fenced, section, write_pages
from gaitlab.report.matching import common, places
from gaitlab.report.motion import motion_blocks
from gaitlab.report.provenance import DescribedPart, facts_table, gantry_note, part_tables
from gaitlab.report.representative import extremes_blocks
from gaitlab.report.results import Results
from gaitlab.report.scores import SCORED, fell_standing, truth
from gaitlab.report.thresholds import threshold_tables
from gaitlab.report.words import plural
from gaitlab.statistics import MOST_SEEDS, Contrast

USUAL_FIGURES = 6  # the cells, two strips, balance, feet and joints; maps come on top
MOST_SENTENCES = 3  # below the picture
FEWEST_SEEDS = 6  # of fewer no number of seeds that would tell is known
USUAL_SEEDS = 10  # a cell, of the papers
MEDIANS = "Median [quartiles] over all simulated trials."
Compared: TypeAlias = tuple[list[Comparison], list[Comparison]]  # of variants, of grounds


@dataclass(frozen=True, kw_only=True)
class Sources:
    """Where the results come from, for the end of the page.

    Attributes:
        facts: Name and Markdown text of each fact.
        parts: Things with parameters.
        grounds: Table of the grounds.
        command: What makes the page again.
        runs: What simulates the trials that are missing.
        options: What a command on one of the trials needs besides its name.
        differences: Table of what differs in the files of several experiments; empty for one.
        with_seeds: What simulates and reports the experiments with so many seeds a cell.
    """

    facts: dict[str, str]
    parts: Sequence[DescribedPart]
    grounds: str
    command: str
    runs: str = ""
    options: str = ""
    differences: str = ""
    with_seeds: Callable[[int], str] | None = None


def write_page(results: Results, sources: Sources, folder: Path) -> Path:
    """Write README.md, details.md and their figures into a folder; returns README.md."""
    expect(1 + USUAL_FIGURES)
    step(f"comparing {plural(len(results.trials), 'trial')}")
    compared = compared_variants(results), compared_grounds(results)
    folder.mkdir(parents=True, exist_ok=True)
    first = _first(results, sources, compared, folder)
    return write_pages(folder, first, _second(results, sources, compared, folder))


def _first(results: Results, sources: Sources, compared: Compared, folder: Path) -> list[str]:
    """The answer, what to do next and what it rests on; the walks themselves folded."""
    engines = agreement(results)
    return [
        heading(results),
        escape(results.question),
        _completeness(results, sources),
        gantry_note(sources.parts),
        not_standing(results),
        sources.differences,
        *scores(results, compared[0]),
        threshold_tables(results),
        cells_map(results, folder),
        findings(results, *compared, agreement_sentence(engines) if engines else ""),
        _next(results, sources, compared),
        _rests_on(results, sources),
        details(
            "The walks that differ most, drawn from their logs", *motion_blocks(results, folder)
        ),
        details("The best and the worst walk", *extremes_blocks(results, sources.options)),
    ]


def _second(results: Results, sources: Sources, compared: Compared, folder: Path) -> list[str]:
    """Everything that the answer rests on."""
    contrasts, why = comparison_blocks(results, *compared), reasons(results)
    printed = PRINTED_ROWS if reference_tables(results) else ""
    measured, engines = metrics_table(results), agreement(results)
    return [
        f"{heading(results)}: details",
        "The answer is on [the page itself](README.md).",
        section(CELLS, legend(results), cell_tables(results)),
        section("Stable cells", verdicts_note(results), headline(results), HOW_TO_READ, printed),
        section("Comparison", *contrasts) if contrasts else "",
        section("Agreement of the engines", *agreement_blocks(results, engines)) if engines else "",
        pair_maps(results, folder),
        section("Falls", falls_table(results)),
        section("Trials without a result", why) if why else "",
        section("Measures", MEDIANS, measured) if measured else "",
        section(
            "Provenance",
            facts_table(sources.facts),
            f"This page again:\n\n{fenced(sources.command, 'sh')}",
            sources.grounds,
            part_tables(sources.parts),
        ),
    ]


def _is_whole(results: Results) -> bool:
    return bool(results.trials["state"].isin(SCORED).all())


def _walked(results: Results) -> int:
    """Variants with a run that is scored."""
    return int(results.trials[results.trials["state"].isin(SCORED)]["variant"].nunique())


def heading(results: Results) -> str:
    """The title, and how many of the planned trials a page speaks of unless of all."""
    there, planned = int(results.trials["state"].isin(SCORED).sum()), len(results.trials)
    part = "" if _is_whole(results) else f" ({there} of {planned} trials{_shared(results)})"
    return f"# {escape(results.title)}{part}"


def _shared(results: Results) -> str:
    """In how many cells the variants of a part are compared; empty where one alone has walked."""
    if _walked(results) < 2:
        return ""
    cells = common(results).trials.drop_duplicates(places(results))
    return f", compared in the {plural(len(cells), 'cell')} that all have"


def scores(results: Results, compared: Sequence[Comparison] = ()) -> list[str]:
    """The first table with the differences of the variants.

    Where some variants lack runs, it counts what all of them have.
    """
    if _walked(results) < 2 or _is_whole(results):
        return [f"Stable runs, {seeds_text(results)}:", runs_table(results, compared)]
    shared = common(results)
    if shared.trials.empty:
        return ["**The variants have no run in common yet, so they are not compared.**"]
    runs = plural(len(shared.trials) // shared.trials["variant"].nunique(), "run")
    return [
        f"Stable runs, of the {runs} a variant that all of them have:",
        runs_table(shared, compared),
    ]


def _completeness(results: Results, sources: Sources) -> str:
    """What is missing and how to get it; empty when every planned trial is there."""
    planned = len(results.trials)
    counts = results.trials["state"].value_counts()
    missing, failed = int(counts.get("MISSING", 0)), int(counts.get("FAILED", 0))
    parts = []
    if missing:
        parts.append(f"{planned - missing} of {planned} planned trials are in the store")
    if failed:
        parts.append(f"{plural(failed, 'trial')} failed and count nowhere")
    if not parts:
        return ""
    rest = f"The rest:\n\n{fenced(sources.runs, 'sh')}" if missing and sources.runs else ""
    return "\n\n".join(part for part in (f"**Incomplete: {'; '.join(parts)}.**", rest) if part)


def _next(results: Results, sources: Sources, compared: Compared) -> str:
    """The command that would tell more; empty where the rest of the trials comes first."""
    items = [*compared[0], *compared[1]]
    seeds = seeds_needed(items)
    few = results.trials["seed"].nunique() < FEWEST_SEEDS
    if seeds is None and few and any(item.stable.verdict == "cannot tell" for item in items):
        seeds = USUAL_SEEDS
    if seeds is None or sources.with_seeds is None or not _is_whole(results):
        return ""
    return f"To tell more:\n\n{fenced(sources.with_seeds(seeds), 'sh')}"


def _rests_on(results: Results, sources: Sources) -> str:
    """In one line what was simulated, what was assumed, and where to read on."""
    assumed = frozenset(item for part in sources.parts for item in part.unpublished)
    there, planned = int(results.trials["state"].isin(SCORED).sum()), len(results.trials)
    trials = plural(planned, "trial") if there == planned else f"{there} of {planned} trials"
    counts = f"{trials}, {seeds_text(results)}"
    hidden = (
        f", and {plural(len(assumed), 'parameter')} of robot, gait, servos and ground that nobody "
        "published (bold there)"
        if assumed
        else ""
    )
    return (
        f"This rests on {counts}{hidden}. [Details]({DETAILS}): every cell, every comparison, "
        "falls, parameters with their sources, versions, and how to make this page again."
    )


def findings(
    results: Results,
    variants: Sequence[Comparison],
    grounds: Sequence[Comparison],
    engines: str = "",
) -> str:
    """What can be told apart in staying up and what cannot, in at most three sentences.

    Of variants, then of engines as that sentence says, then of grounds; the second page has all.
    """
    if results.done.empty:
        return "No trial has been simulated to its end, so nothing can be said."
    first = ""
    if _walked(results) < 2:
        runs = results.done
        falls, standing = int(truth(runs["fell"]).sum()), fell_standing(runs)
        early = f", in {standing} of them before its first step" if standing else ""
        first = f"The robot fell in {falls} of {plural(len(runs), 'simulated run')}{early}."
    elif not any(item.runs.n for item in variants):
        first = "The variants have no run in common, so nothing is said of what differs."
    of_grounds = (told_apart(grounds), not_told_apart(grounds))
    said = (first, told_apart(variants), not_told_apart(variants), engines, *of_grounds)
    return " ".join([text for text in said if text][:MOST_SENTENCES])


def told_apart(found: Sequence[Comparison]) -> str:
    """Which stays up more or less often than the first, in a sentence; empty if none does."""
    said = []
    for verdict, often in (("better", "more"), ("worse", "less")):
        items = [item for item in found if item.stable.verdict == verdict]
        if items:
            verb = "stays" if len(items) == 1 else "stay"
            said.append(_listed(items, f"{verb} up {often} often than *FIRST*"))
    return f"{'; '.join(said)}." if said else ""


def not_told_apart(found: Sequence[Comparison]) -> str:
    """Which cannot be told from the first, and how many seeds would tell; empty if all are."""
    items = [item for item in found if item.stable.verdict == "cannot tell"]
    if not items:
        return ""
    advice = max((item.stable for item in items), key=_seeds).advice
    text = _listed(items, "cannot be told from *FIRST* in staying up")
    return f"{text}; {advice}." if advice else f"{text}."


def seeds_needed(found: Sequence[Comparison]) -> int | None:
    """Seeds a cell that would tell the differences that are not told; None if no number would."""
    asked = [_seeds(item.stable) for item in found if item.stable.verdict == "cannot tell"]
    return int(max(asked, default=0.0)) or None


def _seeds(stable: Contrast) -> float:
    """Seeds that would tell, 0 where nobody would wait for them."""
    return stable.needed if stable.needed <= MOST_SEEDS else 0.0


def _listed(items: Sequence[Comparison], verb: str) -> str:
    """Who does what, with the differences and what they rest on."""
    names = [f"*{escape(item.second)}*" for item in items]
    done = verb.replace("FIRST", escape(items[0].first))
    if len(items) == 1:
        return f"{names[0]} {done}: {difference(items[0].stable)} over {items[0].counted}"
    gaps = (difference(item.stable) for item in items)
    listed = ", ".join(f"{name} ({gap})" for name, gap in zip(names, gaps, strict=True))
    return f"{listed} {done}"


def not_standing(results: Results) -> str:
    """Cells whose robot falls before it is told to step; empty if there are none."""
    cells = [cell for v in results.variants for cells in results.by_column(v) for cell in cells]
    known = [cell for cell in cells if cell.n]
    fallen = sum(not cell.stands for cell in known)
    if not fallen:
        return ""
    return (
        f"**In {fallen} of {plural(len(known), 'cell')} the robot does not stand: most seeds fell "
        "before their first step, which says nothing of the gait.**"
    )
