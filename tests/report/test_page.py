"""The page: what it says about trials whose outcome is known beforehand."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pandas as pd
import pytest

from gaitlab.experiment.reference import load_reference
from gaitlab.report.cells import agreement, cell_tables, compared, headline, row_title, runs_table
from gaitlab.report.comparison import compared_grounds, compared_variants
from gaitlab.report.falls import falls_table, quartiles, reasons
from gaitlab.report.motion import strip_blocks
from gaitlab.report.page import Sources, findings, heading, scores, write_page
from gaitlab.report.provenance import seeds_text
from gaitlab.report.representative import representative, representative_cell
from gaitlab.report.results import Results
from tests.report.builder import results_of, toy_trials, trial

SOURCES = Sources(facts={"seeds": "0 to 3"}, parts=[], grounds="", command="gaitlab report toy")


def paper_trials(seeds: int = 2) -> list[dict[str, object]]:
    """Trials that come out exactly as the paper prints."""
    return [
        trial(
            place.printed / 200,
            place.surface,
            heel,
            seed,
            up=up,
        )
        for name, heel in (("eros_table7", "none"), ("eros_table8", "add"))
        for place, up in load_reference(name).cells.items()
        for seed in range(seeds)
    ]


def said(results: Results) -> str:
    return findings(results, compared_variants(results), compared_grounds(results))


def row(text: str, label: str) -> list[str]:
    (line,) = [line for line in text.splitlines() if line.startswith(f"| {label} ")]
    return [cell.strip() for cell in line.strip("|").split("|")][1:]


def test_trials_that_repeat_the_paper_give_its_counts_and_agree_everywhere() -> None:
    results = results_of(paper_trials())
    text = headline(results)
    assert [cell.split(" %")[0] for cell in row(text, "plain")] == ["30", "30", "50", "90", "50"]
    optimised = row(text, "heel strike + landing deceleration")
    assert [cell.split(" %")[0] for cell in optimised] == ["70", "70", "80", "100", "80"]
    assert row(text, "printed, counted")[-1] == "50 → 80 %"
    assert row(text, "printed, counted") == row(text, "printed, our rows only")
    for variant in results.variants:
        pairs = compared(results, variant)
        assert len(pairs) == 40
        assert agreement(pairs).startswith("40/40, 100 %")
    assert "**" not in cell_tables(results)


def test_a_cell_that_differs_from_the_paper_stands_out() -> None:
    trials = paper_trials()
    for item in trials:
        if item["trial_id"].startswith("none-carpet_4mm-0.04-"):
            item.update(stable=False, stable_strict=False, fell=True)
    bold = re.findall(r"\*\*(.+?)\*\*", cell_tables(results_of(trials)))
    assert bold == ["U? 0/2 [0–66] (S)"]


def test_no_share_stands_without_its_count() -> None:
    results = results_of(toy_trials())
    for label in ("plain", "plain, strict", "heel strike + landing deceleration"):
        *cells, mean = row(headline(results), label)
        assert all(re.fullmatch(r"\d+ % \(\d+/\d+\)", cell) for cell in cells)
        assert re.fullmatch(r"\d+ % \[\d+–\d+\]", mean)


def test_rows_name_the_printed_distance_and_the_step_length() -> None:
    assert row_title(results_of(toy_trials()), -0.04) == "8 (-0.04 m)"
    assert row_title(results_of(toy_trials(), compare=False), -0.04) == "-0.04 m"


def test_without_a_reference_table_nothing_is_compared() -> None:
    results = results_of(toy_trials(), compare=False)
    assert "printed" not in headline(results)
    assert "(S)" not in cell_tables(results)


def test_the_strict_score_takes_back_runs_that_went_nowhere() -> None:
    text = headline(results_of(toy_trials()))
    literal, strict = row(text, "plain")[3], row(text, "plain, strict")[3]
    assert (literal, strict) == ("75 % (3/4)", "50 % (2/4)")


def test_infeasible_failed_and_missing_trials_are_shown_with_counts() -> None:
    trials = toy_trials()
    states = {"grass_10mm": "INFEASIBLE", "carpet_4mm": "FAILED", "grass_30mm": "MISSING"}
    for i, item in enumerate(trials):
        if item["gait.step_length"] == 0.08 and item["surface"] in states:
            up = dict.fromkeys(("stable", "stable_strict", "fell"))
            trials[i] = {**item, **up, "state": states[str(item["surface"])], "reason": "too | far"}
    results = results_of(trials)
    text = cell_tables(results)
    assert all(note in text for note in ("INFEASIBLE 4/4", "4 failed", "4 missing"))
    assert "of the cells within reach" in headline(results)
    assert row(falls_table(results), "all")[-3:] == ["8", "8", "8"]
    assert r"too \| far" in reasons(results)


def test_falls_are_counted_by_direction() -> None:
    trials = [trial(0.04, "a", "none", seed, up=False) for seed in range(4)]
    for item, direction in zip(trials, ("forward", "left", "left", "backward"), strict=True):
        item["fall_direction"] = direction
    text = falls_table(results_of(trials))
    titles = [title.strip() for title in text.splitlines()[0].strip("|").split("|")][1:]
    cells = dict(zip(titles, row(text, "plain"), strict=True))
    counts = {"trials": "4", "falls": "4 of 4", "forward": "1", "backward": "1", "left": "2"}
    assert counts.items() <= cells.items()
    assert not {"right", "before the first step", "failed"} & set(cells)  # nothing but zeros


def test_the_shown_seed_is_the_one_of_median_distance_in_any_order() -> None:
    trials = pd.DataFrame([trial(0.04, "a", "none", seed) for seed in (4, 0, 3, 1, 2)])
    assert representative(trials).endswith("-2")
    assert representative(trials.iloc[::-1]) == representative(trials)


def test_the_shown_cell_is_where_the_variants_differ_most() -> None:
    results = results_of(toy_trials())
    assert representative_cell(results) == (0.04, "grass_50mm")


def test_equal_variants_are_not_told_apart() -> None:
    trials = [t for t in toy_trials() if t["gait.heel_strike"] == "none"]
    copies = [{**t, "gait.heel_strike": "add", "trial_id": f"b-{t['trial_id']}"} for t in trials]
    text = said(results_of([*trials, *copies], paths=["gait.heel_strike"]))
    assert "cannot be told" in text
    assert "0 points" in text


def test_one_discordant_run_is_not_called_an_effect() -> None:
    trials = [t for t in toy_trials() if t["gait.heel_strike"] == "none"]
    copies = [{**t, "gait.heel_strike": "add", "trial_id": f"b-{t['trial_id']}"} for t in trials]
    fallen = next(t for t in copies if not t["stable"])
    fallen.update(stable=True, fell=False)
    text = said(results_of([*trials, *copies], paths=["gait.heel_strike"]))
    assert "cannot be told" in text


def test_quartiles_carry_their_n() -> None:
    assert quartiles(pd.Series([1.0, None, 3.0, 2.0])) == "2 [1.5, 2.5], n = 3"
    assert quartiles(pd.Series([None, None], dtype=object)) == "—"


def test_seeds_are_listed_as_ranges() -> None:
    assert seeds_text([3, 1, 2, 9, 2]) == "1 to 3, 9"


@pytest.mark.long
def test_the_same_results_give_the_same_bytes(tmp_path: Path) -> None:
    trials = [t for t in toy_trials(seeds=2) if t["surface"] != "grass_10mm"]
    pages = [write_page(results_of(trials), SOURCES, tmp_path / name) for name in "ab"]
    files = [{f.name: f.read_bytes() for f in page.parent.iterdir()} for page in pages]
    assert {"README.md", "details.md", "stable_share.png", "balance.png"} <= set(files[0])
    assert files[0] == files[1]


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The page of the toy, under a title that would be markup."""
    hostile = replace(results_of(toy_trials(seeds=2)), title="<script>*x*</script> | `y`")
    return write_page(hostile, SOURCES, tmp_path_factory.mktemp("page"))


