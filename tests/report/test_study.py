"""The page of a study: what it says about candidates and walks that are known beforehand."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gaitlab.experiment.study import Numbers
from gaitlab.report.study.findings import Findings
from gaitlab.report.study.fresh import crossings, gain, optimism, score
from gaitlab.report.study.page import rows_of, write_pages_together, write_study_page
from gaitlab.report.study.sentences import chance, sentences
from gaitlab.report.study.tables import (
    constraints_table,
    fresh_table,
    margins_table,
    near_misses,
    winner_table,
)
from gaitlab.search.candidates import edge_of
from gaitlab.search.fresh import DEFAULT, RANDOM, WINNER, Rerun
from tests.report.study_builder import (
    SPEED,
    SWAY,
    TUNED,
    hopeless,
    study,
    toy_experiment,
    toy_findings,
    walks,
)

UP: dict[str, int] = {}
speeds = st.floats(0.01, 0.3)


def rerun(speed: float, falls: dict[str, int] = UP, label: str = WINNER) -> Rerun:
    return Rerun(label=label, values={}, walks=walks(speed, falls))


@settings(max_examples=10)
@given(speeds, st.integers(0, 10))
def test_an_objective_lies_within_its_interval(speed: float, falls: int) -> None:
    found = score(study(), rerun(speed, {TUNED: falls}).on([TUNED]), 0)
    assert found.interval.low <= found.value <= found.interval.high
    assert found.seeds == 10


@settings(max_examples=10)
@given(speeds, speeds)
def test_a_lead_turned_round_is_a_deficit(one: float, other: float) -> None:
    here, there = rerun(one), rerun(other)
    lead, deficit = (gain(study(), *pair, 0, [TUNED]) for pair in ((here, there), (there, here)))
    assert lead.value == -deficit.value
    words = {"better": "worse", "worse": "better", "cannot tell": "cannot tell"}
    assert lead.verdict == words[deficit.verdict]


def test_a_gait_has_no_lead_over_itself() -> None:
    lead = gain(study(), rerun(0.1), rerun(0.1), 0, [TUNED])
    assert lead.value == 0.0
    assert lead.verdict == "cannot tell"


def test_a_smaller_number_leads_when_smaller_is_better() -> None:
    asked = study((SWAY,))
    rolling = [
        replace(walk, metrics={**walk.metrics, "roll_amplitude": 0.5}) for walk in walks(1, {})
    ]
    lead = gain(asked, rerun(0.1), Rerun(label="", values={}, walks=tuple(rolling)), 0, [TUNED])
    assert lead.value > 0
    assert lead.verdict == "better"


def test_falling_always_is_infinitely_worse_and_said_so() -> None:
    asked = study((SWAY,))
    lead = gain(asked, rerun(0.1), rerun(0.1, {TUNED: 10}), 0, [TUNED])
    assert lead.value == math.inf
    assert lead.verdict == "better"


def test_optimism_is_what_fresh_seeds_take_away() -> None:
    assert optimism(0.5, 0.4, SPEED) == pytest.approx(0.1)
    assert optimism(0.5, 0.4, SWAY) == pytest.approx(-0.1)
    assert optimism(math.inf, 0.4, SPEED) is None


def test_the_page_sets_the_search_beside_fresh_seeds() -> None:
    found = toy_findings()
    text = fresh_table(found)
    assert found.chosen is not None
    assert "winner in the search" in text
    assert f"{found.chosen.objectives[0]:.4g}" in text
    assert "On fresh seeds the winner stays up in 10/10" in sentences(found)


def test_a_default_as_good_as_the_winner_cannot_be_told_apart() -> None:
    same = (rerun(0.1), rerun(0.1, label=DEFAULT))
    found = replace(toy_findings(), reruns=same)
    assert "cannot tell" in fresh_table(found)
    assert "cannot be told from that of the hand-set default" in sentences(found)


def test_grounds_on_which_the_winner_falls_are_named() -> None:
    assert "On grass 50 mm it falls in more than half of the walks" in sentences(toy_findings())
    steady = replace(toy_findings(), reruns=(rerun(0.1),))
    assert "it falls in more than half" not in sentences(steady)


def test_without_a_random_search_the_page_says_the_command(tmp_path: Path) -> None:
    bare, whole = (
        replace(
            toy_findings(baseline=known), candidates=toy_findings().candidates[:3], margins=None
        )
        for known in (False, True)
    )
    assert "--baseline random" in write_study_page(bare, tmp_path / "bare").read_text()
    page = write_study_page(whole, tmp_path / "whole").read_text()
    assert "--baseline random" not in page.partition("<details>")[0]
    assert RANDOM in fresh_table(whole)
    assert "Random search tried" in chance(whole)


def test_a_page_answers_on_one_screen_and_links_the_rest(tmp_path: Path) -> None:
    text = write_study_page(toy_findings(), tmp_path).read_text()
    assert len(text.splitlines()) <= 150
    assert text.count("![") == 1
    assert "](details.md)" in text


def test_a_broken_constraint_stands_out_on_fresh_seeds() -> None:
    fallen = replace(toy_findings(), reruns=(rerun(0.1, {TUNED: 8}),))
    assert "0.2, **broken**" in constraints_table(fallen)
    assert "**broken**" not in constraints_table(toy_findings())


@given(st.floats(0.0, 1.0), st.booleans())
def test_only_values_near_an_end_are_at_the_edge(share: float, log: bool) -> None:
    item = Numbers(path="gait.step_height", low=0.01, high=0.1, log=log)
    at = 0.01 * 10**share if log else 0.01 + 0.09 * share
    expected = "lower" if share < 0.019 else "upper" if share > 0.981 else ""
    if not (0.019 <= share <= 0.021 or 0.979 <= share <= 0.981):
        assert edge_of(item, at) == expected


def test_a_parameter_whose_condition_fails_is_not_used() -> None:
    found = toy_findings()
    assert found.chosen is not None
    assert "gait.trunk_pitch" not in found.chosen.values
    (line,) = [line for line in winner_table(found).splitlines() if "trunk_pitch" in line]
    assert "not used" in line


def test_limits_are_given_in_the_unit_and_as_shares_of_the_range() -> None:
    (line,) = [row for row in margins_table(toy_findings()).splitlines() if "step_height" in row]
    assert "0.029, falls at 0.0281" in line
    assert re.search(r"\| +2 % +\|", line)
    assert "0.045, out of reach at 0.05" in line


def test_a_study_in_which_nothing_is_good_enough_names_the_nearest_misses(tmp_path: Path) -> None:
    found = hopeless()
    page = write_study_page(found, tmp_path).read_text()
    assert "No candidate of 40 is good enough" in page
    assert "The nearest misses:" in page
    assert "hand-set default" not in page
    assert all(candidate.state != "infeasible" for candidate in near_misses(found))


def test_misses_that_crowd_at_an_edge_name_the_range_to_widen() -> None:
    found = hopeless()
    crowded = [replace(c, values={**c.values, "gait.step_height": 0.06}) for c in found.candidates]  # type: ignore[type-var]
    text = sentences(replace(found, candidates=crowded))
    assert "widen `gait.step_height` beyond its upper end" in text


@pytest.mark.long
def test_the_same_findings_give_the_same_bytes(tmp_path: Path) -> None:
    found = toy_findings((SPEED, SWAY), baseline=False)
    pages = [write_study_page(found, tmp_path / name) for name in ("one", "two")]
    files = [sorted(page.parent.iterdir()) for page in pages]
    assert [file.name for file in files[0]] == [file.name for file in files[1]]
    assert [f.read_bytes() for f in files[0]] == [f.read_bytes() for f in files[1]]
    text = pages[0].read_text() + pages[0].with_name("details.md").read_text()
    shown = set(re.findall(r"\]\((\w+\.png)\)", text))
    assert shown == {file.name for file in files[0] if file.suffix == ".png"}
    assert "front.png" in shown


def other_study() -> Findings:
    """The same robot tuned on grass; its default walked as that of the first."""
    first = toy_findings(baseline=False)
    experiment = replace(toy_experiment(), name="grass_study")
    grounds = {"grass_10mm": experiment.parts.surfaces[TUNED]}
    experiment = replace(experiment, parts=replace(experiment.parts, surfaces=grounds))
    winner = rerun(0.09, {TUNED: 5})
    return replace(first, experiment=experiment, reruns=(winner, first.reruns[1]))


def test_several_studies_share_one_matrix_with_a_row_for_each() -> None:
    rows = rows_of([toy_findings(baseline=False), other_study()])
    assert list(rows) == [
        "carpet 4 mm, toy_study",
        "nothing, hand-set default",
        "grass 10 mm, grass_study",
    ]
    assert rows["grass 10 mm, grass_study"][TUNED].stable == 5
    tuned = {label: [g for g, cell in row.items() if cell.tuned] for label, row in rows.items()}
    assert list(tuned.values()) == [["carpet_4mm"], [], ["grass_10mm"]]


def test_a_page_over_several_studies_links_the_page_of_each(tmp_path: Path) -> None:
    bare = [
        replace(found, candidates=(), importance=[], margins=None)
        for found in (toy_findings(), other_study())
    ]
    page = write_pages_together(bare, tmp_path)
    links = re.findall(r"\]\((\w+/README\.md)\)", page.read_text())
    assert links == ["toy_study/README.md", "grass_study/README.md"]
    assert all((tmp_path / link).is_file() for link in links)


def test_walks_that_are_not_there_count_for_nothing() -> None:
    found = toy_findings()
    gone = tuple(replace(walk, state="MISSING", metrics={}) for walk in walks(0.1, {}))
    empty = replace(found, reruns=(Rerun(label=WINNER, values={}, walks=gone),), margins=None)
    assert crossings(empty) == {}
    assert "not been walked on fresh seeds yet" in sentences(empty)
