"""An experiment to look at: its cells as a table, and in each the worst and the median walk in 3-D.

One HTML file, `replays.html`, beside that of the report, which leads to it. Of a study, whose
candidates are no cells, the walks are those of its winner and of the values before it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from html import escape
from pathlib import Path
from typing import TypeAlias

from gaitlab.documents.outputs import refuse_other
from gaitlab.documents.steps import expect, step
from gaitlab.errors import NothingRun
from gaitlab.experiment import Experiment, candidate
from gaitlab.render import Recorded, clip_of
from gaitlab.render.replay_page import Replay, address, write_replay_page
from gaitlab.report import write_report
from gaitlab.report.forms import REPORTS
from gaitlab.report.gather import gather
from gaitlab.report.representative import representative, worst
from gaitlab.report.results import ONE_ROW, Results
from gaitlab.report.study.findings import Findings
from gaitlab.report.study.gathering import findings_of
from gaitlab.report.study.page import write_study_report
from gaitlab.report.study.tables import near_misses
from gaitlab.report.variants import Value, Variant
from gaitlab.report.words import (
    cell_text,
    column_text,
    path_text,
    place_text,
    plural,
    verdict_text,
    with_unit,
)
from gaitlab.search.fresh import DEFAULT, WINNER, default_experiment, walked_again
from gaitlab.store import Store

FILE = "replays.html"
MOST_INSTANTS = 55_000  # of a page, at some 140 bytes each
FEWEST = 5.0  # instants in a second of walking, however many and long the walks


@dataclass(frozen=True, kw_only=True)
class Viewed:
    """What was written.

    Attributes:
        page: The report in HTML, whose cells lead to their walks.
        walks: The walks in 3-D, beside it.
        links: Where the walk of a trial is shown, by its id, relative to the folder.
    """

    page: Path
    walks: Path
    links: Mapping[str, str]


@dataclass(frozen=True, kw_only=True)
class _Chosen:
    """A trial of a cell that is shown, and what it is there."""

    trial_id: str
    role: str
    place: str


_Cells: TypeAlias = Mapping[tuple[str, Value, Value], Sequence[_Chosen]]  # by variant, row, column


def write_view(
    experiment: Experiment,
    store: Store,
    output: Path | None = None,
    *,
    storage: str | None = None,
    force: bool = False,
) -> Viewed:
    """Write the report of an experiment in HTML, and beside it the walks of its cells in 3-D.

    Args:
        experiment: What was asked.
        store: Where the trials are.
        output: Folder; by default `reports/<name>`.
        storage: Address of the database of a study, if it is not the store's own.
        force: Also replace files that gaitlab did not write.

    Raises:
        NothingRun: If none of its trials was run.
        UnknownName: If it is a study that was never searched.
        UsageError: If a file is there that gaitlab did not write.
        StoreError: If a log is damaged, or a file cannot be written.
    """
    folder = output or REPORTS / experiment.listed_as
    refuse_other(folder / FILE, b"<!DOCTYPE html>", force=force)
    if experiment.study is None:
        results = gather([experiment], store)
    else:
        results = _of_study(findings_of(experiment, store, storage), store)
    chosen = {
        (variant.label, row, column): list(_chosen(results, variant, row, column))
        for variant in results.variants
        for row in results.row_values
        for column in results.column_values
    }
    shown = [item for items in chosen.values() for item in items]
    expect(len({item.trial_id for item in shown}))
    links = {item.trial_id: FILE + address(item.trial_id) for item in shown}
    if experiment.study is None:
        page = write_report([experiment], store, folder, html=True, force=force, replays=links)
    else:
        page = write_study_report(
            [experiment], store, folder, storage=storage, html=True, force=force, replays=links
        )
    write_replay_page(
        _replays(results, shown),
        folder / FILE,
        title=f"{results.title}: replays",
        menu=_menu(results, chosen, page.name),
        first="" if results.done.empty else str(worst(results.done)["trial_id"]),
    )
    return Viewed(page=page, walks=folder / FILE, links=links)


def _of_study(findings: Findings, store: Store) -> Results:
    """The walks of a study that are looked at: its winner's, and those of the values before it.

    On every ground with fresh seeds; where these were not walked, as the search walked them. Of a
    study without a winner the candidate that misses least.

    Raises:
        NothingRun: If no candidate has walked.
    """
    study = findings.experiment
    walked = {one.label for one in findings.reruns if any(w.state == "DONE" for w in one.walks)}
    chosen = findings.chosen or next(iter(near_misses(findings)), None)
    if chosen is None:
        raise NothingRun(
            f"{study.name}: no candidate has walked yet, so there is nothing to look at; "
            f"`{findings.commands[0]}` searches"
        )
    shown = {}
    if findings.chosen and WINNER in walked:
        shown[f"winner, candidate {chosen.number}"] = walked_again(study, chosen)
    else:
        shown[f"candidate {chosen.number}"] = candidate(study, chosen.values)
    if DEFAULT in walked:
        shown[DEFAULT] = default_experiment(study)
    layout = replace(study.report, rows="surface", columns="surface", variants=(), compare=None)
    title = study.report.title or study.title or study.name
    experiments = [
        replace(one, report=replace(layout, label=label, title=title), description="")
        for label, one in shown.items()
    ]
    return replace(gather(experiments, store), question=study.description)


def _chosen(results: Results, variant: Variant, row: Value, column: Value) -> Iterator[_Chosen]:
    """The trials of a cell that stand for it; none where nothing was simulated to its end."""
    trials = results.at(variant, row, column)
    trials = trials[trials["state"] == "DONE"].drop_duplicates("trial_id")
    if trials.empty:
        return
    label = f", {variant.label}" if len(results.variants) > 1 else ""
    place = place_text(results, row, column) + label
    first, middle = str(worst(trials)["trial_id"]), representative(trials)
    if len(trials) == 1:
        yield _Chosen(trial_id=first, role="only seed", place=place)
        return
    both = first == middle
    yield _Chosen(trial_id=first, role="worst, median" if both else "worst", place=place)
    if not both:
        yield _Chosen(trial_id=middle, role="median", place=place)


def _replays(results: Results, chosen: Sequence[_Chosen]) -> Iterator[Replay]:
    """The walks one after another, each trial once; a long one has fewer instants a second."""
    once = {item.trial_id: item for item in reversed(chosen)}
    for number, (name, item) in enumerate(reversed(once.items()), start=1):
        step(f"walk {number} of {len(once)}")
        shown = Recorded(name, results.trial(name), results.log(name), item.place)
        clip = clip_of([shown.log])
        most = MOST_INSTANTS / len(once) / max(clip.end - clip.begin, 1.0)
        yield Replay(shown, replace(clip, fps=min(clip.fps, max(FEWEST, most))), item.role)


def _menu(results: Results, chosen: _Cells, report: str) -> str:
    """The tables of the cells, whose links choose what is shown."""
    trials = results.trials
    there = int((trials["state"] != "MISSING").sum())
    whole = f"{there} of " if there < len(trials) else ""
    parts = [
        f"<h1>{escape(results.title)}</h1>",
        f"<p>{escape(results.question)}</p>",
        f"<p>{whole}{plural(len(trials), 'trial')}. A cell has its verdict, its stable seeds of "
        f'all, and its walks; <a href="{escape(report)}">the report</a> has the rest.</p>',
    ]
    if results.done.empty:
        parts.append("<p><b>No trial was simulated to its end, so there is none to show.</b></p>")
    for variant in results.variants:
        if len(results.variants) > 1:
            parts.append(f"<h2>{escape(variant.label)}</h2>")
        parts.append(_table(results, variant, chosen))
    return "\n".join(parts)


def _table(results: Results, variant: Variant, chosen: _Cells) -> str:
    corner = "" if results.rows == ONE_ROW else path_text(results.rows)
    titles = [column_text(results, column) for column in results.column_values]
    head = "".join(f'<th scope="col">{escape(title)}</th>' for title in (corner, *titles))
    rows = []
    for row in results.row_values:
        name = "" if results.rows == ONE_ROW else with_unit(results, results.rows, row)
        cells = "".join(
            _cell(results, variant, row, column, chosen[variant.label, row, column])
            for column in results.column_values
        )
        rows.append(f'<tr><th scope="row">{escape(name)}</th>{cells}</tr>')
    body = "\n".join(rows)
    return f"<table>\n<thead><tr>{head}</tr></thead>\n<tbody>\n{body}\n</tbody>\n</table>"


def _cell(
    results: Results, variant: Variant, row: Value, column: Value, chosen: Sequence[_Chosen]
) -> str:
    """Verdict and count of a cell, and the ways to its walks."""
    cell = results.cell(variant, row, column)
    links = " ".join(
        f'<a href="{address(item.trial_id)}" title="{escape(item.place)}">{item.role}</a>'
        for item in chosen
    )
    if not cell.n or not cell.feasible:
        return f"<td>{escape(cell_text(cell))} {links}</td>"
    kind = "stable" if cell.verdict("stable") else "unstable"
    count = f"{verdict_text(cell)} {cell.count('stable')}/{cell.n}"
    return f'<td class="{kind}" title="{escape(cell_text(cell))}"><b>{count}</b>{links}</td>'
