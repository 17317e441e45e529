"""Sections on results made by hand: every number on the page is one that can be counted."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest

from gaitlab.errors import UsageError, WrongValue
from gaitlab.experiment import load_experiment
from gaitlab.experiment.plan import plan
from gaitlab.papers.reproduction import Reproduction, load_reproduction
from gaitlab.papers.reproduction.answers import answers
from gaitlab.papers.reproduction.headline import (
    Scored,
    efficiency_table,
    engines_agree,
    headline,
    score_table,
    scored,
)
from gaitlab.papers.reproduction.page import first_page, second_page
from gaitlab.papers.reproduction.sections.agreement import agreement_section
from gaitlab.papers.reproduction.sections.pitch import pitch_section, published_settings
from gaitlab.papers.reproduction.sections.tables import tables_section
from gaitlab.papers.reproduction.sections.variants import variants_section
from gaitlab.papers.reproduction.together import (
    called,
    require_labels,
    shown_variants,
    together,
)
from gaitlab.report.gather import gather
from gaitlab.report.results import Results
from gaitlab.report.variants import Variant
from gaitlab.store import Store
from tests import pretended
from tests.papers.reproduction.printed import (
    as_printed,
    context,
    printed_results,
    printed_trials,
    section,
)
from tests.report.builder import results_of, toy_trials, trial

CALIBRATED = {
    "eros_table7": {"direction": "forward"},
    "eros_table8": {"direction": "forward", "surfaces": ("carpet_4mm", "grass_30mm")},
}
BOTH = "heel strike + landing deceleration"


def cells(text: str, start: str) -> list[str]:
    """Cells of the first row of any table that starts so."""
    row = next(line for line in text.splitlines() if line.startswith(f"| {start} "))
    return [cell.strip() for cell in row.strip("|").split("|")]


def one_cell_off(table, place, stable, seed) -> bool:
    """Table 8 but for one forward cell, that of 16 cm on 50 mm grass."""
    off = table == "eros_table8" and place == (16, "grass_50mm")
    return not stable if off else stable


def columns_of(outcome=as_printed, calibrated=CALIBRATED, **given):
    return scored(answers({"a": printed_results(outcome, **given)}, ["a"]), calibrated)


def test_predicted_cells_come_first_and_beside_what_guessing_gives() -> None:
    text = score_table(columns_of(one_cell_off, seeds=40))
    rows = [[c.strip() for c in line.strip("|").split("|")] for line in text.splitlines()[2:]]
    counted = {row[0]: (row[1].partition(",")[0], *row[2:]) for row in rows}
    assert counted == {
        "**predicted, all**": ("37/38", "29/38", "29/38"),
        "predicted: Table 7, backward": ("12/12", "9/12", "9/12"),
        "predicted: Table 8, forward": ("13/14", "11/14", "11/14"),
        "predicted: Table 8, backward": ("12/12", "9/12", "9/12"),
        "chosen on: Table 7, forward": ("28/28", "11/28", "22/28"),
        "chosen on: Table 8, forward": ("14/14", "12/14", "12/14"),
    }
    assert list(counted) == [row[0] for row in rows]


def test_the_headline_claims_a_gain_only_where_it_is_told_from_none() -> None:
    _, gain, *_ = headline(columns_of(one_cell_off, seeds=40))
    assert "**+28 points** [28–28]" in gain
    assert "excludes zero" in gain
    assert "+48 as stated, +30 as its tables count" in gain
    _, none, *_ = headline(columns_of(lambda table, place, stable, seed: seed % 2))
    assert "holds zero" in none


def test_the_headline_says_over_how_many_cells_if_not_all_are_there() -> None:
    whole = printed_results()
    part = replace(whole, trials=whole.trials[whole.trials["surface"] == "carpet_4mm"])
    _, gain, *_ = headline(scored(answers({"a": part}, ["a"]), {}))
    assert "over 20 of the 80 printed cells" in gain


@pytest.fixture
def two_engines() -> list[Scored]:
    """A reproduction in MuJoCo as printed but for one cell, and in Bullet as printed."""
    results = {"fast": printed_results(one_cell_off, seeds=6), "slow": printed_results(seeds=3)}
    engines = {"fast": "mujoco", "slow": "bullet"}
    members = {
        name: load_experiment("eros_quick", [f"engine.name={engine}"])
        for name, engine in engines.items()
    }
    return scored(answers(results, list(results), members), CALIBRATED)


def test_each_engine_has_a_column_with_its_own_seeds(two_engines: list[Scored]) -> None:
    assert [one.side.label for one in two_engines] == ["mujoco", "bullet"]
    row = cells(score_table(two_engines), "predicted: Table 8, forward")
    assert [cell.partition(",")[0] for cell in row[1:3]] == ["13/14", "14/14"]
    assert "mujoco, 6 seeds a cell" in score_table(two_engines)
    assert "bullet, 3 seeds a cell" in score_table(two_engines)
    rows = [line for line in efficiency_table(two_engines).splitlines() if "**mujoco" in line
            or "**bullet" in line]  # fmt: skip
    assert ["+28 points" in rows[0], "+30 points" in rows[1]] == [True, True]


def test_engines_agree_over_the_seeds_that_both_have_walked(two_engines: list[Scored]) -> None:
    found = engines_agree(two_engines)
    assert found is not None
    assert (len(found.cells), len(found.differing), found.pairs.total()) == (80, 1, 240)
    assert engines_agree(two_engines[:1]) is None
    assert engines_agree([two_engines[0], two_engines[0]]) is None


def out_of_reach(trials: list[dict[str, object]], row: float) -> list[dict[str, object]]:
    """The same with one row that no leg reaches."""
    none = {"state": "INFEASIBLE", "stable": None, "stable_strict": None, "fell": None}
    return [{**t, **none} if t["gait.step_length"] == row else t for t in trials]


def test_cells_out_of_reach_are_counted_as_unstable(tmp_path: Path) -> None:
    whole = {"a": results_of(out_of_reach(printed_trials(), 0.12))}
    text = tables_section(section("tables", "a"), context(whole, tmp_path))
    assert "S = U" not in text
    assert cells(text, "forward 24")[5] == "U = U 0/4 out of reach"
    text = agreement_section(section("agreement", "a"), context(whole, tmp_path))
    assert [cell[:4] for cell in cells(text, "**bullet, all rows**")[1:3]] == ["50 %", "78 %"]


def test_variants_say_what_was_out_of_their_reach(tmp_path: Path) -> None:
    whole = {"a": results_of(out_of_reach(printed_trials(), 0.12))}
    text = variants_section(section("variants", "a"), context(whole, tmp_path))
    assert "*plain* 4 of 40 cells (efficiency without them 56 %" in text
    at_hand = variants_section(
        section("variants", "a"), context({"a": printed_results()}, tmp_path)
    )
    assert "out of the legs' reach" not in at_hand


def test_variants_on_fewer_grounds_are_summed_over_those_that_all_have(tmp_path: Path) -> None:
    soft = [row for row in printed_trials() if row["surface"] in ("grass_50mm", "grass_30mm")]
    whole = {"a": printed_results(), "b": results_of(soft)}
    text = variants_section(section("variants", "a", "b"), context(whole, tmp_path))
    assert "are over the grounds of all: grass 50 mm, grass 30 mm." in text
    for label in ("a: plain", "b: plain"):
        row = cells(text, label)
        assert row[1].startswith("24/80 ")
        assert row[2].startswith("30 %")
    agreed = cells(text, "a: plain")[5]
    assert agreed == "40/40, 100 % [91–100] (Table 7); the same cells 20/20"
    alone = variants_section(section("variants", "a"), context({"a": whole["a"]}, tmp_path))
    assert "grounds of all" not in alone


def test_variants_without_a_common_ground_keep_their_own_sums(tmp_path: Path) -> None:
    halves = [
        [row for row in printed_trials() if ("carpet" in str(row["surface"])) == hard]
        for hard in (True, False)
    ]
    whole = {name: results_of(rows) for name, rows in zip("ab", halves, strict=True)}
    text = variants_section(section("variants", "a", "b"), context(whole, tmp_path))
    assert "No ground is shared by all" in text
    assert cells(text, "a: plain")[1].startswith("36/40 ")


def test_the_only_variant_of_a_member_is_called_by_the_member(tmp_path: Path) -> None:
    heels = [row for row in toy_trials() if row["gait.heel_strike"] == "add"]
    only = replace(results_of(heels), variants=(Variant(label="plain"),))
    only = replace(only, trials=only.trials.assign(variant="plain"))
    whole = {"toy": results_of(toy_trials()), "heels": only}
    labels = [one.label for one in shown_variants(whole, ["toy", "heels"], {})]
    assert labels == ["plain", BOTH, "heels"]


def test_a_cell_that_differs_is_marked_without_colour(tmp_path: Path) -> None:
    given = section("tables", "a", calibrated=CALIBRATED)
    text = tables_section(given, context({"a": printed_results(one_cell_off)}, tmp_path))
    _, after = (part for part in text.split("**Table ")[1:3])
    assert cells(after, "forward 16")[2:] == [
        "**S ≠ U 0/4**",
        "S = S 4/4 †",
        "S = S 4/4",
        "S = S 4/4 †",
    ]
    assert text.count("≠") == 2  # the cell and the legend
    assert cells(after, "backward 24")[2:] == ["U = U 0/4"] * 3 + ["S = S 4/4"]


def test_the_papers_efficiencies_stand_beside_ours(tmp_path: Path) -> None:
    given = context({"a": printed_results()}, tmp_path)
    text = agreement_section(section("agreement", "a"), given)
    assert cells(text, "paper, stated in the text")[1:] == ["32 %", "80 %", "+48"]
    assert cells(text, "**bullet, all rows**")[1].startswith("50 %")
    assert cells(text, "**bullet, forward rows**")[2].startswith("82 %")
    assert (
        "Table 7: carpet 4 mm > grass 10 mm > grass 50 mm = grass 30 mm; the paper: carpet" in text
    )


def test_tables_without_an_answer_to_a_printed_table_say_so(tmp_path: Path) -> None:
    alone = {"gait.landing_deceleration": "none"}
    trials = [{**row, **alone} for row in toy_trials() if row["gait.heel_strike"] == "add"]
    results = results_of(trials, compare=False)
    assert "compare:" in tables_section(section("tables", "a"), context({"a": results}, tmp_path))


@pytest.fixture
def toys() -> dict[str, Results]:
    """Two members; in the second everything stands on every ground."""
    first = results_of(toy_trials())
    stands = [{**row, "experiment": "other", "stable": True, "fell": False} for row in toy_trials()]
    return {"toy": first, "other": results_of(stands)}


def test_variants_are_set_against_the_base_of_their_own_member(toys, tmp_path: Path) -> None:
    given = section("variants", "toy", "other", base="plain", labels={"other": "elsewhere"})
    text = variants_section(given, context(toys, tmp_path))
    assert cells(text, f"toy: {BOTH}")[4] == "toy: plain"
    assert cells(text, f"elsewhere: {BOTH}")[4] == "elsewhere: plain"
    assert cells(text, "elsewhere: plain")[4] == "toy: plain"
    assert cells(text, "toy: plain")[3:5] == ["—", "—"]


def test_counts_and_differences_of_variants_can_be_counted(toys, tmp_path: Path) -> None:
    toys = {**toys, "toy": results_of(toy_trials(seeds=8))}  # fewer than six tell nothing
    text = variants_section(section("variants", "toy"), context(toys, tmp_path))
    trials = toys["toy"].trials
    counts = trials.groupby("variant")["stable"].agg(["sum", "size"])
    for label in ("plain", BOTH):
        up, n = counts.loc[label]
        assert cells(text, label)[1].startswith(f"{up}/{n} [")
    gain = 100 * (counts.loc[BOTH, "sum"] - counts.loc["plain", "sum"]) / 128
    said = cells(text, BOTH)[3]
    assert said.startswith(f"{gain:+.0f} points [")
    assert said.endswith("**better**, n = 128")


def test_another_base_can_be_named_for_one_variant(toys, tmp_path: Path) -> None:
    names = {"other/plain": f"toy/{BOTH}"}
    given = section("variants", "toy", "other", base="plain", against=names)
    text = variants_section(given, context(toys, tmp_path))
    assert cells(text, "other: plain")[4] == f"toy: {BOTH}"


def test_a_variant_can_be_left_out(toys, tmp_path: Path) -> None:
    given = section("variants", "toy", leave_out=(BOTH,))
    assert BOTH not in variants_section(given, context(toys, tmp_path))


@pytest.mark.parametrize("name", ["labels", "base", "against", "leave_out"])
def test_a_name_that_no_variant_has_is_refused_with_those_there_are(toys, tmp_path, name) -> None:
    value = {"base": "plane", "leave_out": ("plane",)}.get(name, {"plane": "plain"})
    given = section("variants", "toy", **{name: value})
    with pytest.raises(WrongValue, match=r"'plane'.*plain"):
        variants_section(given, context(toys, tmp_path))


def test_a_name_of_a_member_that_was_not_run_is_no_mistake(toys, tmp_path: Path) -> None:
    whole = context(toys, tmp_path)
    part = replace(whole, results={"toy": toys["toy"]})
    given = section("variants", "toy", labels={"other": "x"}, against={"other/plain": "plain"})
    assert "plain" in variants_section(given, part)


def test_variants_share_their_rows_or_keep_their_own() -> None:
    results = results_of(toy_trials())
    part = replace(results, trials=results.trials[results.trials["gait.step_length"] == 0.04])
    shown = shown_variants({"a": results, "b": part}, ["a", "b"], {})
    assert together(shown).row_values == results.row_values
    assert len({one.label for one in shown}) == 4


def test_readings_of_a_distance_meet_at_the_printed_one() -> None:
    travel = results_of(toy_trials())  # 0, 4, 8 cm of step length are 0, 8, 16 printed
    rows = [{**row, "gait.step_length": row["gait.step_length"] / 5} for row in toy_trials()]
    millimetres = replace(results_of(rows), reading="mm")
    whole = together(shown_variants({"a": travel, "b": millimetres}, ["a", "b"], {}))
    assert whole.row_values == (0.0, 8.0, 16.0, -8.0)
    assert whole.trials.groupby("printed distance").size().to_list() == [64] * 4


def test_members_with_other_rows_share_no_section(toys, tmp_path: Path) -> None:
    toys["other"] = replace(toys["other"], rows="surface", columns="gait.step_length")
    with pytest.raises(UsageError, match=r"toy has rows 'gait\.step_length' and other"):
        variants_section(section("variants", "toy", "other"), context(toys, tmp_path))


def test_a_figure_goes_beside_the_page(toys, tmp_path: Path) -> None:
    given = section("variants", "toy", figure="apart")
    text = variants_section(given, context(toys, tmp_path))
    assert "(apart.png)" in text
    assert (tmp_path / "apart.png").stat().st_size > 1000


def test_the_papers_settings_are_its_three_experiments() -> None:
    found = published_settings()
    assert [setting[False].amplitude for setting in found.values()] == [19, 22, 21]
    assert [setting[True].amplitude for setting in found.values()] == [6, 8, 7]
    assert [setting[False].x for setting in found.values()] == [8, 16, 24]
    assert all(setting[False].fell and not setting[True].fell for setting in found.values())


def walks(step: float, sway: float, degrees: tuple[float, ...]) -> list[dict[str, object]]:
    return [
        trial(step, "grass_50mm", heel, seed, up=heel == "add")
        | {
            "gait.lateral_sway": sway,
            "pitch_amplitude": value * 3.141592653589793 / 180,
            "pitch_settled": seed > 0,
            "distance_before_fall": 0.1 * value,
        }
        for heel in ("none", "add")
        for seed, value in enumerate(degrees)
    ]


def test_walks_meet_the_setting_with_their_step_and_sway_in_every_reading(tmp_path: Path) -> None:
    trials = walks(0.04, 0.045, (1.0, 2.0, 3.0)) + walks(0.016, 0.035, (4.0, 4.0, 4.0))
    trials += walks(0.08, 0.045, (9.0,))  # in cm this is the step of experiment 1: X = 8, Y = 45
    text = pitch_section(section("pitch", "a"), context({"a": results_of(trials)}, tmp_path))
    rows = [[c.strip() for c in line.strip("|").split("|")] for line in text.splitlines()
            if line.startswith("| Fig ")]  # fmt: skip
    assert [row[:3] for row in rows if row[2] == "plain"] == [
        ["Fig 24, X = 8, Y = 45", "foot travel in cm", "plain"],
        ["Fig 24, X = 8, Y = 45", "step length in cm", "plain"],
        ["Fig 26, X = 16, Y = 35", "step length in mm", "plain"],
    ]
    assert rows[0][3:5] == ["±19°", "2.0° [1.5, 2.5], n = 3, 1 short"]
    assert rows[0][5:7] == ["falls", "3/3, 100 % [44–100]"]
    assert rows[0][8].startswith("0.20 m [0.15, 0.25], n = 3, of ")
    assert rows[1][3:7:2] == ["±6°", "no fall"]
    assert rows[1][6].startswith("0/3, 0 %")


def test_both_engines_of_one_setting_stand_below_each_other(tmp_path: Path) -> None:
    engines = {"fast": "mujoco", "slow": "bullet"}
    trials = walks(0.04, 0.045, (1.0, 2.0)) + walks(0.016, 0.035, (4.0, 4.0))
    members = {
        name: load_experiment("eros_quick", [f"engine.name={engine}"])
        for name, engine in engines.items()
    }
    both = context({name: results_of(trials) for name in engines}, tmp_path)
    text = pitch_section(section("pitch", *engines), replace(both, experiments=members))
    rows = [[c.strip() for c in line.strip("|").split("|")] for line in text.splitlines()
            if line.startswith("| Fig ")]  # fmt: skip
    assert [row[3] for row in rows] == ["mujoco", "bullet"] * 4
    assert all(rows[i][:3] == rows[i + 1][:3] for i in range(0, 8, 2))
    assert len({tuple(row[:3]) for row in rows}) == 4


def test_pitch_of_walks_that_answer_to_no_setting_is_not_shown(tmp_path: Path) -> None:
    results = results_of(walks(0.05, 0.045, (1.0,)))
    text = pitch_section(section("pitch", "a"), context({"a": results}, tmp_path))
    assert not re.search("Fig", text)


def test_a_section_behind_stands_on_the_second_page_with_where_all_comes_from(
    tmp_path: Path,
) -> None:
    given = context({"a": printed_results()}, tmp_path)
    member = given.experiments["a"]
    whole = Reproduction(
        name="whole",
        title="A paper anew",
        description="",
        path=member.path,
        members=(member,),
        sections=(
            replace(section("tables", "a"), title="In front"),
            replace(section("variants", "a"), title="Behind", details=True),
        ),
    )
    first, second = first_page(whole, given), second_page(whole, given)
    assert "## In front" in first
    assert "## Behind" in second
    assert "## Behind" not in first
    assert "[second page](details.md)" in first
    assert ("## Provenance" in first, "## Provenance" in second) == (False, True)
    assert second.count("Runs that stayed up, of all") == 1
    alone = replace(whole, sections=whole.sections[:1])
    assert "## Provenance" in first_page(alone, given)
    assert "details.md" not in first_page(alone, given)


def test_the_shipped_page_has_its_answers_in_front() -> None:
    whole = load_reproduction("eros_reproduction")
    front = [each.title for each in whole.sections if not each.details]
    assert front[0] == "Tables 7 and 8"
    assert len(front) <= 4


def test_every_name_that_a_shipped_section_calls_a_variant_by_is_one(tmp_path: Path) -> None:
    """Whatever the members vary: a name that is none would end the report after all the walking."""
    whole, store = load_reproduction("eros_reproduction", quick=True), Store(tmp_path / "data")
    comparing = [each for each in whole.sections if each.kind == "variants"]
    results = {}
    for member in whole.members:
        if any(member.name in each.experiments for each in comparing):
            planned = next(iter(plan(member).trials())).trial
            pretended.pretend_well(planned.id, planned.to_dict(), store.path)
            results[member.name] = gather([member], store)
    assert len(comparing) >= 6
    for each in comparing:
        shown = shown_variants(results, each.experiments, each.options["labels"])
        require_labels(shown, each.options["labels"])
        against = each.options["against"]
        for name in (each.options["base"], *each.options["leave_out"], *against, *against.values()):
            assert called(shown, name)
