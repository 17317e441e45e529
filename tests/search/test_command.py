"""`gaitlab optimize` as a user meets it. Trials are pretended, see `searches`."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import pytest

from gaitlab.cli import run_command_line
from gaitlab.experiment import load_experiment
from gaitlab.experiment.plan import plan
from gaitlab.store import Store
from tests.search import searches

SHORT = (
    "--trials",
    "8",
    "--set",
    "seeds=2",
    "--set",
    "study.racing=off",
    "-j",
    "0",
    "--no-validation",
)


@pytest.fixture(autouse=True)
def pretended() -> Iterator[None]:
    with searches.walked_by(searches.pretend):
        yield


@pytest.fixture
def store(folder: Path) -> str:
    return str(folder / "data")


def optimize(store: str, *more: str, study: str = str(searches.FILE)) -> int:
    return run_command_line(["optimize", study, "--store", store, *more])


def test_it_prints_the_best_and_what_it_took(
    store: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert optimize(store, *SHORT) == 0
    out, err = capsys.readouterr()
    assert out.startswith("8 of 8 candidates ")
    assert "Best: candidate" in out
    assert "n = 2 seeds on grass_50mm, carpet_4mm" in out
    assert "stable 1, asked for stable >= 0.5" in out
    assert "Report: gaitlab report" in out
    assert err.startswith("8 candidates, 0 finished before")


def test_the_same_command_again_only_reads(store: str, capsys: pytest.CaptureFixture[str]) -> None:
    optimize(store, *SHORT)
    first = capsys.readouterr().out
    assert optimize(store, *SHORT) == 0
    again = capsys.readouterr().out
    assert "0 trials walked" in again
    assert again.partition("0 trials walked")[0] == first.partition("32 trials walked")[0]


def test_json_is_one_object(store: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert optimize(store, *SHORT, "--json", "-q") == 0
    out, err = capsys.readouterr()
    found = json.loads(out)
    assert err == ""
    assert (found["told"], found["ending"], found["interrupted"]) == (8, "complete", False)
    assert found["best"]["values"]["gait.step_height"] <= 0.06
    assert found["walked"] == found["told"] * 4


def test_a_dry_run_says_what_it_takes_and_touches_nothing(
    store: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert optimize(store, "-n") == 0
    out = capsys.readouterr().out
    assert "18 candidates to try of 18: at most 144 trials" in out
    assert "gait.heel_gain" in out
    assert "when gait.heel_strike = add" in out
    assert optimize(store, "-n", "--json") == 0
    assert json.loads(capsys.readouterr().out)["trials"] == 144
    assert not Path(store).exists()


def test_the_exported_winner_walks_with_seeds_that_the_search_never_saw(
    store: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    target = folder / "best.yaml"
    assert optimize(store, *SHORT, "--json", "--export", str(target)) == 0
    best = json.loads(capsys.readouterr().out)["best"]
    written = load_experiment(target)
    assert written.study is None
    assert not set(written.seeds) & set(searches.study().seeds)
    for path, value in best["values"].items():
        assert written.parts.base_values(path) == [value]
    assert list(written.parts.surfaces) == ["grass_50mm", "carpet_4mm"]
    assert {item.trial.id for item in plan(written).trials()}.isdisjoint(
        Store(Path(store)).states()
    )
    assert f"n = {best['seeds']} seeds" in target.read_text()
    assert optimize(store, *SHORT, "--export", str(target)) == 0, "it may be written again"


@pytest.mark.parametrize(
    ("target", "message"),
    [
        ("best.json", "write best.yaml"),
        ("nowhere/best.yaml", "there is no folder"),
        ("mine.yaml", "there is another file of that name"),
    ],
)
def test_an_export_that_cannot_be_is_refused_before_anything_walks(
    store: str, folder: Path, target: str, message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "mine.yaml").write_text("name: mine\n")
    assert optimize(store, *SHORT, "--export", str(folder / target)) == 2
    assert message in capsys.readouterr().err
    assert not Path(store).exists()


def test_where_nobody_stays_up_it_says_so_and_exports_nothing(
    store: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with searches.walked_by(searches.fall):
        assert optimize(store, *SHORT, "--export", str(folder / "best.yaml")) == 0
    out, err = capsys.readouterr()
    assert "No candidate of 8 fulfils what the study asks for." in out
    assert "Nearest misses" in out
    assert "is not written" in err
    assert not (folder / "best.yaml").exists()


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (("--trials", "0"), 2, "from 1 to 1,000,000"),
        (("--trials", "many"), 2, "a whole number is expected"),
        (("-j", "-1"), 2, "--jobs -1"),
        (("--set", "study.sampler=tpee"), 3, "tpe"),
        (("--set", "study.sampler=gp"), 2, "gaitlab[gp]"),
        (("--storage", "walks.db"), 7, "An address looks like"),
    ],
)
def test_bad_input_ends_before_anything_walks(
    store: str,
    arguments: tuple[str, ...],
    code: int,
    message: str,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("gaitlab.search.sampling.find_spec", lambda name: None)
    assert optimize(store, "-j", "0", *arguments) == code
    err = capsys.readouterr().err
    assert message in err
    assert "Traceback" not in err
    assert not list(Path(store).glob("trials/*"))


def test_an_experiment_is_told_apart_from_a_study(
    store: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert optimize(store, study="eros_quick") == 2
    assert "gaitlab run" in capsys.readouterr().err
