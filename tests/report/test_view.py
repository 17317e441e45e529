"""`gaitlab view`: the cells of an experiment, and the walks that stand for them."""

from __future__ import annotations

import re
import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from gaitlab.cli import run_command_line
from gaitlab.experiment import Experiment, load_experiment
from gaitlab.experiment.plan import plan
from gaitlab.report.gather import gather
from gaitlab.report.representative import worst
from gaitlab.report.view import write_view
from gaitlab.store import Store, TrialRecord
from tests.report.browser import CHROMIUM, SOFTWARE_GL, browser
from tests.walked import walked

FILE = """\
name: looked_at
robot: eros
gait: {type: eros}
surfaces: [grass_50mm, hard_floor]
grid: {gait.step_length: [0.0, 0.04]}
seeds: 3
"""
TRIAL = re.compile(r'"id":"([0-9a-f]{32})"')


def stored(folder: Path, state: str = "DONE") -> Store:
    """A store in which every trial of the file walked as one that is recorded; some fell."""
    asked, store = experiment(folder), Store(folder / "data")
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
    assert view(folder, "eros_small", "--no-open", monkeypatch=monkeypatch) == 2  # a study
    assert view(folder, "nowhere", "--no-open", monkeypatch=monkeypatch) == 3
    assert (tmp_path / "file").read_text() == (tmp_path / "own" / "replays.html").read_text()


def test_a_form_is_asked_for_by_its_options(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = replace(experiment(tmp_path), form="seeds-1")
    Store(tmp_path / "data").register(asked, plan(asked).trials())
    assert view(tmp_path, "--no-open", monkeypatch=monkeypatch) == 2
