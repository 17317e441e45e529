"""Reference tables: read as their files say, and the printed ones of the papers as printed."""

from __future__ import annotations

from pathlib import Path

import pytest

from gaitlab.errors import FileError, UnknownName
from gaitlab.experiment.reference import ReferenceCell, load_reference, names
from tests.written import EXPERIMENT, changed, problems, read

OURS = """
title: the team's log of May
source: the field book, 2025-05-03
rows: gait.step_length
readings: {steps: {one: 0.02, text: steps of two centimetres}}
printed: [1, 2, -1]
cells: {grass_30mm: [S, U, U], carpet_4mm: [S, S, S]}
"""
NAMES = ["eros_table7", "eros_table8"]


@pytest.mark.parametrize(
    ("name", "stated", "counted", "means"),
    [
        ("eros_table7", [10, 10, 30, 80], [30, 30, 50, 90], (32, 50)),
        ("eros_table8", [70, 70, 80, 100], [70, 70, 80, 100], (80, 80)),
    ],
)
def test_stated_and_counted_percentages_are_those_of_the_paper(
    name: str, stated: list[float], counted: list[float], means: tuple[float, float]
) -> None:
    table = load_reference(name)
    assert list(table.stated.values()) == stated
    assert list(table.counted.values()) == pytest.approx(counted)
    assert (table.content.stated_mean, table.counted_mean) == pytest.approx(means)


@pytest.mark.parametrize("name", NAMES)
def test_every_cell_is_found_by_the_value_it_stands_for_in_every_reading(name: str) -> None:
    table = load_reference(name)
    assert len(table.cells) == 40
    for reading, meant in table.readings.items():
        for place in table.cells:
            assert table.place(place.printed * meant.one, place.surface, reading) == place
    assert table.place(0.0413, "grass_50mm", "foot_travel") is None
    assert table.place(0.04, "hard_floor", "foot_travel") is None


def test_both_tables_print_the_same_backward_block() -> None:
    blocks = [
        {place: up for place, up in load_reference(name).cells.items() if place.printed < 0}
        for name in NAMES
    ]
    assert blocks[0] == blocks[1]
    assert len(blocks[0]) == 12
    assert {place.direction for place in blocks[0]} == {"backward"}


def test_half_an_optimisation_answers_to_no_table() -> None:
    both = {"gait.heel_strike": "add", "gait.landing_deceleration": "log_tail"}
    plain, optimised = map(load_reference, NAMES)
    assert (plain.answers(both), optimised.answers(both)) == (False, True)
    assert (plain.answers({}), optimised.answers({})) == (True, False)
    for path in both:
        half = {**both, path: "none"}
        assert not plain.answers(half)
        assert not optimised.answers(half)


def test_an_unknown_table_is_refused_with_the_known_ones() -> None:
    assert names() == NAMES
    with pytest.raises(UnknownName, match="eros_table7, eros_table8"):
        load_reference("eros_table9")


def test_a_team_writes_a_table_of_its_own_beside_its_experiment(tmp_path: Path) -> None:
    (tmp_path / "may.yaml").write_text(OURS)
    table = load_reference("may.yaml", tmp_path)
    assert table.cells[ReferenceCell(-1, "grass_30mm")] is False
    assert table.counted["carpet_4mm"] == 100.0
    assert table.place(-0.02, "grass_30mm", "steps") == ReferenceCell(-1, "grass_30mm")
    experiment = read(tmp_path, changed("compare: eros_table7", "compare: ./may.yaml"))
    assert experiment.report.compare == "./may.yaml"


def test_a_table_with_a_verdict_too_few_says_which(tmp_path: Path) -> None:
    (tmp_path / "may.yaml").write_text(OURS.replace("[S, U, U]", "[S, U]"))
    with pytest.raises(FileError, match="grass_30mm has 2 verdicts"):
        load_reference("may.yaml", tmp_path)


@pytest.mark.parametrize(
    ("wrong", "place"),
    [("compare: eros_table6", "compare"), ("distance_reading: inches", "distance_reading")],
)
def test_an_unknown_name_is_told_where_it_stands(tmp_path: Path, wrong: str, place: str) -> None:
    (problem,) = problems(tmp_path, changed("compare: eros_table7", wrong))
    assert problem.message.startswith(f"report.{place}: ")
    assert problem.line == EXPERIMENT.count("\n")
