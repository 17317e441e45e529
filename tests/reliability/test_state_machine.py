"""Whatever happens to a store, its table is what the plan says, as far as it is there.

Hypothesis runs, kills, deletes, damages, merges and changes the grid in any order. Trials are
pretended, so that the table is a pure function of the plan; drivers that are killed are real
processes and die by SIGKILL before a step on the file system.
"""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from gaitlab.store import Store
from gaitlab.store.merge import merge
from tests.reliability import sweeps
from tests.reliability.drivers import drivers

GRIDS = (
    ("grid.gait.step_length=[0.0, 0.04]", "grid.gait.lateral_sway=[0.01]"),
    ("grid.gait.step_length=[0.0, 0.06]", "grid.gait.lateral_sway=[0.01]"),
    ("grid.gait.step_length=[0.0]", "grid.gait.lateral_sway=[0.01, 0.02]"),
)
GRID = st.sampled_from(GRIDS)
DAMAGE = {
    "truncate": lambda whole: whole[: len(whole) // 2],
    "empty": lambda whole: b"",
    "grow": lambda whole: whole + b"more",
    "foreign": lambda whole: b"nothing of gaitlab's",
}


class Sweeps(RuleBasedStateMachine):
    """One store and everything that can happen to it."""

    def __init__(self) -> None:
        super().__init__()
        self._folder = Path(tempfile.mkdtemp())
        self._store = Store(self._folder / "data")
        self._known = {
            trial_id: row
            for grid in GRIDS
            for seeds in (1, 2)
            for trial_id, row in sweeps.expected(*grid, seeds=seeds).items()
        }

    def teardown(self) -> None:
        shutil.rmtree(self._folder)

    @property
    def _files(self) -> list[Path]:
        return sorted((self._store.path / "trials").glob("*/*.parquet"))

    @rule(grid=GRID, seeds=st.integers(1, 2))
    def run(self, grid: tuple[str, ...], seeds: int) -> None:
        wanted = sweeps.expected(*grid, seeds=seeds)
        there = {i for i, state in self._store.states().items() if state == "DONE"}
        summary = sweeps.run(self._store, *grid, seeds=seeds)
        assert summary.done == len(wanted.keys() - there), "only what is missing was run"
        assert sweeps.table(self._store) == wanted
        assert list(self._store.path.rglob("*.tmp")) == []

    @rule(grid=GRID, seeds=st.integers(1, 2), step=st.integers(1, 70))
    def kill(self, grid: tuple[str, ...], seeds: int, step: int) -> None:
        words = [word for setting in grid for word in ("--set", setting)]
        command = ("run", str(sweeps.FILE), *words, "--seeds", str(seeds), "-j", "0")
        store = ("--store", str(self._store.path))
        assert DRIVERS is not None
        assert DRIVERS.run(*command, *store, task="pretend", kill_at=step) in (-9, 0)

    @precondition(lambda self: self._files)
    @rule(data=st.data())
    def delete(self, data: st.DataObject) -> None:
        data.draw(st.sampled_from(self._files)).unlink()

    @precondition(lambda self: self._files)
    @rule(data=st.data(), how=st.sampled_from(sorted(DAMAGE)))
    def damage(self, data: st.DataObject, how: str) -> None:
        path = data.draw(st.sampled_from(self._files))
        path.write_bytes(DAMAGE[how](path.read_bytes()))

    @rule()
    def lose_the_index(self) -> None:
        (self._store.path / "index.jsonl").unlink(missing_ok=True)

    @rule(grid=GRID)
    def merge(self, grid: tuple[str, ...]) -> None:
        with tempfile.TemporaryDirectory(dir=self._folder) as folder:
            other = Store(Path(folder) / "data")
            sweeps.run(other, *grid)
            done = merge(self._store, other)
            assert set(other.states()) <= set(self._store.states())
            assert not any(message.startswith("trial") for message in done.conflicts)

    @invariant()
    def every_row_is_the_plans(self) -> None:
        if sweeps.NAME not in self._store.experiments():
            return
        rows = sweeps.table(self._store)
        for trial_id, row in rows.items():
            assert row == self._known[trial_id]
        assert rows.keys() <= set(self._store.states())


DRIVERS = None


@pytest.mark.long
def test_the_table_is_the_plans_pure_function_whatever_happens() -> None:
    global DRIVERS
    from hypothesis.stateful import run_state_machine_as_test

    chosen = settings(
        max_examples=10, stateful_step_count=9, suppress_health_check=list(HealthCheck)
    )
    with drivers() as DRIVERS:
        run_state_machine_as_test(Sweeps, settings=chosen)
