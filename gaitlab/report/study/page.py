"""The page of a study, and the page that sets several side by side."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path

from matplotlib.figure import Figure

from gaitlab.documents.steps import expect, step
from gaitlab.errors import UsageError
from gaitlab.experiment import Experiment
from gaitlab.experiment.shell import store_option
from gaitlab.render.figure_style import save
from gaitlab.report.forms import REPORTS, publish
from gaitlab.report.forms.explorer import replays_beside
from gaitlab.report.markdown import DETAILS, escape, fenced, image, section, table, write_pages
from gaitlab.report.provenance import facts_table
from gaitlab.report.study import figures, tables
from gaitlab.report.study.explorer import StudyExplorer
from gaitlab.report.study.findings import Findings
from gaitlab.report.study.fresh import Crossing, crossings, crossings_table, score, stable_of
from gaitlab.report.study.gathering import findings_of
from gaitlab.report.study.sentences import chance, question, random_command, sentences
from gaitlab.report.study.words import UNKNOWN, interval, number, objective_axis, objective_text
from gaitlab.report.words import plural, share, surface_text
from gaitlab.search.fresh import WINNER
from gaitlab.statistics import RESAMPLES, wilson
from gaitlab.store import Store

HOW_TO_READ = f"""\
Intervals are 95 %: of shares by Wilson, of objectives by drawing the seeds again {RESAMPLES} times.
A lead counts as better or worse when its interval excludes zero. Importance is PED-ANOVA's: where a
parameter's values lie among the best tenth of the candidates against all. It sees one parameter at
a time, and a sampler that has settled hides what it settled on: a parameter of little importance
may still fell the robot, see the margins."""
FINAL = """\
The best of many candidates is also the luckiest, so the best few walked with as many seeds again,
and all of these decided."""
PEER = """\
For comparison: the closest published tool, [bit-bots/parallel_parameter_search]\
(https://github.com/bit-bots/parallel_parameter_search) of 2022 (13 parameters, PyBullet and
Webots, one rigid floor, one repetition), gives 8 to 24 hours on a 12-core Ryzen 5900X for 1000
trials of 10 s a direction."""


def write_study_report(
    experiments: Sequence[Experiment],
    store: Store,
    output: Path | None = None,
    *,
    storage: str | None = None,
    html: bool = False,
    tables: bool = False,
    force: bool = False,
    replays: Mapping[str, str] | None = None,
) -> Path:
    """Write the report of one or several studies; nothing is simulated.

    Args:
        experiments: Studies. Several get a page that sets them side by side, with a folder each
            for their own pages.
        store: Where the trials are.
        output: Folder of the page and its figures; by default `reports/<names>`.
        storage: Address of the database, if it is not the store's own.
        html: Also write the page as one file of HTML.
        tables: Also write every table as LaTeX and CSV.
        force: Also write into a folder that holds files of somebody else.
        replays: Link to the replay of a trial by its id, relative to the page of one study in
            HTML; by default to those that lie beside it, `replays/ID.html`.

    Returns:
        The page, in HTML if that was asked for.

    Raises:
        UsageError: If one is no study.
        UnknownName: If one was never searched on this store.
    """
    plain = [one.name for one in experiments if one.study is None]
    if plain:
        raise UsageError(
            f"{' and '.join(plain)}: no study, and studies are reported apart from experiments; "
            "give `gaitlab report` either only studies or only experiments"
        )
    expect(1 + 3 * len(experiments))  # figures of a study: margins, grounds, the search
    step(f"reading the candidates of {' and '.join(one.name for one in experiments)}")
    found = [findings_of(one, store, storage) for one in experiments]
    folder = output or REPORTS / "+".join(one.name for one in experiments)
    write = partial(write_pages_together, found)
    explorer = None
    if len(found) == 1:
        write = partial(write_study_page, found[0])
        explorer = _explorer(found[0], store, folder, replays) if html else None
    return publish(folder, write, html=html, tables=tables, force=force, explorer=explorer)


def _explorer(
    findings: Findings, store: Store, folder: Path, replays: Mapping[str, str] | None
) -> StudyExplorer | None:
    """What opens the candidates; None where none was tried."""
    if not findings.candidates:
        return None
    if replays is None:
        tried = [trial for one in findings.candidates for trial in one.trial_ids]
        again = [walk.trial_id for one in findings.reruns for walk in one.walks]
        replays = replays_beside(folder, [*tried, *again])
    options = "".join(f" {shlex.quote(word)}" for word in store_option(store.path))
    return StudyExplorer(findings=findings, store=store, replays=replays, options=options)


def write_study_page(findings: Findings, folder: Path) -> Path:
    """Write README.md, details.md and their figures into a folder; returns README.md."""
    folder.mkdir(parents=True, exist_ok=True)
    rows = crossings(findings)
    history = _history(findings, folder)
    picture = _picture(findings, rows, folder) or history
    found: list[str] = []
    if findings.chosen:
        found = [tables.fresh_table(findings), tables.winner_table(findings)]
    elif findings.candidates:
        found = ["The nearest misses:", tables.near_misses_table(findings)]
    first = [
        f"# {escape(findings.experiment.title or findings.experiment.name)}",
        escape(findings.experiment.description),
        question(findings) if findings.candidates else "No candidate has been tried yet.",
        *found,
        picture,
        sentences(findings) if findings.candidates else "",
        _next(findings),
        _rests_on(findings),
    ]
    behind = "" if picture == history else history
    return write_pages(folder, first, _second(findings, rows, folder, behind))


def _picture(findings: Findings, rows: dict[str, dict[str, Crossing]], folder: Path) -> str:
    """How far the winner may drift; without that where it walks, if anywhere."""
    margins = findings.margins
    if margins is not None and margins.seeds and margins.numbers:
        alt = "How far each parameter may move from the winner before a seed falls"
        return _figure(figures.margins(findings, margins.numbers), folder, "margins", alt)
    axis = objective_axis(findings.study.objectives[0])
    return _crossings_picture(rows, axis, folder)


def _next(findings: Findings) -> str:
    """What to run next; nothing where random search has been run."""
    if findings.drawn or not findings.candidates or findings.chosen is None:
        return ""
    if (winner := findings.rerun(WINNER)) is None or not winner.on(findings.grounds):
        return f"To walk it on fresh seeds:\n\n{fenced(findings.commands[0], 'sh')}"
    return f"To know whether it beats chance:\n\n{fenced(random_command(findings), 'sh')}"


def _rests_on(findings: Findings) -> str:
    walks = sum(len(rerun.on(findings.grounds)) for rerun in findings.reruns)
    return (
        f"This rests on {plural(len(findings.candidates), 'candidate')} and "
        f"{plural(walks, 'walk')} with fresh seeds, of the simulated robot and grounds, whose "
        f"assumptions `gaitlab show` lists. [Details]({DETAILS}): constraints, other grounds, "
        "margins, the search, versions, and how to make this page again."
    )


def _second(
    findings: Findings, rows: dict[str, dict[str, Crossing]], folder: Path, history: str
) -> list[str]:
    """Everything that the answer rests on; the history of the search if it is not in front."""
    front = len(findings.study.objectives) > 1 and findings.front
    margins = findings.margins
    return [
        f"# {escape(findings.experiment.title or findings.experiment.name)}: details",
        "The answer is on [the page itself](README.md).",
        section("How to read it", HOW_TO_READ, chance(findings)),
        _part("Constraints", tables.constraints_table(findings)),
        _part("The final", tables.final_table(findings), FINAL) if findings.finals else "",
        crossings_section(rows, objective_axis(findings.study.objectives[0]), folder),
        _part(
            "How far may each parameter drift?",
            "\n\n".join(
                part
                for part in (tables.margins_table(findings), tables.switches_table(findings))
                if part
            ),
            _margins_note(findings),
        )
        if margins is not None and margins.seeds
        else "",
        section(
            "Pareto front",
            "No candidate of the front is beaten by another in every objective.",
            _figure(figures.front(findings), folder, "front", "Objectives against each other"),
            tables.front_table(findings),
        )
        if front
        else "",
        _search(findings, history),
        section(
            "Provenance",
            facts_table(findings.facts),
            f"This page again:\n\n{fenced(chr(10).join(findings.commands), 'sh')}",
        ),
    ]


def _part(title: str, body: str, note: str = "") -> str:
    """A section; empty without a body."""
    return section(title, note, body) if body else ""


def _figure(figure: Figure, folder: Path, name: str, alt: str) -> str:
    save(figure, folder, name)
    return image(alt, f"{name}.png")


def _crossings_picture(rows: dict[str, dict[str, Crossing]], units: str, folder: Path) -> str:
    if not rows:
        return ""
    alt = "Stable share of each gait on each ground; a frame marks the grounds it was tuned on"
    return _figure(figures.crossings(rows, units), folder, "tuned_on_run_on", alt)


def crossings_section(rows: dict[str, dict[str, Crossing]], units: str, folder: Path) -> str:
    """Tuned on one ground and run on another, as a picture and a table; empty without rows."""
    if not rows:
        return ""
    note = "Every row walked with the same fresh seeds. Bold or framed: the ground it was tuned on."
    picture = _crossings_picture(rows, units, folder)
    return section("Tuned on one ground, run on another", note, picture, crossings_table(rows))


def _margins_note(findings: Findings) -> str:
    margins = findings.margins
    if margins is None:
        return ""
    unfinished = "" if margins.complete else " **Incomplete: some of these walks have not run.**"
    return (
        "Each parameter moved alone, outwards from the winner until a seed falls that stays up at "
        f"the winner, then halved twice; n = {margins.seeds} seeds on every ground of the study. "
        f"Limits may lie outside the searched range.{unfinished}"
    )


def _history(findings: Findings, folder: Path) -> str:
    if not findings.candidates:
        return ""
    alt = "Objective of every candidate in the order of the search, and the best so far"
    return _figure(figures.history(findings), folder, "history", alt)


def _search(findings: Findings, history: str) -> str:
    if not findings.candidates:
        return ""
    note = "A candidate that was given up early stands at what its first seeds gave."
    rate = ""
    if findings.wall:
        rate = (
            f"The walks of the search took {findings.wall / 60.0:.1f} core minutes: "
            f"{findings.used / findings.wall:.1f} simulated robot-seconds per second of one core."
        )
    return section("The search", history, note, tables.search_table(findings), rate, PEER)


def write_pages_together(found: Sequence[Findings], folder: Path) -> Path:
    """Write README.md over several studies, and a folder below it for the page of each."""
    for findings in found:
        write_study_page(findings, folder / findings.experiment.name)
    names = " and ".join(findings.experiment.name for findings in found)
    axes = {objective_axis(findings.study.objectives[0]) for findings in found}
    units = axes.pop() if len(axes) == 1 else "first objective of each study"
    runs = [findings.commands[0] for findings in found]
    report = f"gaitlab report {' '.join(findings.called for findings in found)}"
    rest = found[0].commands[1].partition(found[0].called)[2]
    again = fenced("\n".join([*runs, report + rest]), "sh")
    blocks = [
        f"# {escape(names)}",
        "What each study found, on seeds that no search saw; its own page is linked.",
        _studies(found),
        crossings_section(rows_of(found), units, folder),
        section("Provenance", f"This page again:\n\n{again}"),
    ]
    page = folder / "README.md"
    page.write_text("\n\n".join(block for block in blocks if block) + "\n", encoding="utf-8")
    return page


def rows_of(found: Sequence[Findings]) -> dict[str, dict[str, Crossing]]:
    """Rows of all studies in one matrix; a default that several share stands there once."""
    rows: dict[str, dict[str, Crossing]] = {}
    for findings in found:
        for label, row in crossings(findings).items():
            free = (
                label if rows.get(label, row) == row else f"{label} of {findings.experiment.name}"
            )
            rows[free] = row
    return rows


def _studies(found: Sequence[Findings]) -> str:
    rows = [
        [
            f"[{escape(findings.experiment.name)}]({findings.experiment.name}/README.md)",
            escape(", ".join(surface_text(name) for name in findings.grounds)),
            *_result(findings),
        ]
        for findings in found
    ]
    return table(["study", "tuned on", "asked", "on fresh seeds", "stable there"], rows, "lllrr")


def _result(findings: Findings) -> list[str]:
    wanted = escape(objective_text(findings.study.objectives[0], len(findings.grounds)))
    winner = findings.rerun(WINNER)
    walks = winner.on(findings.grounds) if winner else ()
    if not walks:
        return [wanted, UNKNOWN, UNKNOWN]
    again, (up, n) = score(findings.study, walks, 0), stable_of(walks)
    text = f"{number(again.value)} {escape(interval(again.interval))}".rstrip()
    return [wanted, text, share(up, n, wilson(up, n))]
