"""The section on a designed sweep: what it counts, leaves out and claims."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from gaitlab.errors import UsageError
from gaitlab.experiment import Experiment, load_experiment
from gaitlab.experiment.plan import plan
from gaitlab.papers.reproduction import sweep_page
from gaitlab.papers.reproduction.section import Context, Section
from gaitlab.papers.reproduction.sections.sensitivity import sensitivity_section
from gaitlab.papers.reproduction.swept import sweep_of
from gaitlab.report.results import Results
from gaitlab.store import Store
from tests.written import read

SWEEP = """\
robot: eros
gait: {type: ./my_gait.py}
surfaces: [grass_50mm, carpet_4mm]
design:
  points: 32
  seed: 3
  box:
    robot.mass: {low: 3.0, high: 4.0}
    surface.friction_scale: {low: 0.5, high: 2.0, log: true}
    robot.sole.length: {low: 0.10, high: 0.15, with: {robot.sole.heel: [0.044, 0.066]}}
zip:
  - {gait.heel_strike: [none, literal, add], gait.smooth: [false, false, true]}
grid:
  gait.step_length: [0.02, 0.04, 0.06, 0.08]
seeds: 2
"""
FRICTION = "surface.friction_scale"


def up(values: Mapping[str, object]) -> bool:
    """Heavy robots walk less far; heel strike helps as far as friction is high, on grass alone."""
    helped = values["gait.heel_strike"] == "add" and values["surface"] == "grass_50mm"
    gained = 0.04 * np.log2(values[FRICTION]) if helped else 0.0
    return bool(values["gait.step_length"] < 0.05 + 0.03 * (3.5 - values["robot.mass"]) + gained)


def results_of(experiment: Experiment, rule: Callable[[Mapping[str, object]], bool]) -> Results:
    rows = [
        {
            "trial_id": p.trial.id, "experiment": experiment.name, "seed": p.trial.seed,
            "state": "DONE", "stable": rule(p.values), "variant": "", **p.values,
        }
        for p in plan(experiment).trials()
    ]  # fmt: skip
    return Results(
        title="", question="", rows="gait.step_length", columns="surface", variants=(),
        reading="foot_travel", trials=pd.DataFrame(rows), log=lambda _: None, trial=lambda _: None,
    )  # fmt: skip


@pytest.fixture
def experiment(tmp_path: Path) -> Experiment:
    return read(tmp_path, SWEEP)


def page(experiment: Experiment, results: Results | None, folder: Path, **labels: str) -> str:
    name = experiment.name
    context = Context(
        results={} if results is None else {name: results},
        experiments={name: experiment},
        store=Store(folder / "store"),
        folder=folder,
    )
    section = Section(
        kind="sensitivity", title="", text="", experiments=(name,), options={"labels": labels}
    )
    return sensitivity_section(section, context)


def with_state(results: Results, chosen: pd.Series, state: str) -> Results:
    trials = results.trials.astype({"stable": object})
    trials.loc[chosen, ["state", "stable"]] = [state, None]
    return replace(results, trials=trials)


def test_shares_are_counted_at_every_point_of_the_first_and_last_switch(experiment) -> None:
    results = results_of(experiment, up)
    sweep = sweep_of(experiment, results)
    assert sweep.labels == ("plain", "heel strike + smooth")
    assert (len(sweep.places), sweep.walks, sweep.left_out) == (32, 4 * 2 * 2, 0)
    rows = experiment.axes[0].rows
    for index, row in enumerate(rows):
        values = dict(zip(experiment.axes[0].paths, row, strict=True))
        for heel, found in zip(("none", "add"), sweep.by_ground["grass_50mm"], strict=True):
            steps = (0.02, 0.04, 0.06, 0.08)
            cell = {**values, "gait.heel_strike": heel, "surface": "grass_50mm"}
            expected = np.mean([up({**cell, "gait.step_length": s}) for s in steps])
            assert found[index] == expected
    assert not np.any(sweep.by_ground["carpet_4mm"].improvement)


def test_a_share_is_that_of_all_seeds(experiment) -> None:
    results = results_of(experiment, up)
    lucky = results.trials["seed"] == 1
    trials = results.trials.assign(stable=results.trials["stable"] & lucky)
    both, one = (sweep_of(experiment, replace(results, trials=t)) for t in (results.trials, trials))
    for ground, sides in both.by_ground.items():
        np.testing.assert_allclose(one.by_ground[ground], 0.5 * np.array(sides))


def test_a_step_alone_and_a_number_of_some_grounds_are_swept_too(tmp_path: Path) -> None:
    text = SWEEP.replace("[0.02, 0.04, 0.06, 0.08]", "[0.04]").replace("seeds: 2", "seeds: 3")
    box = "  box:\n"
    text = text.replace(box, f"{box}    surface.bonding: {{low: 1.0, high: 16.0, log: true}}\n")
    experiment = read(tmp_path, text)
    results = results_of(experiment, up)
    sweep = sweep_of(experiment, results)
    assert (sweep.places.shape, sweep.walks, sweep.left_out) == ((32, 4), 2 * 3, 0)
    text = page(experiment, results, tmp_path)
    assert "bonding, 1 to 16" in text
    assert "0 to 2" in text


def test_places_are_those_that_the_points_came_from(experiment) -> None:
    places = sweep_of(experiment, results_of(experiment, up)).places
    assert places.shape == (32, 3)
    cells = np.sort(np.floor(places * 32.0), axis=0)
    np.testing.assert_array_equal(cells, np.tile(np.arange(32.0)[:, None], (1, 3)))


def test_the_order_of_the_trials_does_not_matter(experiment) -> None:
    results = results_of(experiment, up)
    shuffled = replace(results, trials=results.trials.sample(frac=1.0, random_state=1))
    first, other = (sweep_of(experiment, each) for each in (results, shuffled))
    np.testing.assert_array_equal(first.places, other.places)
    np.testing.assert_array_equal(first.shares, other.shares)


def test_a_point_with_a_missing_walk_is_left_out_and_said(experiment, tmp_path) -> None:
    results = results_of(experiment, up)
    of_a_point = results.trials["robot.mass"] == experiment.axes[0].rows[5][0]
    gone = of_a_point & (results.trials["gait.heel_strike"] == "add")
    torn = with_state(results, gone & (results.trials["seed"] == 1), "MISSING")
    whole, less = sweep_of(experiment, results), sweep_of(experiment, torn)
    assert less.left_out == 1
    np.testing.assert_array_equal(less.places, np.delete(whole.places, 5, axis=0))
    np.testing.assert_array_equal(less.shares, np.delete(np.array(whole.shares), 5, axis=1))
    assert "1 point with missing or failed walks left out" in page(experiment, torn, tmp_path)


def test_a_missing_walk_of_a_variant_between_does_not_matter(experiment) -> None:
    results = results_of(experiment, up)
    between = results.trials["gait.heel_strike"] == "literal"
    assert sweep_of(experiment, with_state(results, between, "FAILED")).left_out == 0


def test_a_step_out_of_reach_counts_as_a_fall(experiment) -> None:
    results = results_of(experiment, lambda _: True)
    far = results.trials["gait.step_length"] == 0.08
    shares = sweep_of(experiment, with_state(results, far, "INFEASIBLE")).shares
    np.testing.assert_array_equal(shares, np.full((2, 32), 0.75))


def test_the_page_names_what_matters_and_nothing_else(experiment, tmp_path) -> None:
    text = page(experiment, results_of(experiment, up), tmp_path, **{FRICTION: "grip"})
    assert re.search(r"The improvement \(Q² = 0\.\d+\) hangs on grip \(.*, \+", text)
    assert re.search(
        r"The stable share of \*plain\* \(Q² = [01]\.\d+\) hangs on mass \(.*, -", text
    )
    assert "sole length (" not in text
    assert (tmp_path / "sensitivity_walk.png").stat().st_size > 1000


def test_a_box_without_what_is_otherwise_set_says_so(tmp_path: Path) -> None:
    apart = read(tmp_path, SWEEP.replace("{low: 0.5, high: 2.0, log: true}", "{low: 1.5, high: 2}"))
    text = page(apart, results_of(apart, up), tmp_path)
    assert (
        "**What is otherwise set lies outside of this box: friction scale, 1.5 to 2: 1.**" in text
    )


def test_seeds_that_all_points_share_are_named(experiment, tmp_path) -> None:
    text = page(experiment, results_of(experiment, up), tmp_path)
    assert "over step length 0.02, 0.04, 0.06, 0.08, with the same seeds, 0 to 1 at every" in text
    assert "outside of this box" not in text


def test_signs_add_up_to_all_points(experiment, tmp_path) -> None:
    text = page(experiment, results_of(experiment, up), tmp_path)
    gains = sweep_of(experiment, results_of(experiment, up)).by_ground["grass_50mm"].improvement
    (line,) = (row for row in text.splitlines() if row.startswith("| grass 50 mm"))
    for count in (np.sum(gains > 0), np.sum(gains == 0), np.sum(gains < 0)):
        assert f"{count}/32" in line


VERDICTS = {
    "helps": lambda v: v["gait.heel_strike"] == "add",
    "harms": lambda v: v["gait.heel_strike"] == "none",
    "makes no difference": lambda v: v["gait.step_length"] < 0.05,
}


@pytest.mark.parametrize("word", VERDICTS)
def test_a_sign_that_holds_everywhere_is_said(experiment, tmp_path, word: str) -> None:
    text = page(experiment, results_of(experiment, VERDICTS[word]), tmp_path)
    assert f"*heel strike + smooth* {word} in more than half of the box" in text
    assert "nan" not in text


def test_a_sign_that_changes_half_way_is_not_claimed(experiment, tmp_path) -> None:
    def rule(values: Mapping[str, object]) -> bool:
        return (values["gait.heel_strike"] == "add") == (values["robot.mass"] > 3.5)

    text = page(experiment, results_of(experiment, rule), tmp_path)
    assert "cannot be told.**" in text
    assert "which cannot be told from none" in text


def test_the_same_results_give_the_same_bytes(experiment, tmp_path) -> None:
    pages = []
    for name in ("first", "second"):
        (tmp_path / name).mkdir()
        text = page(experiment, results_of(experiment, up), tmp_path / name)
        pages.append((text, (tmp_path / name / "sensitivity_walk.png").read_bytes()))
    assert pages[0] == pages[1]


def test_few_points_say_how_many_would_tell(tmp_path) -> None:
    few = read(tmp_path, SWEEP, "design.points=6")
    text = page(few, results_of(few, up), tmp_path)
    assert "6 points cannot tell 3 quantities apart; 8 can" in text


def test_without_a_model_no_index_and_no_figure_is_shown(experiment, tmp_path) -> None:
    generator = np.random.default_rng(5)
    text = page(experiment, results_of(experiment, lambda _: generator.random() < 0.5), tmp_path)
    assert text.count("No model predicts") == 3
    assert "first-order" not in text
    assert not list(tmp_path.glob("*.png"))


def test_noise_and_other_seeds_come_from_the_seeds(experiment) -> None:
    results = results_of(experiment, up)
    lucky = results.trials["stable"] & (results.trials["seed"] == 1)
    sweep = sweep_of(experiment, replace(results, trials=results.trials.assign(stable=lucky)))
    assert sweep.by_seed.without.shape == (32, 2)
    assert not sweep.by_seed.without[:, 0].any()
    for shares, by_seed in zip(sweep.shares, sweep.by_seed, strict=True):
        np.testing.assert_allclose(by_seed.mean(axis=1), shares)


def test_nothing_simulated_is_said(experiment, tmp_path) -> None:
    assert "No trial of walk has been simulated yet" in page(experiment, None, tmp_path)
    results = results_of(experiment, up)
    empty = with_state(results, results.trials["seed"] == 1, "MISSING")
    assert "No point of walk has been simulated completely" in page(experiment, empty, tmp_path)


def test_an_experiment_without_a_design_or_a_switch_is_refused(tmp_path) -> None:
    plain = read(tmp_path, SWEEP.partition("design:")[0] + "grid: {gait.step_length: [0.02]}\n")
    with pytest.raises(UsageError, match="has no `design:`"):
        sweep_of(plain, results_of(plain, lambda _: True))
    head, _, rest = SWEEP.partition("zip:")
    unswitched = read(tmp_path, head + rest[rest.index("grid:") :])
    with pytest.raises(UsageError, match="varies no switch"):
        sweep_of(unswitched, results_of(unswitched, lambda _: True))


def test_a_sweep_with_a_switch_has_a_page_of_its_own(experiment, tmp_path) -> None:
    made = sweep_page([experiment], ["seeds=2"])
    assert made is not None
    assert [each.kind for each in made.sections] == ["sensitivity"]
    assert made.options == ("--set", "seeds=2")
    assert sweep_page([experiment, experiment]) is None
    head, _, rest = SWEEP.partition("zip:")
    assert sweep_page([read(tmp_path, head + rest[rest.index("grid:") :])]) is None
    assert sweep_page([load_experiment("eros_quick")]) is None


PRINTED_ROW = SWEEP.replace("[0.02, 0.04, 0.06, 0.08]", "[0.06]").replace(
    "[grass_50mm, carpet_4mm]", "[grass_50mm, grass_30mm, carpet_4mm]"
)
COMPARED = "report: {compare: eros_table7, distance_reading: foot_travel}\n"


@pytest.mark.parametrize(
    ("rule", "expected"),
    [
        (lambda v: v["gait.heel_strike"] == "add" or v["surface"] == "carpet_4mm", (32, 2, 67)),
        (lambda v: v["gait.heel_strike"] == "add" or v["surface"] != "grass_50mm", (0, 1, 33)),
        (lambda v: True, (0, 0, 0)),
    ],
)
def test_the_box_is_held_against_the_printed_row(tmp_path: Path, rule, expected) -> None:
    """Row 12 cm turns from unstable to stable on both grasses: as printed, on one, on none."""
    experiment = read(tmp_path, PRINTED_ROW + COMPARED)
    text = page(experiment, results_of(experiment, rule), tmp_path)
    (told,) = re.findall(r"\*\*(\d+) of 32 .* at most (\d) .* is \+(\d+) points", text)
    assert tuple(map(int, told)) == expected
    assert "on 1 of 3 grounds without and on 3 with, +67 points" in text


def test_no_paper_is_spoken_of_where_none_is_compared_with(tmp_path: Path) -> None:
    experiment = read(tmp_path, PRINTED_ROW)
    assert "paper" not in page(experiment, results_of(experiment, lambda _: True), tmp_path)
