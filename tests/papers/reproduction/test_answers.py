"""Agreement with printed tables, against counts made by hand from the paper."""

from __future__ import annotations

import pytest

from gaitlab.errors import WrongValue
from gaitlab.papers.reproduction.answers import (
    NOWHERE,
    agreement,
    always_stable,
    answers,
    best_constant,
    forward_only,
    judged,
    limits,
    ordered,
    ranking,
    require_known,
    untouched_grounds,
)
from tests.papers.reproduction.printed import printed_results

CALIBRATED = {
    "eros_table7": {"direction": "forward"},
    "eros_table8": {"direction": "forward", "surfaces": ("carpet_4mm", "grass_30mm")},
}


def cells_of(outcome=None, calibrated=CALIBRATED):
    """Judged cells of both tables."""
    results = printed_results(*([outcome] if outcome else []))
    return [judged(answer, calibrated) for answer in answers({"a": results}, ["a"])]


def forward(cells):
    return [cell for cell in cells if cell.place.direction == "forward"]


def test_results_as_printed_agree_in_all_forty_cells_of_both_tables() -> None:
    for cells in cells_of():
        assert agreement(cells) == (40, 40)
        assert agreement(forward(cells)) == (28, 28)


def test_the_opposite_of_what_is_printed_agrees_nowhere() -> None:
    for cells in cells_of(lambda table, place, stable, seed: not stable):
        assert agreement(cells) == (0, 40)


def test_half_of_the_seeds_make_a_stable_cell() -> None:
    for cells in cells_of(lambda table, place, stable, seed: seed < 2 if stable else seed < 1):
        assert agreement(cells) == (40, 40)


def test_guessing_scores_what_counting_the_printed_tables_gives() -> None:
    before, after = (forward(cells) for cells in cells_of())
    assert always_stable(before) == (1 + 1 + 3 + 6, 28)
    assert always_stable(after) == (5 + 5 + 6 + 7, 28)
    assert best_constant(before) == (6 + 6 + 4 + 6, 28)
    assert best_constant(after) == (5 + 5 + 6 + 7, 28)


def test_no_constant_verdict_beats_the_best_one_of_its_ground() -> None:
    for cells in cells_of():
        stable, n = always_stable(cells)
        assert best_constant(cells).successes >= max(stable, n - stable)


def test_cells_count_as_calibrated_only_where_the_file_says_so() -> None:
    before, after = cells_of()
    assert {cell.calibrated for cell in forward(before)} == {True}
    assert sum(cell.calibrated for cell in before) == 28
    assert sum(cell.calibrated for cell in after) == 14
    assert {c.place.surface for c in after if c.calibrated} == {"carpet_4mm", "grass_30mm"}
    assert untouched_grounds(after) == ["grass_50mm", "grass_10mm"]
    assert not any(cell.calibrated for cells in cells_of(calibrated={}) for cell in cells)


def test_a_table_may_have_several_blocks_that_constants_were_chosen_on() -> None:
    carpet = {"direction": "backward", "surfaces": "carpet_4mm", "distances": (8, 16)}
    before, _ = cells_of(calibrated={"eros_table7": ({"direction": "forward"}, carpet)})
    backward = [cell.place for cell in before if cell.calibrated and cell not in forward(before)]
    assert backward == [(-8, "carpet_4mm"), (-16, "carpet_4mm")]
    assert sum(cell.calibrated for cell in before) == 30


def test_variants_answer_by_their_halves_where_the_experiment_names_no_table() -> None:
    silent = printed_results(compare=False)
    found = answers({"a": silent}, ["a"])
    assert [answer.table.name for answer in found] == ["eros_table7", "eros_table8"]
    assert [agreement(judged(answer, {})) for answer in found] == [(40, 40), (40, 40)]


@pytest.mark.parametrize(
    ("calibrated", "found"),
    [
        ({"eros_table9": {}}, "eros_table9"),
        ({"eros_table7": {"rows": 3}}, "rows"),
        ({"eros_table7": {"direction": "sideways"}}, "sideways"),
        ({"eros_table7": {"surfaces": ("grass_5mm",)}}, "grass_5mm"),
        ({"eros_table7": {"surfaces": "grass_5mm"}}, "grass_5mm"),
        ({"eros_table7": ({"direction": "forward"}, {"distances": (5,)})}, "5"),
    ],
)
def test_an_unknown_name_in_calibrated_is_refused_with_the_known_ones(calibrated, found) -> None:
    with pytest.raises(WrongValue, match=f"found '{found}'.*Known"):
        require_known(calibrated)


def test_known_names_in_calibrated_pass() -> None:
    require_known(CALIBRATED)


def test_forward_only_leaves_the_backward_rows_out() -> None:
    (first, _) = answers({"a": printed_results()}, ["a"])
    assert agreement(judged(forward_only(first), {})) == (28, 28)


def test_limits_are_the_longest_stable_rows_of_the_printed_tables() -> None:
    before, after = (limits(cells) for cells in cells_of())
    grounds = ("grass_50mm", "grass_30mm", "grass_10mm", "carpet_4mm")
    assert [before.paper[ground] for ground in grounds] == [0, 0, 8, 20]
    assert [after.paper[ground] for ground in grounds] == [16, 16, 20, 24]
    assert before.ours == before.paper


def test_a_limit_ends_at_the_first_row_that_falls() -> None:
    def outcome(table, place, stable, seed):
        return place.distance > 0  # walks on the spot fall, everything else stands

    for cells in cells_of(outcome):
        assert set(limits(cells).ours.values()) == {NOWHERE}


def test_the_order_of_the_grounds_is_counted_over_pairs_that_the_paper_tells_apart() -> None:
    before, _ = cells_of()
    assert ordered(limits(before)) == (5, 0, 0)
    everything_stands, _ = cells_of(lambda table, place, stable, seed: True)
    assert ordered(limits(everything_stands)) == (0, 5, 0)
    reverse = {"grass_50mm": 24, "grass_30mm": 20, "grass_10mm": 8, "carpet_4mm": 0}
    upside_down, _ = cells_of(lambda t, place, s, seed: place.distance <= reverse[place.surface])
    assert ordered(limits(upside_down)) == (0, 0, 5)


def test_a_ranking_puts_equal_limits_together() -> None:
    assert ranking({"a": 0, "b": 20, "c": 0}) == [["b"], ["a", "c"]]