def test_every_image_of_the_page_lies_beside_it(page: Path) -> None:
    images = re.findall(r"!\[[^]]+\]\(([^)]+)\)", page.read_text(encoding="utf-8"))
    assert len(images) == 6
    assert all(page.with_name(name).is_file() for name in images)


def test_a_title_of_the_user_never_becomes_markup(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    assert "<script>" not in text
    assert text.startswith(r"# \<script\>\*x\*\</script\> \| \`y\`")


@pytest.mark.parametrize("columns", ["seed", "surface"])
def test_other_layouts_give_a_table_too(tmp_path: Path, columns: str) -> None:
    results = results_of(toy_trials(seeds=2), rows="gait.heel_strike", columns=columns, paths=())
    write_page(results, SOURCES, tmp_path)
    text = (tmp_path / "details.md").read_text(encoding="utf-8")
    assert "add" in text
    assert "none" in text


def test_a_page_without_any_finished_trial_says_so(tmp_path: Path) -> None:
    trials = [trial(0.04, "a", "none", seed, state="FAILED") for seed in range(2)]
    text = write_page(results_of(trials), SOURCES, tmp_path).read_text(encoding="utf-8")
    assert "nothing can be said" in text
    assert "2 trials failed" in text


def test_the_second_page_says_the_command_that_makes_it_again(page: Path) -> None:
    lines = page.with_name("details.md").read_text("utf-8").splitlines()
    assert SOURCES.command in lines


def test_a_page_answers_on_one_screen_and_links_the_rest(page: Path) -> None:
    text = page.read_text("utf-8")
    assert len(text.splitlines()) <= 150
    screen = text.partition("<details>")[0]
    assert screen.count("![") == 1
    assert "](details.md)" in screen
    lines = [line for line in text.splitlines() if len(line) > 40 and not line.startswith("|")]
    assert len(set(lines)) == len(lines)


def test_the_next_step_is_the_seeds_that_would_tell(tmp_path: Path) -> None:
    trials = [
        trial(0.04, "a", heel, seed, up=heel == "add" or seed != 1)
        for heel in ("none", "add")
        for seed in range(3)
    ]
    asked = replace(SOURCES, with_seeds=lambda seeds: f"gaitlab run toy --seeds {seeds}")
    text = write_page(results_of(trials, compare=False), asked, tmp_path).read_text("utf-8")
    (seeds,) = re.findall(r"gaitlab run toy --seeds (\d+)", text)
    assert f"some {seeds} seeds a cell would tell" in text


def test_the_frames_of_a_fall_end_with_it_and_come_with_the_same_seed(tmp_path: Path) -> None:
    blocks = strip_blocks(results_of(toy_trials(seeds=2)), tmp_path)
    assert [block.split("](")[1] for block in blocks[:2]] == ["fall.png)", "same_seed.png)"]
    assert blocks[0].startswith("![plain, seed 1")
    assert blocks[1].startswith("![heel strike + landing deceleration, seed 1")
    assert "*plain* on grass 50 mm, seed 1" in blocks[2]


def test_without_a_fall_there_are_no_frames(tmp_path: Path) -> None:
    assert strip_blocks(results_of([trial(0.04, "grass_50mm", "none", 0)]), tmp_path) == []


def partial(lost: list[tuple[str, str]]) -> Results:
    """Both variants walk alike, and of some the trials on some grounds are not there yet."""
    trials = toy_trials()
    plain = {
        (t["gait.step_length"], t["surface"], t["seed"]): t for t in trials[: len(trials) // 2]
    }
    alike = []
    for one in trials:
        told = plain[one["gait.step_length"], one["surface"], one["seed"]]
        kept = {k: told[k] for k in ("state", "stable", "stable_strict", "fell")}
        if (one["gait.heel_strike"], one["surface"]) in lost:
            kept = {"state": "MISSING", "stable": None, "stable_strict": None, "fell": None}
        alike.append({**one, **kept})
    return results_of(alike, compare=False)


@pytest.mark.parametrize(
    "lost",
    [
        [("add", "grass_50mm")],
        [("none", "carpet_4mm")],
        [("add", "grass_50mm"), ("none", "carpet_4mm")],
    ],
)
def test_variants_are_compared_in_what_both_have(lost) -> None:
    results = partial(lost)
    there = len(results.trials) - 16 * len(lost)
    assert f"({there} of {len(results.trials)} trials, compared in the " in heading(results)
    note, runs = scores(results, compared_variants(results))
    first, second = (v.label for v in results.variants)
    assert row(runs, first) == row(runs, second)
    assert f"of the {16 * (4 - len(lost))} runs a variant" in note
    assert "0 points" in row(runs, f"*{second}* less")[-1]


def test_variants_without_a_common_run_are_not_compared() -> None:
    lost = [("add", "grass_50mm"), ("add", "grass_30mm")]
    lost += [("none", "grass_10mm"), ("none", "carpet_4mm")]
    results = partial(lost)
    assert "not compared" in " ".join(scores(results))
    assert "points" not in said(results)


def test_a_whole_page_counts_every_run_and_says_nothing_of_parts() -> None:
    results = results_of(toy_trials())
    assert heading(results) == "# Toy: does heel strike help?"
    assert runs_table(results) in scores(results)
