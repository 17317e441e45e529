"""Falls in standing are counted apart, and a cell that does not stand has no verdict."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitlab.report.cells import agreement, cell_tables, compared, headline, verdicts_note
from gaitlab.report.comparison import compared_variants, comparison_blocks
from gaitlab.report.falls import falls_table
from gaitlab.report.forms.tables import cells_frame
from gaitlab.report.maps import cells_map
from gaitlab.report.page import not_standing
from gaitlab.report.results import Results
from gaitlab.report.scores import ScoredCell, cell_of, mean_percent, surface_percent
from gaitlab.report.words import DOES_NOT_STAND, cell_text, verdict_text
from tests.report.builder import results_of, toy_trials

SEEDS = 4
WHERE = ("grass_50mm", 0.04, "none")  # ground, step and heel strike of the cell that falls


def cell(up: int, walking: int, standing: int) -> ScoredCell:
    """So many seeds that stayed up, fell in walking and fell in standing."""
    outcomes = (True,) * up + (False,) * (walking + standing)
    return ScoredCell(
        stable=outcomes, strict=outcomes, infeasible=0, failed=0, missing=0, standing=standing
    )


def results(standing: int) -> Results:
    """The toy experiment with the first seeds of one cell fallen before their first step."""
    trials = toy_trials(SEEDS)
    for item in trials:
        here = (item["surface"], item["gait.step_length"], item["gait.heel_strike"]) == WHERE
        early = here and int(item["seed"]) < standing
        item["fell_standing"] = early
        if early:
            item |= {"fell": True, "stable": False, "stable_strict": False, "time_to_fall": -0.8}
            item |= {"fall_phase": float("nan"), "fall_direction": "backward"}
    return results_of(trials)


@given(st.integers(0, 12), st.integers(0, 12), st.integers(0, 12))
def test_a_cell_does_not_stand_if_more_than_half_of_it_fell_standing(up, walking, standing) -> None:
    found, n = cell(up, walking, standing), up + walking + standing
    assert found.stands == (standing <= n / 2)
    assert (found.verdict() is None) == (n == 0 or not found.stands)
    if n and not found.stands:
        assert verdict_text(found).rstrip("?") == DOES_NOT_STAND
    elif n:
        assert verdict_text(found)[0] == ("S" if up >= n / 2 else "U")


@given(st.integers(0, 12), st.integers(0, 12), st.integers(0, 12))
def test_a_verdict_is_marked_exactly_where_its_interval_holds_one_half(up, walking, standing):
    found = cell(up, walking, standing)
    if found.n and found.stands:
        low, high = found.interval()
        assert found.doubtful() == (low < 0.5 < high) == verdict_text(found).endswith("?")


def test_sure_cells_are_not_marked_and_near_ones_are() -> None:
    assert not cell(10, 0, 0).doubtful()
    assert cell(6, 4, 0).doubtful()
    assert not cell(0, 0, 10).doubtful()
    assert cell(4, 0, 6).doubtful()


def test_falls_in_standing_are_counted_beside_the_verdict() -> None:
    assert cell_text(cell(2, 3, 5)).startswith("U? 2/10 ")
    assert cell_text(cell(2, 3, 5)).endswith(", 5 fell standing")
    assert "standing" not in cell_text(cell(2, 8, 0))


def test_a_cell_that_does_not_stand_counts_as_not_stable() -> None:
    column = [cell(10, 0, 0), cell(0, 0, 10)]
    assert surface_percent(column) == 50.0
    assert mean_percent([column, [cell(0, 0, 10)]]) == 25.0


def test_a_store_from_before_standing_was_measured_counts_no_fall_in_it() -> None:
    frame = pd.DataFrame({"state": ["DONE"] * 3, "stable": [False] * 3, "stable_strict": False})
    assert cell_of(frame).standing == 0
    assert cell_of(frame.assign(fell_standing=None)).verdict() is False


@pytest.mark.parametrize("standing", [0, 2, 3, 4])
def test_cells_of_a_page_lose_their_verdict_only_where_most_fell_standing(standing: int) -> None:
    found = results(standing)
    frame = cells_frame(found)
    here = (frame["surface"] == WHERE[0]) & (frame["gait.step_length"] == WHERE[1])
    ours = frame[here & (frame["variant"] == "plain")].iloc[0]
    assert ours["fell_standing"] == standing
    assert (ours["verdict"] == DOES_NOT_STAND) == (standing > 2)
    assert set(frame[~here]["verdict"]) <= {"S", "U"}
    assert int(frame["fell_standing"].sum()) == standing
    assert (DOES_NOT_STAND in cell_tables(found)) == (standing > 2)
    assert (DOES_NOT_STAND in headline(found)) == (standing > 2)


def test_no_verdict_agrees_with_none_of_the_papers() -> None:
    before, after = results(0), results(4)
    counts = []
    for found in (before, after):
        plain = next(v for v in found.variants if v.label == "plain")
        pairs = [p for p in compared(found, plain) if p.ours.standing or found is before]
        counts.append(agreement(pairs).split(",")[0])
    assert counts[1] == "0/1"
    assert counts[0] != "0/0"


def test_every_part_of_the_page_is_made_of_cells_that_do_not_stand(tmp_path: Path) -> None:
    trials = toy_trials(SEEDS)
    for item in trials:
        item |= {"fell": True, "stable": False, "stable_strict": False, "fell_standing": True}
        item |= {"time_to_fall": -0.5, "fall_phase": float("nan"), "fall_direction": "left"}
    found = results_of(trials)
    frame = cells_frame(found)
    assert set(frame["verdict"]) == {DOES_NOT_STAND}
    assert not frame["stable"].any()
    assert str(len(frame)) in not_standing(found)
    n = len(trials)
    counts = [cell.strip() for cell in falls_table(found).splitlines()[-1].split("|")]
    assert counts[2:5] == [str(n), f"{n} of {n}", str(n)]
    assert comparison_blocks(found, compared_variants(found), [])
    assert cells_map(found, tmp_path)


def test_a_page_says_how_many_verdicts_seeds_could_turn() -> None:
    found = results(0)
    marked = cells_frame(found)["doubtful"]
    assert verdicts_note(found).startswith(f"**{int(marked.sum())} of {len(marked)} verdicts")
    sure = results_of(toy_trials(40))
    assert not cells_frame(sure)["doubtful"].any()
    assert verdicts_note(sure) == ""
