"""The audit of the biped: its angles, the mistakes it names, its figures, its simulated walks."""

from __future__ import annotations

from math import degrees
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from gaitlab.papers import biped_effects
from gaitlab.papers.biped import audit, effort_table, gantry_table, postures, verdict, walks
from gaitlab.papers.biped_effects import WALK, boundary_angles, printed_angles
from gaitlab.papers.page import Page, errata_of, markdown
from gaitlab.papers.printed import rows

NOWHERE = Path("no_such_store")


@pytest.fixture(scope="module")
def page() -> Page:
    return audit(NOWHERE)


def walk(n: int, **figures: float) -> pd.DataFrame:
    """Trials whose figures rise by a thousandth from seed to seed."""
    names = ("energy", "absolute_work", "cost_of_transport", "peak_torque", "rms_torque")
    names += ("rms_balancing_moment", "peak_balancing_moment", "distance", "sole_penetration")
    values = {name: 1.0 for name in (*names, "coupling_residual")} | figures
    return pd.DataFrame(
        {"stable": True, **{name: v * (1.0 + 0.001 * k) for name, v in values.items()}}
        for k in range(n)
    )


def test_every_printed_boundary_condition_is_evaluated() -> None:
    known = printed_angles(WALK)
    for row in rows("biped_boundary_conditions"):
        for key in ("printed_value", "corrected_value"):
            assert row[key] in known or row[key] in ("identity", "delete", "-"), row[key]


def test_angles_that_the_paper_has_right_agree_with_the_gait_itself() -> None:
    vias = {degrees(angle) for leg in WALK.vias for via in leg for angle in (via.thigh, via.shank)}
    for row in boundary_angles().rows:
        if row.ours is not None:
            assert min(abs(abs(row.ours) - abs(via)) for via in vias) < 1e-9
            if not row.note:
                assert row.printed == pytest.approx(row.ours, abs=1e-12)


def test_the_misprints_and_only_they_carry_a_note() -> None:
    differing = [r for r in boundary_angles().rows if r.printed != r.ours]
    assert len(differing) == 4  # three lifts from the approximate height, the foot left in the air
    assert all(row.note for row in differing)


@pytest.mark.parametrize(
    ("where", "effect"),
    [
        ("lift angle", "49.75 mm instead of 50.00"),
        ("swing leg at 3 t_f/2", "0.258 m ahead"),
        ("swing leg at t_f", "34.3 mm in the air"),
        ("as a whole", "digs 1.66 mm into the floor; corrected 0.00 mm"),
        ("linear part", "8.51 degrees"),
    ],
)
def test_the_size_of_a_mistake_is_computed(where: str, effect: str) -> None:
    (found,) = [erratum for erratum in errata_of("biped", biped_effects) if where in erratum.where]
    assert effect in found.effect


def test_the_page_says_what_was_not_simulated(page: Page) -> None:
    text = markdown(page, "biped")
    assert "has not been simulated yet" in page.summary
    assert "`gaitlab run biped_straight --store no_such_store`" in text
    assert "`gaitlab run biped_gantry --store no_such_store`" in text
    assert "gantry that holds the trunk level" in page.summary
    assert walks(NOWHERE) == {}
    assert not NOWHERE.exists()


@pytest.mark.long
def test_the_figures_are_written_twice_and_do_not_change(page: Page, tmp_path: Path) -> None:
    assert len(page.pictures) == 4
    for picture in page.pictures:
        picture.draw(tmp_path, picture.name)
    first = {file.name: file.read_bytes() for file in tmp_path.iterdir()}
    assert len(first) == 4
    for picture in page.pictures:
        picture.draw(tmp_path, picture.name)
    assert {file.name: file.read_bytes() for file in tmp_path.iterdir()} == first


def test_in_the_stick_diagram_segments_keep_their_length_and_no_foot_is_below_the_ground() -> None:
    found = postures(np.linspace(0.0, WALK.duration, 201))
    for upper, lower in ((found.hips[:, None], found.knees), (found.knees, found.ankles)):
        lengths = np.hypot(*np.moveaxis(upper - lower, -1, 0))
        np.testing.assert_allclose(lengths, WALK.segment, atol=1e-12)
    assert found.ankles[..., 1].min() > -1e-5
    assert np.abs(np.diff(found.hips, axis=0)).max() < 0.02  # no jump between strides


def test_the_verdict_states_changes_and_calls_overlap_no_difference() -> None:
    found = {
        "straight legs": walk(4, energy=1.1, rms_torque=0.5),
        "bent, hips 0.6 m up": walk(5),
    }
    text = verdict(found)
    assert "positive work +10 %" in text
    assert "RMS torque -50 %" in text
    assert "peak torque no difference" in text
    assert "n = 4 each" in text


def test_the_table_of_efforts_gives_n_and_the_interval_of_a_proportion() -> None:
    found = {"straight legs": walk(4), "bent, hips 0.6 m up": walk(5)}
    table = {row[0]: row[1:] for row in effort_table(found, NOWHERE).rows}
    assert table["n"] == ["4", "5"]
    assert table["stayed up"][0] == "4 of 4 [51, 100] %"
    assert table["positive work [J]"][0] == "1.0 [1.0, 1.0]"
    assert table["gear residual [deg]"][0].startswith("57.3")


def test_an_empty_store_gives_empty_tables() -> None:
    assert effort_table({}, NOWHERE).rows == []
    assert gantry_table(NOWHERE).rows == []
