"""`gaitlab view`: the cells of an experiment, and the walks that stand for them."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from gaitlab.cli import run_command_line
from gaitlab.experiment import Experiment, load_experiment
from gaitlab.experiment.plan import plan
from gaitlab.report.gather import gather
from gaitlab.report.representative import worst
from gaitlab.report.view import write_view
from gaitlab.store import Store, TrialRecord
from tests.report.browser import (
    CHROMIUM,
    SOFTWARE_GL,
    Browser,
    accessibility_rules,
    browser,
    serious,
)
from tests.search import searches
from tests.walked import walked

FILE = """\
name: looked_at
robot: eros
gait: {type: eros}
surfaces: [grass_50mm, hard_floor]
grid: {gait.step_length: [0.0, 0.04]}
seeds: 3
"""
WHOLE = """\
name: whole
reproduction:
  members: [{experiment: looked_at.yaml}, {experiment: other.yaml}]
  sections: [{section: falls, title: Falls}]
"""
SWEPT = """\
name: swept
robot: eros
gait: {type: eros}
surfaces: [grass_50mm]
design: {points: 4, box: {robot.mass: {low: 3.0, high: 4.0}}}
grid: {gait.heel_strike: [none, add]}
seeds: 1
"""
TRIAL = re.compile(r'"id":"([0-9a-f]{32})"')


def stored(folder: Path, state: str = "DONE", asked: Experiment | None = None) -> Store:
    """A store in which every trial of the file walked as one that is recorded; some fell."""
    asked, store = asked or experiment(folder), Store(folder / "data")
    _, log = walked()
    store.register(asked, plan(asked).trials())
    for number, item in enumerate(plan(asked).trials()):
        fell = number % 4 == 1
        metrics = {"stable": not fell, "fell": fell, "distance": 0.1 + 0.01 * number}
        metrics |= {"stable_strict": not fell, "fell_standing": False}
        metrics |= {"time_to_fall": 1.0 + number if fell else None}
        record = TrialRecord(
            trial_id=item.trial.id,
            state=state,  # type: ignore[arg-type]
            reason="" if state == "DONE" else "it crashed",
            trial=item.trial.to_dict(),
            metrics=metrics if state == "DONE" else {},
            provenance={},
        )
        store.commit(record, log if state == "DONE" else None)
    return store


def experiment(folder: Path) -> Experiment:
    (folder / "looked_at.yaml").write_text(FILE)
    return load_experiment(folder / "looked_at.yaml")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("looked")
    stored(place)
    return place


@pytest.fixture(scope="module")
def page(folder: Path) -> Path:
    written = write_view(experiment(folder), Store(folder / "data"), folder / "out")
    return written.walks


def test_every_cell_shows_its_worst_and_its_median_seed(folder: Path, page: Path) -> None:
    results = gather([experiment(folder)], Store(folder / "data"))
    text = page.read_text()
    shown = TRIAL.findall(text)
    assert len(shown) == len(set(shown))
    for _, cell in results.trials.groupby(["surface", "gait.step_length"]):
        ordered = cell.sort_values("distance")["trial_id"].tolist()
        assert {worst(cell)["trial_id"], ordered[1]} == set(shown) & set(ordered)
        fell = cell[cell["fell"].astype(bool)]
        if len(fell):
            assert worst(cell)["trial_id"] in set(fell["trial_id"])
    for trial in shown:
        assert f'href="#{trial[:8]}"' in text


def test_what_is_linked_is_what_is_written(folder: Path, tmp_path: Path) -> None:
    written = write_view(experiment(folder), Store(folder / "data"), tmp_path / "out")
    for trial, link in written.links.items():
        file, _, place = link.partition("#")
        assert trial.startswith(place)
        assert (written.page.parent / file).samefile(written.walks)
        assert link in written.page.read_text()


@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium is installed")
def test_a_link_of_a_cell_shows_its_walk(page: Path, tmp_path: Path) -> None:
    with browser(tmp_path / "profile", more=SOFTWARE_GL) as tab:
        tab.open(page)
        link = "document.querySelectorAll('#menu td a')[3]"
        wanted = tab.value(f"{link}.hash.slice(1)")
        tab.value(f"{link}.click()")
        for _ in range(100):
            (shown,) = tab.value("replay.state().trials") or [""]
            if shown.startswith(wanted):
                break
            tab.value("new Promise(r => setTimeout(() => r(1), 50))")
        assert shown.startswith(wanted)
        assert tab.value(f"{link}.getAttribute('aria-current')") == "true"
        cell = tab.value("document.querySelector('.panel .cell').textContent")
        assert cell == tab.value(f"{link}.title")
        assert tab.value("document.documentElement.scrollWidth <= innerWidth")


def test_nothing_but_failures_is_a_page_without_walks(tmp_path: Path) -> None:
    store = stored(tmp_path, "FAILED")
    written = write_view(experiment(tmp_path), store, tmp_path / "out")
    assert not written.links
    assert not TRIAL.findall(written.walks.read_text())


def view(folder: Path, *arguments: str, monkeypatch: pytest.MonkeyPatch) -> int:
    monkeypatch.chdir(folder)
    return run_command_line(["view", *arguments, "--store", str(folder / "data")])


def test_the_newest_experiment_is_shown_where_none_is_named(
    folder: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    shutil.copytree(folder / "data", tmp_path / "data")
    (tmp_path / "experiments").mkdir()
    shutil.copy(folder / "looked_at.yaml", tmp_path / "experiments")
    opened: list[str] = []
    monkeypatch.setenv("BROWSER", "true")
    monkeypatch.setattr("webbrowser.open", lambda address: not opened.append(address))
    assert view(tmp_path, monkeypatch=monkeypatch) == 0
    path = Path(capfd.readouterr().out.strip())
    assert path.is_file()
    assert opened == [path.absolute().as_uri()]
    assert view(tmp_path, "--no-open", monkeypatch=monkeypatch) == 0
    assert len(opened) == 1


def test_without_a_browser_the_path_is_printed_and_it_is_said(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER"):
        monkeypatch.delenv(name, raising=False)
    assert view(folder, "looked_at.yaml", "--output", "shown", monkeypatch=monkeypatch) == 0
    done = capfd.readouterr()
    assert (folder / done.out.strip()).is_file()
    assert "browser" in done.err


def test_what_cannot_be_shown_is_refused_and_nothing_is_lost(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("mine")
    (tmp_path / "own").mkdir()
    (tmp_path / "own" / "replays.html").write_text("mine")
    name = str(folder / "looked_at.yaml")
    assert view(tmp_path, monkeypatch=monkeypatch) == 3  # an empty store
    monkeypatch.setattr("webbrowser.open", lambda address: pytest.fail(address))
    for output in ("file", "own"):
        options = ("--output", str(tmp_path / output), "--no-open")
        assert view(folder, name, *options, monkeypatch=monkeypatch) == 2
    assert view(folder, "eros_small", "--no-open", monkeypatch=monkeypatch) == 3  # not searched
    assert view(folder, "nowhere", "--no-open", monkeypatch=monkeypatch) == 3
    assert (tmp_path / "file").read_text() == (tmp_path / "own" / "replays.html").read_text()


def test_a_form_is_asked_for_by_its_options(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = replace(experiment(tmp_path), form="seeds-1")
    Store(tmp_path / "data").register(asked, plan(asked).trials())
    assert view(tmp_path, "--no-open", monkeypatch=monkeypatch) == 2


def walked_candidate(trial_id: str, trial: Mapping[str, Any], store: Path) -> TrialRecord:
    """A made-up outcome with the log of a real walk."""
    return searches.pretend(trial_id, trial, store, log=walked()[1])


def page_data(page: Path) -> Any:
    found = re.search(r'id="data">(.*?)</script>', page.read_text(), re.DOTALL)
    assert found is not None
    return json.loads(found[1])


def test_of_a_study_every_candidate_opens_and_the_winner_walks(tmp_path: Path) -> None:
    store = Store(tmp_path / "data")
    result = searches.search(store, task=walked_candidate)
    assert result.history.representative is not None
    written = write_view(searches.study(), store, tmp_path / "out")
    data = page_data(written.page)
    candidates = result.history.candidates
    assert [cell["at"][0] for cell in data["cells"]][: len(candidates)] == [
        candidate.number for candidate in candidates
    ]
    for place, candidate in enumerate(candidates):
        assert data["trials"]["cell"].count(place) == len(candidate.trial_ids)
    winner = result.history.representative
    assert set(written.links) <= set(winner.trial_ids)
    assert written.links
    shown = {trial[:8] for trial in TRIAL.findall(written.walks.read_text())}
    assert shown == {link.partition("#")[2] for link in written.links.values()}
    assert written.page.read_text().count('id="plot"') == 1


def drawn(tab: Browser, page: Path) -> None:
    """Open a page and wait for its figure."""
    tab.open(page)
    tab.value("document.getElementById('plot').scrollIntoView()")
    for _ in range(200):
        if tab.value("document.getElementById('plot').dataset.drawn"):
            return
        tab.value("new Promise(r => setTimeout(() => r(1), 50))")
    raise AssertionError("the figure is not drawn")


@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium is installed")
def test_the_candidates_of_a_study_are_drawn_and_open_on_every_screen(tmp_path: Path) -> None:
    rules = accessibility_rules(tmp_path)
    store = Store(tmp_path / "data")
    searches.search(store, task=walked_candidate)
    written = write_view(searches.study(), store, tmp_path / "out")
    with browser(tmp_path / "profile", more=SOFTWARE_GL) as tab:
        drawn(tab, written.page)
        panels = tab.value("document.querySelectorAll('#plot .cartesianlayer > .subplot').length")
        assert panels == len(page_data(written.page)["axes"])
        tab.value("document.querySelector('button[data-cell]').click()")
        assert tab.value("document.getElementById('cell').open")
        assert tab.value("document.querySelectorAll('#cell tbody tr').length") > 0
        assert not tab.problems
        assert tab.fetched == [written.page.resolve().as_uri()]
        for width, scheme in ((1280, "light"), (390, "dark")):
            size = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": width < 600}
            tab.ask("Emulation.setDeviceMetricsOverride", **size)
            features = [{"name": "prefers-color-scheme", "value": scheme}]
            tab.ask("Emulation.setEmulatedMedia", features=features)
            drawn(tab, written.page)
            assert tab.value("document.documentElement.scrollWidth") <= width
            assert serious(tab, rules) == []
            tab.value("document.querySelector('button[data-cell]').click()")
            assert serious(tab, rules) == []


def test_a_reproduction_leads_to_the_cells_of_its_members(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    shutil.copytree(folder / "data", tmp_path / "data")
    shutil.copy(folder / "looked_at.yaml", tmp_path)
    (tmp_path / "other.yaml").write_text(FILE.replace("looked_at", "other").replace("0.04", "0.06"))
    (tmp_path / "whole.yaml").write_text(WHOLE)
    assert view(tmp_path, "whole.yaml", "--no-open", monkeypatch=monkeypatch) == 0
    page = tmp_path / capfd.readouterr().out.strip()
    for link in re.findall(r'href="([\w./]+\.html)"', page.read_text()):
        assert page_data(page.parent / link)["trials"]["id"]
    assert "looked_at/index.html" in page.read_text()


def test_a_sweep_is_its_page_and_no_cell_of_its_box(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "swept.yaml").write_text(SWEPT)
    stored(tmp_path, asked=load_experiment(tmp_path / "swept.yaml"))
    (tmp_path / "whole.yaml").write_text(
        WHOLE.replace(", {experiment: other.yaml}", "").replace("looked_at", "swept")
    )
    for name in ("swept.yaml", "whole.yaml"):
        assert view(tmp_path, name, "--no-open", monkeypatch=monkeypatch) == 0
        page = tmp_path / capfd.readouterr().out.strip()
        assert page.is_file()
        assert not list(page.parent.rglob("replays.html"))
