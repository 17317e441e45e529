"""docs/optimising.md, done as a reader would do it, with fewer and shorter walks."""

from __future__ import annotations

import json
import shlex
from pathlib import Path

import pytest

from tests.forked import gaitlab
from tests.test_docs import ROOT, alone, blocks, commands

PAGE = ROOT / "docs" / "optimising.md"
SHORT = ("--set", "horizon.time=0.2", "--set", "seeds=1", "--set", "study.batch=2")
SHORT += ("--set", "study.constraints=[walking_speed >= -1]", "--set", "study.racing=off")
FEW = {"16": "2", "24": "3"}  # candidates, by how many the page shows
OWN, FAST = "our_study.yaml", "fast_study.yaml"


def shortened(command: str) -> list[str]:
    """A command with fewer candidates and shorter walks; what is shipped is only planned."""
    words = [FEW.get(word, word) for word in shlex.split(command)[1:]]
    own = {OWN, FAST} & set(words)
    if words[0] == "run" or (words[0] == "optimize" and not own):
        return [*words, "--dry-run"]
    short = SHORT if own else ()
    unchecked = ["--no-validation"] if words[0] == "optimize" else []
    return alone([*words, *short, *unchecked])


@pytest.mark.long
def test_every_command_of_the_page_works(tmp_path: Path) -> None:
    for name, text in zip((OWN, FAST), blocks(PAGE, "yaml"), strict=True):
        (tmp_path / name).write_text(text)
    for command in dict.fromkeys(commands(PAGE)):
        done = gaitlab(*shortened(command), folder=tmp_path)
        expected_missing = "eros_small" in command and "report" in command
        assert (done.returncode == 0) != expected_missing, f"{command}\n{done.stderr}"
        if expected_missing:
            assert "gaitlab optimize eros_small" in done.stderr
    page = (tmp_path / "reports" / "our_study" / "details.md").read_text()
    assert "## The search" in page
    asked = json.loads(gaitlab("optimize", OWN, "--dry-run", "--json", folder=tmp_path).stdout)
    assert asked["candidates"] == 120
