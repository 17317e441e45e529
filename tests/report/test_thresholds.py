"""What half of the seeds survive: found where a push or a slope is varied, and nowhere guessed."""

from __future__ import annotations

from collections.abc import Callable

from gaitlab.report.forms.tokens import parse
from gaitlab.report.thresholds import threshold_tables
from tests.report.builder import results_of, toy_trials, trial

SEEDS = 10
GROUNDS = {"carpet_4mm": 1.0, "grass_50mm": 0.4}


def swept(
    path: str, levels: list[float], survives: Callable[[float, str, str, int], bool]
) -> list[dict[str, object]]:
    return [
        {
            **trial(0.04, ground, heel, seed, up=survives(level, ground, heel, seed)),
            path: level,
        }
        for heel in ("none", "add")
        for ground in GROUNDS
        for level in levels
        for seed in range(SEEDS)
    ]


def rows(trials: list[dict[str, object]], path: str, **kinds: object) -> dict[str, list[str]]:
    """Cells of the table by the title of their row."""
    text = threshold_tables(results_of(trials, compare=False, **{"rows": path, **kinds}))
    lines = [line.strip("| ").split(" | ") for line in text.splitlines() if line.startswith("|")]
    return {first.strip(): [cell.strip() for cell in rest] for first, *rest in lines[2:]}


def test_each_ground_and_variant_has_its_own() -> None:
    def survives(level: float, ground: str, heel: str, seed: int) -> bool:
        return level < GROUNDS[ground] * (1.0 if heel == "none" else 2.0)

    found = rows(swept("push.impulse", [0.0, 0.5, 1.5, 2.5], survives), "push.impulse")
    cells = {name: [cell.split()[0] for cell in cells] for name, cells in found.items()}
    assert list(cells.values()) == [["1", "0.25"], ["2", "1"]]
    intervals = {name: [cell.split("[")[1] for cell in cells] for name, cells in found.items()}
    assert list(intervals.values()) == [["0.5–1.5]", "0–0.5]"], ["1.5–2.5]", "0.5–1.5]"]]


def test_nothing_is_guessed_beyond_what_was_tried() -> None:
    def survives(level: float, ground: str, heel: str, seed: int) -> bool:
        return ground == "carpet_4mm"

    found = rows(swept("push.impulse", [0.5, 1.0, 2.0], survives), "push.impulse")
    for up, down in found.values():
        assert up.startswith("≥ 2")
        assert down.startswith("< 0.5")


def test_a_slope_has_two_sides() -> None:
    def survives(level: float, ground: str, heel: str, seed: int) -> bool:
        return -3.0 < level < 6.0

    found = rows(swept("slope.pitch", [-8.0, -4.0, 0.0, 4.0, 8.0], survives), "slope.pitch")
    sides = {
        name.rpartition(", ")[2]: [c.split()[0] for c in cells] for name, cells in found.items()
    }
    assert sides == {"uphill": ["6", "6"], "downhill": ["2", "2"]}


def test_level_ground_is_zero_from_either_side() -> None:
    def survives(level: float, ground: str, heel: str, seed: int) -> bool:
        return level >= 0.0

    found = rows(swept("slope.pitch", [-8.0, -4.0, 0.0, 4.0, 8.0], survives), "slope.pitch")
    downhill = [c for name, cells in found.items() if name.endswith("downhill") for c in cells]
    assert downhill
    assert all("[0–4]" in cell for cell in downhill), downhill


def test_it_is_the_same_wherever_the_push_stands_in_the_tables() -> None:
    def survives(level: float, ground: str, heel: str, seed: int) -> bool:
        return level < 1.0 + 0.1 * seed

    trials = swept("push.impulse", [0.0, 1.0, 2.0], survives)
    first = rows(trials, "push.impulse")
    paths = ("gait.heel_strike", "gait.landing_deceleration", "push.impulse")
    assert rows(trials, "gait.step_length", paths=paths) == first


def test_a_page_without_a_push_or_a_slope_says_nothing() -> None:
    assert threshold_tables(results_of(toy_trials())) == ""


def test_a_page_with_a_push_has_the_table() -> None:
    text = threshold_tables(
        results_of(
            swept("push.impulse", [0.0, 1.0], lambda level, *_: level < 0.5),
            compare=False,
            rows="push.impulse",
        )
    )
    assert parse(text)
