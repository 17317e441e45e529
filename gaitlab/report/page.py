"""The page of a report: its sections in order and the figures beside it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from gaitlab.picture.figure_style import save
from gaitlab.report.cells import cell_tables, legend
from gaitlab.report.comparison import comparison_blocks
from gaitlab.report.extremes import extremes_section
from gaitlab.report.falls import falls_by_phase, falls_table, reasons
from gaitlab.report.figures.fall_map import PHASES, fall_map
from gaitlab.report.headline import (
    HOW_TO_READ,
    PAPER_ROWS,
    compared_tables,
    headline,
    runs_table,
    seeds_text,
    verdicts_note,
)
from gaitlab.report.maps import cells_map, pair_maps
from gaitlab.report.markdown import details, escape, fenced, image, section
from gaitlab.report.matching import common
from gaitlab.report.measures import measures
from gaitlab.report.motion import motion
from gaitlab.report.provenance import Part, facts_table, part_tables
from gaitlab.report.results import Results
from gaitlab.report.rig import gantry_note
from gaitlab.report.scores import SCORED
from gaitlab.report.sentences import sentences
from gaitlab.report.strip import strip_blocks
from gaitlab.report.words import plural

MOST_OPEN_ROWS = 60  # of all tables of cells; more of them are folded away


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
    """

    facts: dict[str, str]
    parts: Sequence[Part]
    grounds: str
    command: str
    runs: str = ""
    options: str = ""


def write_page(results: Results, sources: Sources, folder: Path) -> Path:
    """Write README.md and its figures into a folder; returns the page."""
    folder.mkdir(parents=True, exist_ok=True)
    blocks = [
        heading(results),
        escape(results.question),
        _completeness(results, sources),
        verdicts_note(results),
        *scores(results),
        gantry_note(sources.parts),
        details("How to read these tables", *_how_to_read(results)),
        _what_this_says(results, sources),
        _comparison(results),
        _cells(results, folder),
        pair_maps(results, folder),
        measures(results, folder),
        _falls(results, folder),
        motion(results, folder),
        extremes_section(results, sources.options),
        _provenance(sources),
    ]
    page = folder / "README.md"
    page.write_text("\n\n".join(block for block in blocks if block) + "\n", encoding="utf-8")
    return page


def _is_whole(results: Results) -> bool:
    return bool(results.trials["state"].isin(SCORED).all())


def heading(results: Results) -> str:
    """The title, and how many of the planned trials a page speaks of unless of all."""
    there, planned = int(results.trials["state"].isin(SCORED).sum()), len(results.trials)
    part = "" if _is_whole(results) else f" ({there} of {planned} trials)"
    return f"# {escape(results.title)}{part}"


def scores(results: Results) -> list[str]:
    """The first tables. Of variants of which some lack runs, they count what all have."""
    if len(results.variants) < 2 or _is_whole(results):
        return [f"Stable cells, {seeds_text(results)}:", headline(results), runs_table(results)]
    shared = common(results)
    if shared.trials.empty:
        return ["**The variants have no run in common yet, so they are not compared.**"]
    runs = plural(len(shared.trials) // shared.trials["variant"].nunique(), "run")
    note = f"Stable cells, in the {runs} a variant that all of them have:"
    return [note, headline(shared), runs_table(shared)]


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


def _how_to_read(results: Results) -> list[str]:
    return [HOW_TO_READ, *([PAPER_ROWS] if compared_tables(results) else [])]


def _what_this_says(results: Results, sources: Sources) -> str:
    assumed = frozenset(item for part in sources.parts for item in part.unpublished)
    return section("What this says", sentences(results, len(assumed)))


def _comparison(results: Results) -> str:
    blocks = comparison_blocks(results)
    return section("Comparison", *blocks) if blocks else ""


def _cells(results: Results, folder: Path) -> str:
    picture, tables = cells_map(results, folder), cell_tables(results)
    rows = sum(line.startswith("| ") for line in tables.splitlines())
    if rows > MOST_OPEN_ROWS and picture:
        tables = details(f"The {plural(rows, 'row')} of the tables", tables)
    return section("Cell by cell", legend(results), picture, tables)


def _falls(results: Results, folder: Path) -> str:
    counts, picture = falls_by_phase(results, PHASES), ""
    if counts:
        save(fall_map(counts), folder, "falls")
        picture = image("Falls counted by direction and gait phase", "falls.png")
    why = reasons(results)
    unplanned = f"### Trials without a result\n\n{why}" if why else ""
    return section(
        "Falls", falls_table(results), picture, *strip_blocks(results, folder), unplanned
    )


def _provenance(sources: Sources) -> str:
    again = f"This page again:\n\n{fenced(sources.command, 'sh')}"
    parts = part_tables(sources.parts)
    return section("Provenance", facts_table(sources.facts), again, sources.grounds, parts)
