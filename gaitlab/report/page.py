"""The page of a report: its sections in order and the figures beside it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from gaitlab.report.cells import cell_tables, legend, paper_verdicts
from gaitlab.report.comparison import comparison
from gaitlab.report.falls import fall_phases, falls_table, metrics_table, reasons
from gaitlab.report.figure_style import save
from gaitlab.report.figures import fall_phases as fall_phases_figure
from gaitlab.report.figures import share_map
from gaitlab.report.headline import (
    HOW_TO_READ,
    PAPER_ROWS,
    compared_tables,
    headline,
    runs_table,
    seeds_text,
)
from gaitlab.report.markdown import escape, fenced, image, section
from gaitlab.report.pitch import pitch_caption, pitch_figure, pitch_panels, telling_cell
from gaitlab.report.provenance import Part, facts_table, part_tables
from gaitlab.report.results import Results
from gaitlab.report.rig import gantry_note
from gaitlab.report.sentences import sentences
from gaitlab.report.strip import strip_blocks
from gaitlab.report.walks import BESIDE_WALKS, walks_table
from gaitlab.report.words import plural


@dataclass(frozen=True, kw_only=True)
class Sources:
    """Where the results come from, for the end of the page.

    Attributes:
        facts: Name and Markdown text of each fact.
        parts: Things with parameters.
        grounds: Table of the grounds.
        command: What makes the page again.
    """

    facts: dict[str, str]
    parts: Sequence[Part]
    grounds: str
    command: str


def write_page(results: Results, sources: Sources, folder: Path) -> Path:
    """Write README.md and its figures into a folder; returns the page."""
    folder.mkdir(parents=True, exist_ok=True)
    blocks = [
        f"# {escape(results.title)}",
        escape(results.question),
        _completeness(results),
        f"Stable cells, {seeds_text(results)}:",
        headline(results),
        gantry_note(sources.parts),
        runs_table(results),
        HOW_TO_READ,
        PAPER_ROWS if compared_tables(results) else "",
        _what_this_says(results, sources),
        _cells(results, folder),
        comparison(results),
        _pitch(results, folder),
        _falls(results, folder),
        _metrics(results),
        _provenance(sources),
    ]
    page = folder / "README.md"
    page.write_text("\n\n".join(block for block in blocks if block) + "\n", encoding="utf-8")
    return page


def _completeness(results: Results) -> str:
    """What is missing, in one bold line; empty when every planned trial is there."""
    planned = len(results.trials)
    counts = results.trials["state"].value_counts()
    missing, failed = int(counts.get("MISSING", 0)), int(counts.get("FAILED", 0))
    parts = []
    if missing:
        parts.append(f"{planned - missing} of {planned} planned trials are in the store")
    if failed:
        parts.append(f"{plural(failed, 'trial')} failed and count nowhere")
    return f"**Incomplete: {'; '.join(parts)}.**" if parts else ""


def _what_this_says(results: Results, sources: Sources) -> str:
    assumed = sum(part.unpublished for part in sources.parts)
    return section("What this says", sentences(results, assumed))


def _cells(results: Results, folder: Path) -> str:
    if len(results.row_values) * len(results.column_values) < 2:
        return section("Cell by cell", legend(results), cell_tables(results))
    save(share_map(results, paper_verdicts(results)), folder, "stable_share")
    alt = f"Stable seeds of each cell, one panel a variant, for {results.title}"
    return section(
        "Cell by cell", legend(results), image(alt, "stable_share.png"), cell_tables(results)
    )


def _pitch(results: Results, folder: Path) -> str:
    place = telling_cell(results)
    panels = pitch_panels(results, *place) if place else []
    if place is None or not panels:
        return ""
    save(pitch_figure(panels), folder, "pitch")
    picture = image("Trunk pitch against time, one panel a variant", "pitch.png")
    walks = walks_table(results)
    beside = f"{BESIDE_WALKS}\n\n{walks}" if walks else ""
    return section("Pitch against time", picture, pitch_caption(results, *place), beside)


def _falls(results: Results, folder: Path) -> str:
    phases, picture = fall_phases(results), ""
    if phases:
        save(fall_phases_figure(phases), folder, "fall_phase")
        picture = image("Falls over the gait phase, one histogram a variant", "fall_phase.png")
    why = reasons(results)
    unplanned = f"### Trials without a result\n\n{why}" if why else ""
    return section(
        "Falls", falls_table(results), picture, *strip_blocks(results, folder), unplanned
    )


def _metrics(results: Results) -> str:
    table = metrics_table(results)
    note = "Median [quartiles] over all simulated trials, each measured up to its fall."
    return section("Other measures", note, table) if table else ""


def _provenance(sources: Sources) -> str:
    again = f"This page again:\n\n{fenced(sources.command, 'sh')}"
    parts = part_tables(sources.parts)
    return section("Provenance", facts_table(sources.facts), again, parts, sources.grounds)
