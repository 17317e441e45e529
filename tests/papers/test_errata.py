"""Every mistake that a paper's file holds: computed where it says so, and printed on its page."""

from __future__ import annotations

import inspect
from functools import partial
from importlib import import_module
from pathlib import Path
from types import ModuleType

import pytest

from gaitlab.documents import load
from gaitlab.papers.page import PRINTED, errata_of

REPOSITORY = Path(__file__).parents[2]

COUNTS = {"bioloid": 15, "biped": 11, "eros": 28, "flow": 19, "nao": 13}
PAGES = REPOSITORY / "reports" / "papers"


def effects(paper: str) -> ModuleType:
    return import_module(f"gaitlab.papers.{paper}_effects")


def named(paper: str) -> list[str]:
    """Functions that the errata and assumptions of a paper's file name."""
    content = load(PRINTED / f"{paper}.yaml").mapping
    items = [item for key in ("errata", "assumptions") for item in content[key].items]
    return [str(item.mapping["numbers"].value) for item in items if "numbers" in item.mapping]


def written(page: Path) -> list[list[str]]:
    """Rows of the table of what is wrong in print."""
    text = page.read_text(encoding="utf-8").partition("## Wrong in print\n\n")[2]
    lines = text.partition("\n\n")[0].splitlines()[2:]
    return [[cell.strip() for cell in line.strip("|").split(" | ")] for line in lines]


@pytest.mark.parametrize("paper", COUNTS)
def test_no_mistake_of_a_paper_is_lost(paper: str) -> None:
    found = errata_of(paper, effects(paper))
    assert len(found) == COUNTS[paper]
    for one in found:
        assert all((one.where, one.printed, one.correct, one.effect))
        assert "{" not in one.printed + one.correct + one.effect


@pytest.mark.parametrize("paper", COUNTS)
def test_the_page_of_a_paper_has_every_mistake_with_the_size_computed_now(paper: str) -> None:
    found = errata_of(paper, effects(paper))
    cells = [[one.where, one.printed, one.correct, one.effect] for one in found]
    shown = [[cell.replace("|", "\\|") for cell in row] for row in cells]
    assert written(PAGES / f"{paper}.md") == shown


@pytest.mark.parametrize("paper", COUNTS)
def test_every_function_of_a_mistake_is_named_by_one(paper: str) -> None:
    module = effects(paper)
    own = {
        name
        for name, value in vars(module).items()
        if not name.startswith("_")
        and (isinstance(value, partial) or inspect.isfunction(value))
        and (isinstance(value, partial) or value.__module__ == module.__name__)
        and (isinstance(value, partial) or value.__annotations__.get("return") == "Numbers")
    }
    assert own == set(named(paper))
