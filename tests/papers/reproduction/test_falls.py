"""The section on falls, from logs that are written by formula and kept in a real store."""

from __future__ import annotations

from pathlib import Path

import pytest

from gaitlab.log import TrialLog
from gaitlab.papers.reproduction.section import Context, Section
from gaitlab.papers.reproduction.sections import falls
from gaitlab.report.results import Results
from gaitlab.store import Store, TrialRecord
from tests.report.builder import results_of, trial
from tests.synthetic import fall, sine, walk

HIGH, LOW = "grass_50mm", "carpet_4mm"
SEEDS = 10
BEHIND = -0.03  # m, ZMP of the walks that fall


def made_log(heel: str, surface: str, seed: int) -> TrialLog:
    """Plain walks on high grass fall backward but for five seeds, all others stay up."""
    zmp, height = 0.001 * seed, 0.25  # m
    if heel == "none" and surface == HIGH and seed < SEEDS - 5:
        return fall(
            "backward", at=3.0 + 0.1 * seed, zmp_x=BEHIND + zmp, roll=sine(0.02), com_z=height
        )
    return walk(zmp_x=zmp, pitch=sine(0.02), roll=sine(0.02), com_z=height)


@pytest.fixture
def made(tmp_path: Path) -> tuple[Results, Store]:
    store, rows = Store(tmp_path / "data"), []
    for heel in ("none", "add"):
        for surface in (HIGH, LOW):
            for seed in range(SEEDS):
                log = made_log(heel, surface, seed)
                row = trial(0.04, surface, heel, seed, up=log.fall_index is None)
                row["fall_direction"] = None if log.fall_index is None else "backward"
                rows.append(row)
                store.commit(recorded(str(row["trial_id"])), log)
    return results_of(rows, compare=False), store


def recorded(name: str) -> TrialRecord:
    return TrialRecord(trial_id=name, state="DONE", reason="", trial={}, metrics={}, provenance={})


def text_of(results: Results, store: Store, folder: Path, **options: object) -> str:
    given = {option.name: option.default for option in falls.OPTIONS} | {"film": False} | options
    section = Section(kind="falls", title="", text="", experiments=("toy",), options=given)
    context = Context(results={"toy": results}, experiments={}, store=store, folder=folder)
    return falls.falls_section(section, context)


def row(text: str, label: str) -> list[str]:
    line = next(line for line in text.splitlines() if line.startswith(f"| {label} "))
    return [cell.strip() for cell in line.strip("|").split("|")][1:]


def test_a_ground_says_how_its_walks_fall_and_what_differs(
    made: tuple[Results, Store], tmp_path: Path
) -> None:
    text = text_of(*made, tmp_path)
    assert row(text, "grass 50 mm")[:4] == ["plain", "5 of 10", "0", "5"]
    assert row(text, "grass 50 mm")[7:9] == ["5", "0"]  # fore-aft, sideways
    assert row(text, "carpet 4 mm")[1] == "0 of 10"
    assert "less the same step and seed on carpet 4 mm" in text
    assert "grass 50 mm, 5 pairs" in text
    assert "-30.0 [-30.0, -30.0]" in text  # mm, the same seed less BEHIND
    assert "nan" not in text


def test_five_seeds_differ_and_tell_nothing(made: tuple[Results, Store], tmp_path: Path) -> None:
    """Thirty-two signs of five seeds leave one chance in sixteen, whatever the difference."""
    table = text_of(*made, tmp_path).partition("### Falls of")[2].partition("###")[0]
    assert "**" not in table


def test_another_reference_turns_the_comparison_round(
    made: tuple[Results, Store], tmp_path: Path
) -> None:
    text = text_of(*made, tmp_path, reference=HIGH)
    assert "less the same step and seed" not in text  # nothing falls on the carpet


def test_only_the_variants_asked_for_are_compared(
    made: tuple[Results, Store], tmp_path: Path
) -> None:
    both, one = text_of(*made, tmp_path), text_of(*made, tmp_path, variants=("plain",))
    assert "### Other variants" in both
    assert "### Other variants" not in one
    assert text_of(*made, tmp_path, variants=("nothing",)) == "Nothing was simulated yet."


def test_a_member_without_results_is_said_to_have_none(tmp_path: Path) -> None:
    given = {option.name: option.default for option in falls.OPTIONS}
    section = Section(kind="falls", title="", text="", experiments=("toy",), options=given)
    context = Context(results={}, experiments={}, store=Store(tmp_path), folder=tmp_path)
    assert falls.falls_section(section, context) == "Nothing was simulated yet."
