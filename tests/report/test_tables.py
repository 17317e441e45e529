"""Tables as files: LaTeX that compiles, CSV with the same cells, numbers for other programs."""

from __future__ import annotations

import csv
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from gaitlab.report.forms import write_tables
from gaitlab.report.forms.latex import text
from gaitlab.report.forms.tokens import page_tables, parse, plain, slug
from gaitlab.report.markdown import code, escape, fenced, section, table
from tests.report.builder import results_of, toy_trials, trial

NASTY = r"a_b & 50% of #1 {x} $y$ ~^ \n <b> | * [z] `q` 'r' \"s\" é"
ROWS = [
    ["plain", "**U 2/10 [6–51] (S)**", "'-0.0635 [-0.2, 0.4], n = 9"],
    ["[first] bracket", "S 10/10 [72–100]", "-4.7e-05 ± 3°"],
    [escape(NASTY), code("a_b"), "10 → 70 %"],
]
PAGE = "\n\n".join(
    [
        "# A & B",
        "Stable cells, 3 seeds a cell:",
        table(["", "grass 50 mm", "x [m]"], ROWS),
        table(["runs not fallen", "all"], [["plain", "1/2"]]),
        section(
            "Cell by cell", "Each cell: a verdict.", "### Forward, plain", table(["row"], [["1"]])
        ),
        section("Cells", table(["row"], [["1"]]), "### Cells", table(["row"], [["2"]])),
        section(
            "Provenance",
            table(["", ""], [["experiment toy", "digest `ab12`"], ["trials", "9 planned"]], "ll"),
            "This page again:",
            fenced("gaitlab report toy", "sh"),
        ),
    ]
)


@pytest.fixture
def page(tmp_path: Path) -> Path:
    path = tmp_path / "README.md"
    path.write_text(PAGE)
    return path


def contents(files: list[Path]) -> dict[str, str]:
    return {file.name: file.read_text(encoding="utf-8") for file in files}


def test_files_are_named_after_headings_and_never_twice(page: Path) -> None:
    names = [file.name for file in write_tables(page) if file.suffix == ".tex"]
    stems = ["headline", "runs-not-fallen", "forward-plain", "cells-1", "cells-2"]
    assert names == [f"{stem}.tex" for stem in stems]
    written = {file.name for file in (page.parent / "tables").iterdir()}
    assert written == {"README.md"} | {f"{stem}.{end}" for stem in stems for end in ("tex", "csv")}


def test_a_csv_has_the_cells_as_one_reads_them(page: Path) -> None:
    found = contents(write_tables(page))
    rows = list(csv.reader(found["headline.csv"].splitlines()))
    assert rows[0] == ["", "grass 50 mm", "x [m]"]
    assert rows[1] == ["plain", "U 2/10 [6–51] (S)", "'-0.0635 [-0.2, 0.4], n = 9"]
    assert rows[3] == [" ".join(NASTY.split()), "a_b", "10 → 70 %"]


def test_every_latex_table_says_what_it_is_and_how_to_make_it_again(page: Path) -> None:
    found = contents(write_tables(page))
    for name, content in found.items():
        if name.endswith(".tex"):
            assert "% experiment toy: digest ab12\n" in content
            assert "%     gaitlab report toy\n" in content
            assert r"A \& B. 9 planned.}" in content
    assert r"\caption{Forward, plain. Each cell: a verdict. A" in found["forward-plain.tex"]
    assert r"\caption{Stable cells, 3 seeds a cell. A" in found["headline.tex"]
    assert "gaitlab report toy" in found["README.md"]


def test_latex_keeps_bold_and_writes_numbers_as_numbers(page: Path) -> None:
    found = contents(write_tables(page))["headline.tex"]
    assert r"\textbf{U 2/10 [6--51] (S)}" in found
    assert r"$-$0.0635 [$-$0.2, 0.4], n = 9" in found
    assert r"{}[first] bracket" in found
    assert text("-4.7e-05") == r"$-4.7\times10^{-5}$"
    assert text("2e+06 and heel-strike, 1-2") == r"$2\times10^{6}$ and heel-strike, 1-2"


