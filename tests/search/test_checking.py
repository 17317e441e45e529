"""The check after a search as a user meets it. Trials are pretended, see `searches`."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import pytest

import gaitlab.running.processes
from gaitlab.cli import run_command_line
from gaitlab.search.database import command_line
from gaitlab.search.fresh import FIRST_FRESH
from gaitlab.store import Store
from tests.search import searches

FEW = ("study.trials=6", "seeds=2", "study.racing=off", "surfaces=[carpet_4mm]")
SHORT = tuple(word for setting in FEW for word in ("--set", setting))


@pytest.fixture(autouse=True)
def pretended(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setattr(gaitlab.running.processes, "simulated", searches.pretend)
    with searches.walked_by(searches.pretend):
        yield


def command(name: str, folder: Path, *more: str) -> int:
    words = [name, str(searches.FILE), "--store", str(folder / "data"), *SHORT, *more]
    return run_command_line(words)


@pytest.mark.long
def test_the_check_says_its_cost_and_then_what_holds(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert command("optimize", folder, "-j", "0") == 0
    out, err = capsys.readouterr()
    assert "Checking candidate" in err
    assert "--no-validation skips it" in err
    assert "On fresh seeds: stable " in out
    assert "optimism" in out
    assert "Against the hand-set default: walking speed" in out
    assert "May move alone before a fall" in out
    before = set(Store(folder / "data").states())
    assert command("optimize", folder, "-j", "0", "--json", "-q") == 0
    again, silent = capsys.readouterr()
    assert json.loads(again)["told"] == 6
    assert silent == ""
    assert set(Store(folder / "data").states()) == before


def test_without_the_check_no_fresh_seed_is_walked(folder: Path) -> None:
    assert command("optimize", folder, "-j", "0", "--no-validation") == 0
    store = Store(folder / "data")
    assert all(store.record(trial_id).trial["seed"] < FIRST_FRESH for trial_id in store.states())


@pytest.mark.long
def test_a_search_at_random_stands_beside_the_winner_in_the_report(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for more in ((), ("--baseline", "random")):
        assert command("optimize", folder, "-j", "0", "-q", *more) == 0
    before = set(Store(folder / "data").states())
    assert command("report", folder, "--output", str(folder / "report")) == 0
    assert set(Store(folder / "data").states()) == before, "a report walks nothing"
    page = (folder / "report" / "README.md").read_text()
    assert "best of random search on fresh seeds" in page
    assert page.count("fresh seeds") > 2
    capsys.readouterr()


def test_studies_and_experiments_are_not_mixed_in_a_report(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    store = str(folder / "data")
    assert run_command_line(["report", str(searches.FILE), "eros_quick", "--store", store]) == 2
    assert "only studies or only experiments" in capsys.readouterr().err
    assert command("report", folder) == 3
    assert "nothing was searched yet" in capsys.readouterr().err


def test_no_password_stands_on_a_page() -> None:
    address = "postgresql://lab:secret@server/walks"
    wanted, store = searches.study(), Store(Path("data"))
    lines = [command_line(verb, wanted, store, address) for verb in ("optimize", "report")]
    assert all("lab:***@server" in line for line in lines)
    assert not any("secret" in line for line in lines)
