"""The page of a study: its sections in order and the figures beside it."""

from __future__ import annotations

from pathlib import Path

from matplotlib.figure import Figure

from gaitlab.render.figure_style import save
from gaitlab.report.markdown import escape, fenced, image, section
from gaitlab.report.provenance import facts_table
from gaitlab.report.study import robustness_figures, search_figures, search_tables, tables
from gaitlab.report.study.crossings import Crossing, crossings, crossings_table
from gaitlab.report.study.findings import Findings
from gaitlab.report.study.fresh import RESAMPLES
from gaitlab.report.study.sentences import random_command, sentences
from gaitlab.report.study.words import objective_axis, objective_text

HOW_TO_READ = (
    "Intervals are 95 %: of shares by Wilson, of objectives by drawing the seeds again "
    f"{RESAMPLES} times. A lead counts as better or worse when its interval excludes zero."
)
IMPORTANCE_CAVEAT = (
    "PED-ANOVA compares where a parameter's values lie among the best tenth of the candidates "
    "with where they lie among all. It sees one parameter at a time, no interactions, and a "
    "sampler that has settled hides what it settled on: a parameter of little importance here "
    "may still fell the robot, see the margins."
)
PEER = (
    "For comparison: the closest published tool, [bit-bots/parallel_parameter_search]"
    "(https://github.com/bit-bots/parallel_parameter_search) of 2022 (13 parameters, PyBullet and "
    "Webots, one rigid floor, one repetition), gives 8 to 24 hours on a 12-core Ryzen 5900X for "
    "1000 trials of 10 s a direction."
)


def write_study_page(findings: Findings, folder: Path) -> Path:
    """Write README.md and its figures into a folder; returns the page."""
    folder.mkdir(parents=True, exist_ok=True)
    title = findings.experiment.title or findings.experiment.name
    blocks = [
        f"# {escape(title)}",
        escape(findings.experiment.description),
        sentences(findings),
        *(_found(findings, folder) if findings.chosen else _nothing_found(findings)),
        _search(findings, folder),
        _importance(findings, folder),
        _provenance(findings),
    ]
    page = folder / "README.md"
    page.write_text("\n\n".join(block for block in blocks if block) + "\n", encoding="utf-8")
    return page


def _figure(figure: Figure, folder: Path, name: str, alt: str) -> str:
    save(figure, folder, name)
    return image(alt, f"{name}.png")


def _found(findings: Findings, folder: Path) -> list[str]:
    constraints = tables.constraints_table(findings)
    return [
        section("The winner", tables.winner_table(findings), HOW_TO_READ),
        section(
            "Is the winner real?",
            _final(findings),
            tables.fresh_table(findings),
            tables.gains_table(findings),
            constraints,
            _missing_baseline(findings),
        ),
        _crossings(findings, folder),
        _margins(findings, folder),
        _front(findings, folder),
    ]


def _final(findings: Findings) -> str:
    if not findings.finals:
        return ""
    note = (
        "The best of many candidates is also the luckiest, so the best few walked with as many "
        "seeds again, and all of these decided."
    )
    return f"{note}\n\n{search_tables.final_table(findings)}"


def _missing_baseline(findings: Findings) -> str:
    if findings.drawn:
        return ""
    command = fenced(random_command(findings), "sh")
    return f"Against random search with the same budget, once this has run:\n\n{command}"


def _nothing_found(findings: Findings) -> list[str]:
    if not findings.candidates:
        return []
    return [section("The nearest misses", search_tables.near_misses_table(findings))]


def _crossings(findings: Findings, folder: Path) -> str:
    rows = crossings(findings)
    if not rows:
        return ""
    return crossings_section(rows, objective_axis(findings.study.objectives[0]), folder)


def crossings_section(rows: dict[str, dict[str, Crossing]], units: str, folder: Path) -> str:
    """Tuned on one ground and run on another, as a picture and a table."""
    picture = _figure(
        robustness_figures.crossings(rows, units),
        folder,
        "tuned_on_run_on",
        "Stable share of each gait on each ground; a frame marks the grounds it was tuned on",
    )
    note = "Every row walked with the same fresh seeds. Bold or framed: the ground it was tuned on."
    return section("Tuned on one ground, run on another", note, picture, crossings_table(rows))


def _margins(findings: Findings, folder: Path) -> str:
    margins = findings.margins
    if margins is None or not margins.seeds:
        return ""
    picture = ""
    if margins.numbers:
        alt = "How far each parameter may move from the winner before a seed falls"
        picture = _figure(
            robustness_figures.margins(findings, margins.numbers), folder, "margins", alt
        )
    note = (
        "Each parameter moved alone, outwards from the winner until a seed falls that stays up at "
        f"the winner, then halved twice; n = {margins.seeds} seeds on every ground of the study. "
        "Limits may lie outside the searched range."
    )
    unfinished = "" if margins.complete else "**Incomplete: some of these walks have not run.**"
    return section(
        "How far may each parameter drift?",
        note,
        unfinished,
        picture,
        tables.margins_table(findings),
        tables.switches_table(findings),
    )


def _front(findings: Findings, folder: Path) -> str:
    if len(findings.study.objectives) < 2 or not findings.front:
        return ""
    alt = "Objectives of all candidates against each other, the Pareto front joined"
    picture = _figure(search_figures.front(findings), folder, "front", alt)
    note = "No candidate of the front is beaten by another in every objective."
    return section("Pareto front", note, picture, search_tables.front_table(findings))


def _search(findings: Findings, folder: Path) -> str:
    if not findings.candidates:
        return section("The search", "No candidate has been tried yet.")
    pictures = [
        _figure(
            search_figures.history(findings),
            folder,
            "history",
            "Objective of every candidate in the order of the search, and the best so far",
        )
    ]
    several = len(findings.study.objectives) > 1
    for place, objective in enumerate(findings.study.objectives):
        asked = objective_text(objective, len(findings.grounds))
        pictures.append(
            _figure(
                search_figures.slices(findings, place),
                folder,
                f"slices_{objective.metric}" if several else "slices",
                f"Every searched parameter against the objective: {asked}",
            )
        )
    note = (
        "Thin vertical lines are the borders of batches; a candidate that was given up early "
        "stands at what its first seeds gave."
    )
    return section(
        "The search", note, *pictures, search_tables.search_table(findings), _throughput(findings)
    )


def _throughput(findings: Findings) -> str:
    if not findings.wall:
        return PEER
    rate = findings.used / findings.wall
    return (
        f"The walks of the search took {findings.wall / 60.0:.1f} core minutes: {rate:.1f} "
        f"simulated robot-seconds per second of one core. {PEER}"
    )


def _importance(findings: Findings, folder: Path) -> str:
    if not any(findings.importance):
        return ""
    alt = "Importance of each searched parameter"
    picture = _figure(robustness_figures.importance(findings), folder, "importance", alt)
    return section("What mattered", picture, IMPORTANCE_CAVEAT)


def _provenance(findings: Findings) -> str:
    again = f"This page again:\n\n{fenced(chr(10).join(findings.commands), 'sh')}"
    return section("Provenance", facts_table(findings.facts), again)
