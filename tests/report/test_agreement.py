"""How far two engines agree, counted over the cells and seeds that both have walked."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitlab.report.agreement import Agreement, agreement, agreement_blocks, agreement_sentence
from gaitlab.report.results import Results
from tests.report.builder import STEPS, SURFACES, results_of, trial

ENGINES = ("bullet", "mujoco")
Up = Callable[[str, str, float, int], bool]


def walked(up: Up, seeds: dict[str, range] | None = None, heels: tuple[str, ...] = ("none",)):
    """Every cell in both engines; `up` says of engine, ground, step and seed."""
    rows = []
    for engine in ENGINES:
        for heel in heels:
            for surface in SURFACES:
                for step in STEPS:
                    for seed in (seeds or {}).get(engine, range(4)):
                        walk = trial(step, surface, heel, seed, up=up(engine, surface, step, seed))
                        rows.append(walk | {"engine.name": engine})
    return results_of(rows, paths=("engine.name", "gait.heel_strike"), compare=False)


def found(results: Results) -> Agreement:
    both = agreement(results)
    assert both is not None
    return both


def test_an_engine_agrees_with_itself_in_every_cell() -> None:
    both = found(walked(lambda _, surface, step, seed: seed < 2 + 2 * (surface == "grass_50mm")))
    assert both.engines == ENGINES
    assert len(both.cells) == len(SURFACES) * len(STEPS)
    assert not both.differing
    assert both.stable.difference == 0.0
    assert both.pairs[True, False] == both.pairs[False, True] == 0
    assert both.pairs.total() == 4 * len(both.cells)


@given(st.integers(0, 2**32 - 1))
def test_counts_add_up_and_exchanging_the_engines_exchanges_them(draw: int) -> None:
    rng = np.random.default_rng(draw)
    ups = {
        (engine, surface, step, seed): bool(rng.random() < 0.6)
        for engine in ENGINES for surface in SURFACES for step in STEPS for seed in range(4)
    }  # fmt: skip
    other = dict(zip(ENGINES, reversed(ENGINES), strict=True))
    one = found(walked(lambda *place: ups[place]))
    turned = found(walked(lambda engine, *place: ups[(other[engine], *place)]))
    for counts, exchanged in ((one.verdicts, turned.verdicts), (one.pairs, turned.pairs)):
        assert {(b, a): n for (a, b), n in counts.items()} == dict(exchanged)
    assert one.verdicts.total() == len(one.cells)
    assert len(one.differing) == sum(n for (a, b), n in one.verdicts.items() if a != b)
    assert one.stable.difference == pytest.approx(-turned.stable.difference)
    up = [sum(ups[place] for place in ups if place[0] == engine) for engine in ENGINES]
    assert one.stable.difference * one.pairs.total() == pytest.approx(up[1] - up[0])


def test_seeds_that_only_one_engine_has_walked_do_not_count() -> None:
    both = found(walked(lambda *_: True, {"bullet": range(2), "mujoco": range(4)}))
    assert both.pairs.total() == 2 * len(both.cells)
    assert {cell.second.n for cell in both.cells} == {2}


def test_cells_of_every_variant_are_told_apart() -> None:
    both = found(walked(lambda *_: True, heels=("none", "add")))
    assert len(both.cells) == 2 * len(SURFACES) * len(STEPS)
    assert "gait.heel_strike" in both.paths


def test_what_is_told_differently_is_named_and_opposite_ends_are_counted() -> None:
    def up(engine: str, surface: str, step: float, seed: int) -> bool:
        if surface == "grass_50mm" and step == 0.08:
            return engine == "mujoco"
        return not (surface == "carpet_4mm" and step == 0.04) or seed < 1 + (engine == "mujoco")

    results = walked(up)
    both = found(results)
    places = [dict(zip(both.paths, cell.values, strict=True)) for cell in both.differing]
    assert [(place["surface"], place["gait.step_length"]) for place in places] == [
        ("grass_50mm", 0.08),
        ("carpet_4mm", 0.04),
    ]
    assert [cell.opposed for cell in both.differing] == [True, False]
    said = "\n".join(agreement_blocks(results, both))
    assert "0/4" in said
    assert f"{len(both.cells) - 2} of {len(both.cells)} cells" in agreement_sentence(both)


def test_a_page_of_one_engine_says_nothing_of_agreement() -> None:
    rows = [trial(0.04, "carpet_4mm", "none", seed) | {"engine.name": "mujoco"} for seed in (0, 1)]
    assert agreement(results_of(rows, compare=False)) is None
    assert agreement(results_of([trial(0.04, "carpet_4mm", "none", 0)], compare=False)) is None


def test_engines_that_share_no_seed_cannot_be_paired() -> None:
    seeds = {"bullet": range(2), "mujoco": range(2, 4)}
    assert agreement(walked(lambda *_: True, seeds)) is None
