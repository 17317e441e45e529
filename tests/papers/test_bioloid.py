import json
from pathlib import Path

import numpy as np
import pytest

from gaitlab.kinematics.planar_leg import LegAngles, ankle_position
from gaitlab.papers.bioloid import TOLERANCE, audit
from gaitlab.papers.bioloid_tables import (
    LENGTHS,
    POSES,
    SIDES,
    averages,
    calculated,
    lean_of,
    level_positions,
    measured,
    positions,
    recomputed,
    stated,
)
from gaitlab.papers.page import Page, Table, markdown
from gaitlab.papers.printed import rows

GOLDEN = json.loads((Path(__file__).parents[1] / "data" / "bioloid.json").read_text())
BY_ROW = dict(
    zip(
        ("Upright", "Lift left leg", "Step left leg", "Lift right leg", "Step right leg"),
        range(5),
        strict=True,
    )
)


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Page:
    return audit(tmp_path_factory.mktemp("empty_store") / "store")


def table(page: Page, number: int) -> Table:
    (found,) = (one for one in page.tables if one.title.startswith(f"Table {number}:"))
    return found


def test_every_cell_of_tables_3_and_4_is_within_two_hundredths_but_the_two_misprints() -> None:
    wrong = {
        (side, POSES[i], "αβγθω"[j])
        for side in SIDES
        for i, j in np.argwhere(np.abs(recomputed(side) - calculated(side)) > TOLERANCE)
    }
    assert wrong == {("right", "Lift left", "ω"), ("left", "Lift right", "β")}


def bold(page: Page, number: int) -> set[tuple[str, str]]:
    """Row and column of the cells that stand out."""
    shown = table(page, number)
    return {
        (row[0], title)
        for row in shown.rows
        for title, cell in zip(shown.header, row, strict=True)
        if cell.startswith("**")
    }


def test_misprints_and_no_other_cells_stand_out(page: Page) -> None:
    assert {number: bold(page, number) for number in range(3, 11)} == {
        3: {("Lift left", "ω")},
        4: {("Lift right", "β")},
        5: {("Step right", "right Z")},
        6: {("Step left", "left X")},
        7: {("Step left", "ω")},
        8: {("Upright", "β")},
        9: {("Step right", "γ")},
        10: set(),
    }


def test_every_printed_number_of_every_table_stands_on_the_page(page: Page) -> None:
    for side, number in (("right", 3), ("left", 4)):
        shown = [[float(cell.strip("*").split()[0]) for cell in row[1:]]
                 for row in table(page, number).rows]  # fmt: skip
        np.testing.assert_array_equal(shown, calculated(side))  # type: ignore[arg-type]
    cells = sum(len(row) - 1 for number in range(3, 11) for row in table(page, number).rows)
    assert cells == 2 * 25 + 2 * 30 + 4 * 25
    assert sum(len(comparison.rows) for comparison in page.comparisons) == 5 + 16


def test_the_measured_leans_equal_the_reference() -> None:
    for name, leans in GOLDEN["measured_lean"].items():
        robot, side = name.split("_")
        found = lean_of(measured(int(robot[-1]), side))  # type: ignore[arg-type]
        np.testing.assert_allclose(found, leans, atol=1e-9)


@pytest.mark.parametrize("case", GOLDEN["levelled_fk"])
def test_level_positions_equal_the_reference(case: dict) -> None:
    robot, side = int(case["robot_leg"][5]), case["robot_leg"].split("_")[1]
    row = BY_ROW[case["position"]]
    np.testing.assert_allclose(level_positions(robot, side)[row, :2], case["fk_level"], atol=1e-6)
    legs = LegAngles(*np.radians(measured(robot, side)).T)
    torso = 100.0 * ankle_position(legs, **LENGTHS)[row, :2]
    np.testing.assert_allclose(torso, case["fk_torso"], atol=1e-6)


def test_the_offset_of_the_positions_equals_the_reference() -> None:
    off = np.concatenate([positions(r, s) - level_positions(r, s) for r in (1, 2) for s in SIDES])
    summary = GOLDEN["levelled_fk_summary"]
    assert off[:, 0].mean() == pytest.approx(summary["mean_dx"], abs=1e-6)
    assert off[:, 1].mean() == pytest.approx(summary["mean_dy"], abs=1e-6)
    assert off.std(axis=0)[:2] == pytest.approx([summary["sd_dx"], summary["sd_dy"]], abs=1e-6)


def test_mean_errors_equal_the_reference_as_printed_and_mended() -> None:
    table = rows("bioloid_abstract_averages")
    for side in SIDES:
        own = [row for row in table if row["Quantity"].startswith(side)]
        for corrected, column in ((False, "as printed"), (True, "with corrections")):
            wanted = [next(float(v) for n, v in row.items() if column in n) for row in own]
            np.testing.assert_allclose(averages(side, corrected), wanted, atol=5.1e-4)
        assert stated(side)[0] == float(own[0]["Printed in abstract"])


def test_what_was_not_simulated_is_said_to_be_missing(page: Page) -> None:
    text = markdown(page)
    for name in ("bioloid_poses", "bioloid_walk", "bioloid_robots", "bioloid_dance"):
        assert f"`gaitlab run {name} --store " in text
    assert "nan" not in text
