"""The published tables, read as printed."""

from __future__ import annotations

import pytest

from gaitlab.errors import UnknownName
from gaitlab.report.reference import (
    STEP_LENGTH_OF_ONE,
    DistanceReading,
    place_of,
    published,
    table_of_optimisation,
)


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
    printed = published(name)
    assert list(printed.stated.values()) == stated
    assert list(printed.all_counted.values()) == pytest.approx(counted)
    assert (printed.stated_efficiency, printed.counted_efficiency) == pytest.approx(means)


@pytest.mark.parametrize("reading", STEP_LENGTH_OF_ONE)
@pytest.mark.parametrize("name", ["eros_table7", "eros_table8"])
def test_every_printed_cell_is_found_by_the_step_length_it_stands_for(
    name: str, reading: DistanceReading
) -> None:
    for place in published(name).cells:
        step = place.distance * STEP_LENGTH_OF_ONE[reading]
        step = -step if place.direction == "backward" else step
        assert place_of(step, place.surface, reading) == place


def test_a_step_length_between_printed_numerals_has_no_cell() -> None:
    assert place_of(0.0413, "grass_50mm", "foot_travel") is None


def test_both_tables_print_the_same_backward_block() -> None:
    blocks = [
        {place: stable for place, stable in published(name).cells.items() if place[0] == "backward"}
        for name in ("eros_table7", "eros_table8")
    ]
    assert blocks[0] == blocks[1]


def test_half_an_optimisation_answers_to_no_table() -> None:
    both = {"gait.heel_strike": "add", "gait.landing_deceleration": "log_tail"}
    assert table_of_optimisation(both) == "eros_table8"
    assert table_of_optimisation({}) == "eros_table7"
    for path in both:
        assert table_of_optimisation({**both, path: "none"}) is None


def test_an_unknown_table_is_refused_with_the_known_ones() -> None:
    with pytest.raises(UnknownName, match="eros_table7, eros_table8"):
        published("eros_table9")
