"""The notebook of the documents, executed as a reader would: no cell fails, each shows the same."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parent.parent
NOTEBOOK = ROOT / "docs" / "notebook.ipynb"
# What a reader is shown at leisure: one walk of a cycle shows the same kinds of things.
SHORTER = (("seeds=3", "seeds=1"), ('\\"horizon.cycles\\": 3', '\\"horizon.cycles\\": 1'))
LARGEST = 120_000  # bytes; a forge shows it at once
EXECUTE = """\
import sys
import nbformat
from nbclient import NotebookClient

read = nbformat.read(sys.argv[1], as_version=4)
NotebookClient(read, timeout=300).execute()
nbformat.write(read, sys.argv[2])
"""
needs_jupyter = pytest.mark.skipif(
    find_spec("nbclient") is None or find_spec("ipykernel") is None,
    reason="nbclient or ipykernel is not installed",
)


def cells(path: Path) -> list[dict[str, Any]]:
    return [c for c in json.loads(path.read_text())["cells"] if c["cell_type"] == "code"]


def shown(cell: dict[str, Any]) -> list[tuple[str, list[str]]]:
    """What kinds of things a cell shows."""
    kinds = [(part["output_type"], sorted(part.get("data", ()))) for part in cell["outputs"]]
    return [kind for kind in kinds if kind[0] != "stream"]


@pytest.mark.long
@needs_jupyter
def test_every_cell_runs_and_shows_what_a_reader_sees_here(tmp_path: Path) -> None:
    text = NOTEBOOK.read_text()
    for shown_there, cheaper in SHORTER:
        assert shown_there in text
        text = text.replace(shown_there, cheaper)
    (tmp_path / "short.ipynb").write_text(text)
    done = subprocess.run(
        [sys.executable, "-c", EXECUTE, "short.ipynb", "executed.ipynb"],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=600,
    )
    assert done.returncode == 0, done.stderr[-3000:]
    now, before = cells(tmp_path / "executed.ipynb"), cells(NOTEBOOK)
    assert [shown(cell) for cell in now] == [shown(cell) for cell in before]
    assert (tmp_path / "data" / "trials").is_dir()


def test_the_notebook_as_it_is_kept_is_small_whole_and_of_no_machine() -> None:
    text = NOTEBOOK.read_text()
    assert len(text) < LARGEST
    assert all(cell["outputs"] for cell in cells(NOTEBOOK)[1:]), "a reader on a forge sees outputs"
    assert all(part["output_type"] != "error" for c in cells(NOTEBOOK) for part in c["outputs"])
    for place in (ROOT, Path.home(), Path(tempfile.gettempdir()), Path(sys.prefix)):
        assert f"{place}/" not in text
