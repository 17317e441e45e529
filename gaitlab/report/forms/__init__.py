"""The forms of a page beside Markdown: one file of HTML, tables in LaTeX and CSV. No number is
made here.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from gaitlab.documents.outputs import published
from gaitlab.documents.steps import expect, step
from gaitlab.render.figure_style import vector_figures
from gaitlab.render.kept_figures import figures_before
from gaitlab.report.forms.explorer import Explorer
from gaitlab.report.forms.html import html_page, write_html
from gaitlab.report.forms.tables import write_tables
from gaitlab.report.results import Results

__all__ = ["REPORTS", "html_page", "publish", "write_html", "write_tables"]

REPORTS = Path("reports")


def publish(
    folder: Path,
    write: Callable[[Path], Path],
    *,
    html: bool,
    tables: bool,
    force: bool,
    results: Results | None = None,
    explorer: Explorer | None = None,
    links: Mapping[str, str] | None = None,
) -> Path:
    """Write a page in all forms into a folder, whose files take their places once all are whole.

    Args:
        folder: Of the page and its figures.
        write: Writes the page of Markdown and its figures into a folder; returns the page.
        html: Also write the page as one file of HTML.
        tables: Also write every table as LaTeX and CSV.
        force: Also write into a folder that holds files of somebody else.
        results: What the page was computed from, whose cells and trials become CSV too.
        explorer: What opens and draws in HTML.
        links: Pages beside it that the contents of the HTML lead to, by what they are called.

    Returns:
        The page, in HTML if that was asked for.
    """
    with (
        published(folder, force=force) as place,
        vector_figures(html or tables),
        figures_before(folder),
    ):
        expect(tables + html)
        page = write(place)
        if tables:
            step("writing tables")
            write_tables(page, results)
        if html:
            step("writing HTML")
            page = write_html(page, explorer, links)
    return folder / page.name