@pytest.mark.parametrize("letter", list("\\{}$&%#_~^<>|\"'`–—→±≠≤≥×°²αµμΩ…−\u00a0"))
def test_no_letter_means_something_else_to_latex(letter: str) -> None:
    set_ = text(letter)
    assert set_.isascii()
    assert set_ != letter or letter == "'"


def test_the_same_page_gives_the_same_bytes(page: Path) -> None:
    results = results_of(toy_trials())
    first = contents(write_tables(page, results))
    assert contents(write_tables(page, results)) == first


def test_slugs_are_plain_names_of_files() -> None:
    assert slug("Forward, heel strike + Übung / ../x") == "forward-heel-strike-ubung-x"
    assert slug("漢字") == ""
    assert len(slug("x" * 300)) == 60


def test_a_page_without_tables_gives_only_the_list(tmp_path: Path) -> None:
    page = tmp_path / "README.md"
    page.write_text("# Nothing\n")
    assert [file.name for file in write_tables(page)] == ["README.md"]


def test_tables_keep_their_alignment() -> None:
    (found,) = page_tables(parse(table(["a", "b", "c"], [["1", "2", "3"]], "lrc")))
    assert found.align == "lrc"
    assert [plain(cell) for cell in found.rows[0]] == ["1", "2", "3"]


def test_cells_csv_counts_what_the_trials_say(page: Path) -> None:
    results = results_of(toy_trials())
    write_tables(page, results)
    cells = pd.read_csv(page.parent / "tables" / "cells.csv")
    trials = pd.read_csv(page.parent / "tables" / "trials.csv")
    assert len(trials) == len(results.trials)
    keys = ["variant", "gait.step_length", "surface"]
    counted = trials.groupby(keys)["stable"].agg(["sum", "size"])
    joined = cells.set_index(keys).join(counted)
    assert (joined["stable"] == joined["sum"]).all()
    assert (joined["n"] == joined["size"]).all()
    np.testing.assert_allclose(cells["share"], cells["stable"] / cells["n"])
    assert ((cells["low"] <= cells["share"]) & (cells["share"] <= cells["high"])).all()
    assert ((cells["verdict"] == "S") == (cells["share"] >= 0.5)).all()
    assert set(cells["paper"].dropna()) == {"S", "U"}


def test_a_cell_without_a_scored_seed_has_no_share(page: Path) -> None:
    missing = trial(0.04, "carpet_4mm", "none", 0) | {"state": "MISSING", "stable": None}
    results = results_of([missing, trial(0.0, "carpet_4mm", "none", 0)])
    write_tables(page, results)
    cells = pd.read_csv(page.parent / "tables" / "cells.csv").set_index("gait.step_length")
    assert cells.loc[0.04, ["n", "missing"]].tolist() == [0, 1]
    assert cells.loc[0.04, ["share", "low", "high", "verdict"]].isna().all()


def test_latex_compiles(page: Path) -> None:
    program = shutil.which("pdflatex")
    if program is None:
        pytest.skip("no pdflatex on this machine")
    results = results_of(toy_trials())
    inputs = [rf"\input{{{file}}}" for file in write_tables(page, results) if file.suffix == ".tex"]
    document = page.parent / "all.tex"
    document.write_text(
        "\\documentclass{article}\\usepackage{array,booktabs,graphicx}\n\\begin{document}\n"
        + "\n".join(inputs)
        + "\n\\end{document}\n"
    )
    options = ["-interaction=nonstopmode", "-halt-on-error", document.name]
    done = subprocess.run(
        [program, *options], cwd=page.parent, capture_output=True, timeout=60, check=False
    )
    log = done.stdout.decode(errors="replace")
    assert done.returncode == 0, log[-2000:]
    assert not re.search(r"Overfull|Missing character", log), log
