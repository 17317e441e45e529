"""The HTML form of an experiment in a browser: cells open, figures draw, nothing is fetched."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from gaitlab.report.forms import publish
from gaitlab.report.forms.explorer import CellExplorer, ended, replays_beside
from gaitlab.report.page import Sources, write_page
from gaitlab.report.results import Results
from tests.report.browser import CHROMIUM, Browser, accessibility_rules, browser, serious
from tests.report.builder import results_of, toy_trials, trial

SOURCES = Sources(facts={"seeds": "0 to 1"}, parts=[], grounds="", command="gaitlab report toy")
SCREENS = [(1280, "light"), (1280, "dark"), (390, "light"), (390, "dark")]
HOSTILE = "</script><script>document.title='taken'</script>"


def toy() -> Results:
    """Cells of both variants, one trial of them hostile, one without a result."""
    trials = toy_trials(seeds=2)
    trials[0] = {**trials[0], "state": "FAILED", "reason": HOSTILE, "stable": None}
    return results_of(trials)


def written(results: Results, folder: Path, **more: Any) -> Path:
    write = partial(write_page, results, SOURCES)
    beside = replays_beside(folder, list(map(str, results.trials["trial_id"])))
    explorer = CellExplorer(results=results, **{"replays": beside, **more})
    return publish(folder, write, html=True, tables=False, force=False, explorer=explorer)


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A page with the replay of one trial beside it."""
    folder = tmp_path_factory.mktemp("page") / "toy"
    (folder / "replays").mkdir(parents=True)
    (folder / "replays" / "none-grass_50mm-0.08-1.html").write_text("<p>A replay")
    return written(toy(), folder)


