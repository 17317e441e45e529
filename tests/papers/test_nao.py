"""The audit of the NAO study: its own numbers, and that it says what has not been simulated."""

from __future__ import annotations

import dataclasses
import json
import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gaitlab.experiment import load_experiment
from gaitlab.experiment.plan import plan
from gaitlab.gaits.nao import Gait
from gaitlab.papers.nao import audit, planned_zmp
from gaitlab.papers.nao_effects import (
    fifteen,
    final_gait,
    lateral_arm_error,
    paper_leg,
    printed_foot,
    printed_hip_pitch,
)
from gaitlab.papers.nao_effects import standing as standing_leg
from gaitlab.papers.nao_sweeps import (
    PERIOD,
    VERDICTS,
    NaoSweep,
    Setting,
    Walked,
    compared,
    criterion,
    doubts,
    settings,
    sweeps,
    table,
    verdict,
)
from gaitlab.papers.page import markdown
from gaitlab.robots.nao import Robot
from gaitlab.running.run_trial import run_trial
from gaitlab.store import Store

GOLDEN = json.loads((Path(__file__).parents[1] / "data" / "nao.json").read_text())
STORE = Path("data")
SHIPPED = Path(__file__).parents[2] / "experiments"


def setting(value: float, fluctuation: float, *, fell: int = 0, spread: float = 0.1) -> Setting:
    """Ten seeds whose load fluctuates about a value; the first ones fell."""
    trials: dict[int, Mapping[str, object]] = {
        seed: {
            "trial_id": f"{value}-{seed}",
            "fell": seed < fell,
            "stable_strict": seed >= fell,
            "load_index_fluctuation": fluctuation + spread * (seed % 3 - 1),
            "load_index_crossings": 1.0,
            "zmp_normalised_outside": 0.05 * (seed % 2),
            "zmp_inside_share": 0.5,
            "roll_amplitude": 0.03,
        }
        for seed in range(10)
    }
    return Setting(value=value, trials=trials)


def alone(sweep: NaoSweep, found: list[Setting]) -> Walked:
    """One sweep that one engine has walked, and nothing else."""
    others: dict[str, list[Setting]] = {each.experiment: [] for each in (*sweeps(), PERIOD)}
    engine = Walked(engine="MuJoCo", experiment=None, sweeps={**others, sweep.experiment: found})
    return compared([engine])[0]


@pytest.mark.parametrize("row", GOLDEN["planned_multibody_zmp"]["rows"])
def test_planned_zmp_equals_the_reference(row: dict[str, float]) -> None:
    found = planned_zmp(Robot(), Gait(gait_period=2.0 * row["T"]))
    expected = [row[k] for k in ("max_y_zmp", "min_x_zmp_rel_stance", "max_x_zmp_rel_stance")]
    np.testing.assert_allclose(found[:3], expected, atol=2e-4)
    assert found.com_out == pytest.approx(row["max_com_y"], abs=1e-5)


def test_a_slower_walk_keeps_its_planned_zmp_farther_in() -> None:
    out = [planned_zmp(Robot(), Gait(gait_period=period)).furthest_out for period in (1, 2, 4, 8)]
    assert out == sorted(out, reverse=True)
    slowest = planned_zmp(Robot(), Gait(gait_period=19.0))
    assert slowest.furthest_out == pytest.approx(slowest.com_out, abs=1e-3)  # a statics limit


def test_the_printed_window_sends_the_foot_under_ground_and_its_flip_sends_it_backwards() -> None:
    t = 1.0 + np.linspace(0.0, 1.0, 101)
    assert printed_foot(0.1, 0.028, t, -1.0)[:, 1].min() == pytest.approx(-0.028)
    flipped = printed_foot(0.1, 0.028, t, 1.0)
    assert flipped[:, 1].min() > -1e-12
    assert flipped[-1, 0] - flipped[0, 0] == pytest.approx(-0.1)


def test_neither_print_nor_half_a_correction_gives_the_hip_pitch() -> None:
    angles = standing_leg(0.2, 0.018)
    assert np.degrees(angles.hip_pitch) == pytest.approx(-24.49, abs=0.01)
    assert np.degrees(printed_hip_pitch(angles, "acos")) == pytest.approx(0.0, abs=1e-9)
    assert np.degrees(printed_hip_pitch(angles, "asin")) == pytest.approx(-16.5, abs=0.02)


def test_one_lateral_arm_is_wrong_by_half_of_what_the_sensors_differ() -> None:
    assert lateral_arm_error(Robot()) == pytest.approx((0.0231 - 0.0191) / 2.0, abs=1e-6)


def test_the_final_gait_is_the_gait_s_own_default_but_for_the_period() -> None:
    found, default = final_gait(), Gait()
    for name in ("step_length", "step_height", "lateral_sway", "hip_height"):
        assert getattr(found, name) == pytest.approx(getattr(default, name), abs=1e-12)
    assert len(list(fifteen(Robot()))) == 15
    assert paper_leg() == pytest.approx(0.2)


@pytest.mark.parametrize("sweep", [*sweeps(), PERIOD], ids=lambda sweep: sweep.experiment)
def test_the_shipped_experiment_walks_every_setting_of_the_paper_s_table(sweep) -> None:
    experiment = load_experiment(SHIPPED / f"{sweep.experiment}.yaml")
    assert len(experiment.seeds) == 40
    cells = [{sweep.path: cell.values[sweep.path]} for cell in plan(experiment).cells()]
    walked = {sweep.value_of(cell) for cell in cells}
    if sweep.table:
        assert walked == set(sweep.values([]))
        assert sweep.chosen in walked
    else:
        assert len(walked) == len(cells) >= 5


