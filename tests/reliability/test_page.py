"""The page on reliability says what is so: its commands work, its tests are there."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from gaitlab.cli import run_command_line
from gaitlab.experiment import load_experiment
from gaitlab.running import dispatch
from gaitlab.store import Store
from tests.reliability import sweeps

ROOT = Path(__file__).parent.parent.parent
PAGE = (ROOT / "docs" / "reliability.md").read_text()
COMMANDS = re.findall(r"^    (gaitlab .*?)\s+#", PAGE, re.MULTILINE)
PLACES = (ROOT / "tests" / "reliability", ROOT / "tests", ROOT)


@pytest.mark.long
def test_every_command_of_the_page_works(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In their order, in an empty folder, with trials that are pretended."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("gaitlab.running.processes.simulated", sweeps.pretend)
    dispatch(load_experiment("eros_quick", seeds=2), Store(tmp_path / "other" / "data"), jobs=0)
    assert len(COMMANDS) >= 8
    for command in COMMANDS:
        words = shlex.split(command)[1:]
        assert run_command_line(words) == 0, command


def test_every_test_of_the_page_is_there() -> None:
    named = re.findall(r"`((?:tests/)?\w[\w/]*\.py)(?:::(\w+))?`", PAGE)
    assert len(named) > 30
    for file, test in named:
        found = [place / file for place in PLACES if (place / file).is_file()]
        assert found, file
        assert not test or f"def {test}(" in found[0].read_text(), test
