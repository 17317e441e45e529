"""Several studies on one page: what each found, and where each gait walks."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from gaitlab.report.markdown import escape, fenced, section, table
from gaitlab.report.study.crossings import Crossing, crossings
from gaitlab.report.study.findings import Findings
from gaitlab.report.study.fresh import score, stable_of
from gaitlab.report.study.page import HOW_TO_READ, crossings_section, write_study_page
from gaitlab.report.study.words import UNKNOWN, interval, number, objective_axis, objective_text
from gaitlab.report.words import share, surface_text
from gaitlab.search.fresh import WINNER
from gaitlab.statistics import wilson


def write_pages_together(found: Sequence[Findings], folder: Path) -> Path:
    """Write README.md over several studies, and a folder below it for the page of each."""
    for findings in found:
        write_study_page(findings, folder / findings.experiment.name)
    names = " and ".join(findings.experiment.name for findings in found)
    blocks = [
        f"# {escape(names)}",
        "What each study found, on seeds that no search saw; its own page is linked.",
        _studies(found),
        HOW_TO_READ,
        crossings_section(rows_of(found), _shared_units(found), folder),
        _again(found),
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


def _shared_units(found: Sequence[Findings]) -> str:
    """Name of the number in the cells, if all studies ask for the same one first."""
    names = {objective_axis(findings.study.objectives[0]) for findings in found}
    return names.pop() if len(names) == 1 else "first objective of each study"


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
    asked = escape(objective_text(findings.study.objectives[0], len(findings.grounds)))
    winner = findings.rerun(WINNER)
    walks = winner.on(findings.grounds) if winner else ()
    if not walks:
        return [asked, UNKNOWN, UNKNOWN]
    again, (up, n) = score(findings.study, walks, 0), stable_of(walks)
    text = f"{number(again.value)} {escape(interval(again.interval))}".rstrip()
    return [asked, text, share(up, n, wilson(up, n))]


def _again(found: Sequence[Findings]) -> str:
    runs = [findings.commands[0] for findings in found]
    report = f"gaitlab report {' '.join(findings.called for findings in found)}"
    rest = found[0].commands[1].partition(found[0].called)[2]
    return section(
        "Provenance", f"This page again:\n\n{fenced(chr(10).join([*runs, report + rest]), 'sh')}"
    )