def test_a_choice_that_fluctuates_least_and_always_walks_is_supported() -> None:
    sweep = sweeps()[0]
    found = [setting(value, 0.5 if value == sweep.chosen else 1.0) for value in sweep.values([])]
    told = dict(zip(VERDICTS, verdict(sweep, alone(sweep, found)), strict=True))
    assert (told["choice of the paper"], told["engine"]) == ("h = 18 mm", "MuJoCo")
    assert (told["supported"], told["less than"], told["more than"]) == (
        "**yes**", "4 of 4", "0 of 4",
    )  # fmt: skip


@pytest.mark.parametrize(
    ("fluctuation", "fell"), [(1.0, 0), (1.5, 0), (0.5, 4)], ids=["alike", "more", "falls"]
)
def test_a_choice_that_is_no_better_or_falls_more_is_not_supported(
    fluctuation: float, fell: int
) -> None:
    sweep = sweeps()[1]
    found = [
        setting(value, fluctuation, fell=fell) if value == sweep.chosen else setting(value, 1.0)
        for value in sweep.values([])
    ]
    told = dict(zip(VERDICTS, verdict(sweep, alone(sweep, found)), strict=True))
    assert (told["choice of the paper"], told["supported"]) == ("F = 55 mm", "no")


def test_comparisons_of_all_choices_and_engines_are_one_family() -> None:
    """The same difference that is told alone drowns among many comparisons."""
    few = (
        dataclasses.replace(each, trials={seed: each.trials[seed] for seed in range(7)})
        for each in (setting(18.0, 0.5), setting(19.0, 1.0))
    )
    told = alone(sweeps()[0], list(few))
    assert told.gaps["nao_bending_height", 19.0].verdict == "better"
    both = compared([told] * 8)
    assert all(one.gaps["nao_bending_height", 19.0].verdict == "cannot tell" for one in both)


def test_a_share_whose_interval_holds_one_half_is_named() -> None:
    sweep = sweeps()[0]
    found = [setting(v, 1.0, fell=5 if v == 20.0 else 0) for v in sweep.values([])]
    assert [one.value for one in found if one.open] == [20.0]
    assert "h = 20 mm in MuJoCo" in doubts([alone(sweep, found)])


def test_the_criterion_is_counted_over_trials_once_each() -> None:
    same = setting(18.0, 1.0, fell=2)
    text = criterion([same, same])
    assert "of the 8 trials that stay up" in text
    assert "the 2 that fall" in text
    assert criterion([setting(18.0, 1.0)]) == ""  # nothing fell, so nothing is told apart


def test_a_table_shows_a_row_a_setting_with_its_interval() -> None:
    sweep = sweeps()[2]
    found = [setting(value, 1.0, fell=1) for value in sweep.values([])]
    shown = table(sweep, alone(sweep, found))
    assert [row[0].split()[0] for row in shown.rows] == ["80", "90", "100", "110", "120"]
    assert shown.rows[0][1:3] == ["9 of 10", "60 to 98 %"]
    assert all(len(row) == len(shown.header) for row in shown.rows)


def test_without_a_store_the_page_says_what_to_run_and_still_shows_all_that_is_computed(
    tmp_path: Path,
) -> None:
    store = tmp_path / "none"
    page = audit(store)
    text = markdown(page)
    for name in ("nao_bending_height", "nao_frontal_shift", "nao_step_length", "nao_period"):
        assert f"`gaitlab run {name} --store {store}`" in text
    assert page.pictures == []
    assert "28 mm under ground" in text
    assert re.search(r"\| 1 +\| 60 +\| 40 +\| -19 +\| 45 +\|", text)


@pytest.mark.long
def test_walks_in_a_store_become_tables_and_charts(tmp_path: Path) -> None:
    """Settings are really walked in both engines, one seed and a cycle, or 0.1 s, each."""
    store = Store(tmp_path / "store")
    for name, end in (("nao_frontal_shift", "cycles=1.0"), ("nao_confirmed", "time=0.1")):
        short = load_experiment(SHIPPED / f"{name}.yaml", [f"horizon.{end}"], seeds=1)
        experiment = replace(short, form="")  # as if the file itself said so
        planned = list(plan(experiment).trials())
        store.register(experiment, planned)
        for item in planned:
            gait = item.trial.gait
            few = gait.hip_height == 0.23009 and gait.gait_period in (1.2, 2.0)
            if name == "nao_frontal_shift" or few:
                run_trial(item.trial.id, item.trial.to_dict(), store.path)
    page = audit(store.path)
    shown = [one for one in page.tables if one.title.startswith("Table 4")]
    assert len(shown) == 2
    for one in shown:
        assert [row[0].split()[0] for row in one.rows] == ["59", "57", "55", "53", "51"]
        assert all(row[1].endswith("of 1") for row in one.rows)
    for sweep in sweeps():  # what varies one thing at a time is no setting of another sweep
        confirmed = settings(sweep, store.path, "nao_confirmed")
        assert len(confirmed) == (1 if sweep.symbol == "h" else 5)
    assert [picture.name for picture in page.pictures] == ["chart_3", "chart_4"]
    for picture in page.pictures:
        picture.draw(tmp_path, picture.name)
        assert (tmp_path / f"{picture.name}.png").stat().st_size > 10_000