@pytest.fixture(scope="module")
def chromium(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    if CHROMIUM is None:
        pytest.skip("no Chromium on this machine")
    with browser(tmp_path_factory.mktemp("profile")) as started:
        yield started


@pytest.fixture(scope="module")
def axe(tmp_path_factory: pytest.TempPathFactory) -> str:
    return accessibility_rules(tmp_path_factory.mktemp("axe"))


def shown(chromium: Browser, page: Path, width: int = 1280, scheme: str = "light") -> Browser:
    """The page on a screen, its figure drawn."""
    size = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": width < 600}
    chromium.ask("Emulation.setDeviceMetricsOverride", **size)
    features = [{"name": "prefers-color-scheme", "value": scheme}]
    chromium.ask("Emulation.setEmulatedMedia", features=features)
    chromium.open(page)
    chromium.value("document.getElementById('plot').scrollIntoView()")
    until(chromium, "document.getElementById('plot').dataset.drawn === 'yes'")
    return chromium


def until(tab: Browser, true: str) -> None:
    for _ in range(600):
        if tab.value(true):
            return
        time.sleep(0.1)
    raise AssertionError(true)


@pytest.mark.parametrize(("width", "scheme"), SCREENS)
def test_a_screen_holds_the_page_and_nothing_is_fetched(
    chromium: Browser, page: Path, width: int, scheme: str
) -> None:
    tab = shown(chromium, page, width, scheme)
    assert tab.value("innerWidth") == width  # a phone shows a wider page from farther away
    tab.value("document.querySelectorAll('details').forEach(block => { block.open = true; })")
    assert tab.value("document.documentElement.scrollWidth") <= width
    assert tab.problems == []
    assert len(tab.fetched) == 1  # the page itself
    assert (
        tab.value("document.title") == "Toy: does heel strike help? (63 of 64 trials, "
        "compared in the 16 cells that all have)"
    )
    paper = tab.value("getComputedStyle(document.body).backgroundColor")
    behind = tab.value("document.querySelector('#plot .main-svg').style.background")
    assert behind == paper


@pytest.mark.parametrize(("width", "scheme"), SCREENS)
def test_the_rules_of_accessibility_hold(
    chromium: Browser, page: Path, axe: str, width: int, scheme: str
) -> None:
    tab = shown(chromium, page, width, scheme)
    assert serious(tab, axe) == []
    tab.value("document.querySelector('button[data-cell]').click()")
    assert serious(tab, axe) == []


def test_a_figure_of_a_dark_page_is_dark_and_follows(chromium: Browser, page: Path) -> None:
    tab = shown(chromium, page, scheme="light")
    drawing = "getComputedStyle(document.querySelector('figure.drawing:not(.bright) path')).fill"
    ink = "document.querySelector('#plot .xtick text').style.fill"
    before = tab.value(drawing), tab.value(ink)
    features = [{"name": "prefers-color-scheme", "value": "dark"}]
    tab.ask("Emulation.setEmulatedMedia", features=features)
    until(tab, f"{ink} !== '{before[1]}'")
    assert tab.value(drawing) != before[0]


def test_every_cell_opens_its_seeds(chromium: Browser, page: Path) -> None:
    tab = shown(chromium, page)
    cells = toy_cells(page)
    buttons = "document.querySelectorAll('button[data-cell]')"
    assert tab.value(f"{buttons}.length") == len(cells)
    titles = "document.getElementById('cell-title').textContent"
    rows = "document.querySelectorAll('#cell tbody tr').length"
    for number, cell in enumerate(cells):
        tab.value(f"{buttons}[{number}].focus()")
        tab.press("Enter")
        tab.value(f"document.getElementById('cell').open || {buttons}[{number}].click()")
        assert tab.value(titles) == cell["title"]
        assert tab.value(rows) == 2
        tab.value("document.getElementById('cell').close()")


def toy_cells(page: Path) -> list[dict[str, Any]]:
    text = page.read_text("utf-8")
    data = text.partition('id="data">')[2].partition("</script>")[0]
    cells: list[dict[str, Any]] = json.loads(data)["cells"]
    return cells


def test_the_cell_that_a_button_opens_is_the_one_it_stands_for(page: Path) -> None:
    results = toy()
    explorer = CellExplorer(results=results, replays={})
    for number, (label, row, column) in enumerate(explorer.cells):
        variant = next(v for v in results.variants if v.label == label)
        cell = results.cell(variant, row, column)
        assert f"{cell.count()}/{cell.n}" in button(page, number)


def button(page: Path, number: int) -> str:
    after = page.read_text("utf-8").partition(f'data-cell="{number}"')[2]
    return after.partition("</button>")[0]


def test_a_seed_links_the_replay_that_lies_beside_the_page(chromium: Browser, page: Path) -> None:
    tab = shown(chromium, page)
    number = next(
        k
        for k, cell in enumerate(toy_cells(page))
        if "0.08" in cell["title"] and cell["title"].startswith("plain: grass 50")
    )
    tab.value(f"document.querySelectorAll('button[data-cell]')[{number}].click()")
    links = "[...document.querySelectorAll('#cell a')].map(link => link.getAttribute('href'))"
    (link,) = tab.value(links)
    assert (page.parent / link).is_file()


def test_replays_are_those_of_the_trials_whose_ids_begin_so(tmp_path: Path) -> None:
    (tmp_path / "replays").mkdir()
    for name in ("0123456789.html", "abc.html", "fall of mine.html"):
        (tmp_path / "replays" / name).write_text("")
    ids = ["0123456789abcdef", "abcdef0123456789"]
    assert replays_beside(tmp_path, ids) == {ids[0]: "replays/0123456789.html"}
    assert replays_beside(tmp_path / "nowhere", ids) == {}


def test_every_measure_is_drawn_with_its_unit(chromium: Browser, page: Path) -> None:
    tab = shown(chromium, page)
    options = tab.value("[...document.getElementById('measure').options].map(o => o.text)")
    assert "distance [m]" in options
    assert "pitch amplitude [°]" in options
    for k, title in enumerate(options):
        choose = f"(m => {{ m.selectedIndex = {k}; m.dispatchEvent(new Event('change')); }})"
        tab.value(f"{choose}(document.getElementById('measure'))")
        assert tab.value("document.querySelector('#plot .ytitle').textContent") == title
        assert tab.value("document.querySelectorAll('#plot .point').length") > 0
        assert tab.value("document.getElementById('meaning').textContent")


def test_nothing_that_a_store_holds_becomes_markup(chromium: Browser, page: Path) -> None:
    tab = shown(chromium, page)
    assert not tab.value("document.title").startswith("taken")
    assert "how it ended" not in HOSTILE
    data = page.read_text("utf-8").partition('id="data">')[2].partition("</script>")[0]
    assert HOSTILE in str(json.loads(data)["trials"]["ended"])


def test_a_page_of_nothing_but_failures_still_opens(chromium: Browser, tmp_path: Path) -> None:
    trials = [trial(0.04, "a", "none", seed, state="FAILED") for seed in range(2)]
    trials += [trial(0.08, "a", "none", seed, state="FAILED") for seed in range(2)]
    tab = shown(chromium, written(results_of(trials), tmp_path))
    assert tab.problems == []
    tab.value("document.querySelector('button[data-cell]').click()")
    assert tab.value("document.querySelectorAll('#cell tbody tr').length") == 2


def test_the_same_results_give_the_same_page(page: Path, tmp_path: Path) -> None:
    before = page.read_bytes()
    assert written(toy(), page.parent).read_bytes() == before


@pytest.mark.parametrize(
    ("row", "word"),
    [
        (trial(0.04, "a", "none", 0), "stayed up, stalled"),
        (trial(0.08, "a", "none", 0, up=False), "fell forward"),
        (trial(0.08, "a", "none", 0, state="MISSING"), "not run yet"),
        (trial(0.08, "a", "none", 0, state="INFEASIBLE"), "infeasible"),
    ],
)
def test_how_a_trial_ended_is_said(row: dict[str, object], word: str) -> None:
    assert ended(row).startswith(word)
