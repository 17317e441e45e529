"""What others wrote never moves a cursor, turns a line or computes a cell."""

from __future__ import annotations

import csv
import unicodedata
from pathlib import Path
from xml.etree import ElementTree

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitlab.documents.printable import csv_cell, visible
from gaitlab.render.figure_style import new_figure, save, style, vector_figures
from gaitlab.report.forms.html import html_page
from gaitlab.report.forms.latex import text as latex
from gaitlab.report.forms.tables import write_tables
from gaitlab.report.markdown import code, escape, fenced, table

EVIL = "\x1b[31mred\x1b]0;title\x07 \x9b2J \u202eabc \r\x00\x7f \udcf6 \ud800 $a$ $b$ |<b>"
HARMLESS = "\n\t\u200c\u200d"  # the last two join letters and emojis
TURNING = ("LRE", "RLE", "LRO", "RLO", "PDF", "LRI", "RLI", "FSI", "PDI")  # of lines


def obeyed(text: str) -> set[str]:
    """Characters that something else than a font answers to."""
    return {
        letter
        for letter in set(text) - set(HARMLESS)
        if unicodedata.category(letter) in ("Cc", "Cs", "Zl", "Zp")
        or unicodedata.bidirectional(letter) in TURNING
        or letter in "\u200b\u200e\u200f\u061c\ufeff\U000e0041"
    }


def test_every_character_that_could_be_obeyed_is_written_out() -> None:
    every = "".join(map(chr, [*range(0x10000), *range(0xE0000, 0xE0080)]))
    assert len(obeyed(every)) > 2000
    assert not obeyed(visible(every))
    assert visible("a\x1b[2Jb\udcf6\ud800") == "a\\x1b[2Jb\\xf6\\ud800"
    assert visible("Größe → 5 %\n\t👩\u200d🔬") == "Größe → 5 %\n\t👩\u200d🔬"


@given(st.text())
def test_what_was_written_out_stays_and_can_be_encoded(text: str) -> None:
    assert visible(visible(text)) == visible(text)
    assert visible(text).encode().decode() == visible(text)


@pytest.mark.parametrize(
    "text", ["=1+1", "+1+1", "-1+1|cmd", "@SUM(A1)", " =1+1", "\t=1", "＝1+1", "-0.1 [-0.2, 0.1]"]
)
def test_a_cell_that_a_spreadsheet_would_compute_is_text(text: str) -> None:
    assert csv_cell(text) == f"'{text}"


@pytest.mark.parametrize("text", ["-0.2", "+5", "-1e-3", "-", "", "a=b", "2-1", "–5"])
def test_a_number_and_a_name_stay_as_they_are(text: str) -> None:
    assert csv_cell(text) == text


def test_no_form_of_a_page_passes_it_on(tmp_path: Path) -> None:
    page = tmp_path / "README.md"
    rows = [[escape(EVIL), code(EVIL), escape(f"={EVIL}")]]
    blocks = [f"# {escape(EVIL)}", table([escape(EVIL), "b", "c"], rows), fenced(EVIL)]
    page.write_text("\n\n".join(blocks), encoding="utf-8")
    assert not obeyed(page.read_text())
    assert not obeyed(html_page(page.read_text(), tmp_path))
    for file in write_tables(page):
        assert not obeyed(file.read_text()), file.name
    cells = next(csv.reader((tmp_path / "tables" / "headline.csv").read_text().splitlines()[1:]))
    assert cells[2].startswith("'=")
    assert not obeyed(latex(visible(EVIL)))


def test_no_figure_passes_it_on_or_takes_it_for_a_formula(tmp_path: Path) -> None:
    with style():
        figure = new_figure(9.0, 6.0)
        axes = figure.subplots()
        axes.plot([0, 1], [0, 1], label=EVIL)
        axes.set_title(EVIL)
        axes.set_xticks([0, 1], [EVIL, "$x$ and $\\y$"])
        axes.legend()
    with vector_figures():
        drawing = save(figure, tmp_path, "figure").with_suffix(".svg")
    ElementTree.parse(drawing)
    assert not obeyed(drawing.read_text())
