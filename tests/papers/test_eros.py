"""The audit of the EROS paper: what was walked stands beside the printed tables."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from gaitlab.papers import eros
from gaitlab.papers.printed import rows as rows_of
from tests.papers.reproduction.printed import printed_trials

STORE = Path("none")


def walked(monkeypatch: pytest.MonkeyPatch, trials: list[dict[str, object]]) -> None:
    """The store holds these trials."""
    frame = pd.DataFrame(trials)
    monkeypatch.setattr(eros, "trials", lambda store, name, states: frame)


@pytest.mark.parametrize("table", ["eros_table7", "eros_table8"])
def test_walks_as_printed_agree_in_every_cell_of_their_own_table(monkeypatch, table) -> None:
    walked(monkeypatch, printed_trials(seeds=3))
    shown = eros.walking_table(table, STORE)
    assert "40 of 40 cells agree, 28 of 28 forward" in shown.text
    cells = [cell for row in shown.rows for cell in row[2:]]
    assert len(cells) == 40
    assert set(cells) == {"stable; 3 of 3", "unstable; 0 of 3"}


def test_a_table_of_which_nothing_was_walked_names_the_command(monkeypatch) -> None:
    walked(monkeypatch, [])
    shown = eros.walking_table("eros_table7", STORE)
    assert "`gaitlab run eros_frozen" in shown.text
    assert {cell for row in shown.rows for cell in row[2:]} == {"stable", "unstable"}


def test_an_amplitude_is_of_the_walks_with_the_printed_step_and_sway(monkeypatch) -> None:
    trials = [
        {
            "gait.step_length": 0.005 * float(walk["X_mm"]) + off,
            "gait.lateral_sway": 1e-3 * float(walk["Y_mm"]),
            "surface": "grass_50mm",
            "gait.heel_strike": "add" if walk["optimization"] == "with" else "none",
            "pitch_amplitude": np.radians(
                float(walk["avg_pitch_vibration_deg_plusminus"]) + 90 * (off > 0)
            ),
            "fell": walk["fell"] == "yes",
        }
        for walk in rows_of("eros_experiments")
        for off in (0.0, 0.01)
    ]
    walked(monkeypatch, trials)
    *_, amplitudes = eros.experiments(STORE)
    assert [row.ours for row in amplitudes.rows] == pytest.approx(
        [row.printed for row in amplitudes.rows]
    )
    assert "1 of 1 fell, 1 walked" in amplitudes.rows[0].note
    assert "0 of 1 fell" in amplitudes.rows[1].note
