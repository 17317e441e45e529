"""Which parameters make variants, and what these are called."""

from __future__ import annotations

import pandas as pd

from gaitlab.report.variants import PLAIN, find_variants, free_paths, is_off, label_of

GRID = pd.DataFrame(
    [
        {"row": r, "surface": s, "heel": h, "sway": 10 * r, "lift": 0.03}
        for r in (1, 2)
        for s in ("a", "b")
        for h in ("add", "none")
    ]
)


def test_only_what_moves_on_its_own_makes_variants() -> None:
    assert free_paths(GRID, ["row", "heel", "sway", "lift"], ["row", "surface"]) == ["heel"]


def test_without_free_parameters_there_is_one_plain_variant() -> None:
    variants, labels = find_variants(GRID, [])
    assert [variant.label for variant in variants] == [PLAIN]
    assert set(labels) == {PLAIN}


def test_the_plain_variant_comes_first_whatever_the_file_says() -> None:
    variants, labels = find_variants(GRID, ["heel"])
    assert [variant.label for variant in variants] == [PLAIN, "heel"]
    assert labels[0] == "heel"


def test_a_length_of_zero_is_not_switched_off() -> None:
    assert not is_off(0.0)
    assert label_of({"gait.lateral_sway": 0.0}) == "lateral sway 0"
    assert label_of({"gait.heel_strike": "none", "gait.push_off": False}) == PLAIN


def test_values_are_named_when_a_switch_has_several() -> None:
    frame = pd.DataFrame({"gait.heel_strike": ["none", "add", "literal"]})
    _, labels = find_variants(frame, ["gait.heel_strike"])
    assert labels == [PLAIN, "heel strike add", "heel strike literal"]
