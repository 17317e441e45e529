"""What docs/export.md shows, run as a reader would run it."""

from __future__ import annotations

import shlex
from pathlib import Path

import pytest

from gaitlab.cli import run_command_line
from gaitlab.log.columns import columns
from tests.test_docs import ROOT, commands

PAGE = ROOT / "docs" / "export.md"


TINY = """\
name: eros_quick
include: {shipped}
seeds: 1
horizon: {{cycles: 0.5}}
surfaces: [hard_floor]
surface:
grid: {{gait.step_length: [0.02, 0.04]}}
"""


@pytest.fixture(scope="module")
def reader(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder in which the quick experiment was run, on hard floor and for half a cycle."""
    folder = tmp_path_factory.mktemp("reader")
    file, shipped = folder / "experiments/eros_quick.yaml", ROOT / "experiments/eros_quick.yaml"
    file.parent.mkdir()
    file.write_text(TINY.format(shipped=shipped))
    words = ["run", str(file), "-j", "0", "--store", str(folder / "data")]
    assert run_command_line(words) == 0
    return folder


@pytest.mark.parametrize("command", commands(PAGE))
def test_every_command_of_the_page_works_and_writes_what_it_says(
    command: str, reader: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(reader)
    words = shlex.split(command)[1:]
    small = {"replay": ["--size", "160x160", "-j", "0"], "view": ["--no-open"]}
    assert run_command_line([*words, *small.get(words[0], [])]) == 0
    out = capfd.readouterr().out
    if words[0] != "query":
        assert all((reader / line).stat().st_size > 0 for line in out.splitlines())


def test_the_page_names_every_column_of_a_log() -> None:
    text = PAGE.read_text()
    for column in columns(()):
        stem = column.name.removeprefix("left_foot_").removeprefix("right_foot_")
        known = stem in text or stem[:-1] in text or stem.startswith("fsr_")
        assert known, f"{column.name} is not on the page"
