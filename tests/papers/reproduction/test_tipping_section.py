"""The section on what the grounds hold: its numbers are those of the law of tipping."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest

from gaitlab.experiment import load_experiment
from gaitlab.experiment.plan import plan
from gaitlab.log.log import GRAVITY
from gaitlab.papers.reproduction.section import Context
from gaitlab.papers.reproduction.sections.tipping import ankle, tipping_section
from gaitlab.report.results import Results
from gaitlab.servos.law import stiffness
from gaitlab.store import Store
from gaitlab.surfaces.tipping import tipping_ratio
from tests.papers.reproduction.printed import section
from tests.papers.reproduction.test_falls import HIGH, LOW, recorded
from tests.report.builder import results_of, trial
from tests.synthetic import sine, walk

HEIGHT = 0.25  # m, of the CoM


@pytest.fixture
def given(tmp_path: Path) -> Context:
    store, rows = Store(tmp_path / "data"), []
    for surface in (HIGH, LOW):
        row = trial(0.04, surface, "none", 0, up=True)
        rows.append(row)
        store.commit(recorded(str(row["trial_id"])), walk(roll=sine(0.02), com_z=HEIGHT))
    planned = {
        str(p.values["surface"]): p.trial for p in plan(load_experiment("eros_frozen")).trials()
    }
    ground = {str(row["trial_id"]): str(row["surface"]) for row in rows}
    results = replace(
        results_of(rows, compare=False), trial=lambda trial_id: planned[ground[trial_id]]
    )
    return Context(results={"toy": results}, experiments={}, store=store, folder=tmp_path)


def cells(text: str, label: str) -> list[str]:
    line = next(line for line in text.splitlines() if line.startswith(f"| {label} "))
    return [cell.strip() for cell in line.strip("|").split("|")][1:]


def results_in(context: Context) -> Results:
    return context.results["toy"]


def test_every_ratio_is_that_of_the_law(given: Context) -> None:
    text = tipping_section(section("tipping", "toy"), given)
    results = results_in(given)
    for ground, label in ((HIGH, "grass 50 mm"), (LOW, "carpet 4 mm")):
        name = str(results.trials.loc[results.trials["surface"] == ground, "trial_id"].iloc[0])
        walked, log = results.trial(name), given.store.log(name)
        height = HEIGHT - float(log.per_foot("z")[0].mean())
        expected = [
            tipping_ratio(
                walked.surface, walked.robot.sole, weight=log.header.weight, com_height=height,
                support="flat", axis=axis, servo=stiffness(ankle(walked, axis)),
            )
            for axis in ("x", "y")
        ]  # fmt: skip
        shown = [float(cell.split()[0]) for cell in cells(text, label)[:2]]
        assert shown == pytest.approx(expected, abs=0.006)


def test_the_plate_tilts_past_the_threshold_where_the_ground_holds_too_little(
    given: Context,
) -> None:
    """A lever of 300 mm with 100 g: drop = l m g l / (W h_c) where the ratio is one."""
    text = tipping_section(section("tipping", "toy", scales=(0.1, 0.4, 2.0, 6.0)), given)
    (edge,) = re.findall(r"more than ([\d.]+) mm under 100 g", text)
    for line in text.splitlines():
        if re.match(r"\| [\d.]+ ", line):
            row = [cell.strip() for cell in line.strip("|").split("|")]
            for ratio, tilt in ((row[1], row[5]), (row[2], row[7])):
                if tilt != "tips over" and abs(float(ratio) - 1.0) > 0.25:
                    assert (float(tilt.split(",")[0]) > float(edge)) == (float(ratio) < 1.0)
    name = str(results_in(given).trials["trial_id"].iloc[0])
    log = given.store.log(name)
    height = HEIGHT - float(log.per_foot("z")[0].mean())
    expected = 1000.0 * 0.1 * GRAVITY * 0.3**2 / (log.header.weight * height)
    assert float(edge) == pytest.approx(expected, abs=0.06)


def test_the_ankle_is_the_servo_next_to_the_foot() -> None:
    first = next(iter(plan(load_experiment("eros_frozen")).trials())).trial
    names = [joint.name for joint in first.robot.tree.joints]
    for axis, name in (("x", "left_ankle_pitch"), ("y", "left_ankle_roll")):
        assert ankle(first, axis) is first.servos[names.index(name)]
