"""Shares of an experiment: everything once, of equal weight, the same for whoever works it out."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitlab.cli import run_command_line
from gaitlab.errors import UsageError
from gaitlab.running import dispatch, outlook
from gaitlab.running.sweep import share_out
from gaitlab.store import Shard, ShardStatus, Store, shares
from tests.pretended import FILE, experiment, pretend_well

SEEDS, CELLS = 3, 24
STUDY = FILE.with_name("pretended_study.yaml")
lengths = st.lists(st.floats(0.1, 100.0), min_size=1, max_size=60)


@pytest.fixture
def store(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Store:
    monkeypatch.setattr("gaitlab.running.processes.simulated", pretend_well)
    return Store(tmp_path / "data")


@given(seconds=lengths, count=st.integers(1, 12))
def test_shares_hold_every_trial_once_and_differ_by_one_trial_at_most(
    seconds: list[float], count: int
) -> None:
    trials = {f"{number:032x}": length for number, length in enumerate(seconds)}
    numbers = shares(trials, count)
    assert list(numbers) == list(trials)
    assert set(numbers.values()) <= set(range(1, count + 1))
    loads = [
        sum(trials[key] for key in trials if numbers[key] == shard) for shard in range(1, count + 1)
    ]
    assert max(loads) - min(loads) <= max(seconds) * (1 + 1e-9)
    sizes = [list(numbers.values()).count(shard) for shard in range(1, count + 1)]
    assert max(sizes) - min(sizes) <= 1


@given(seeds=st.integers(1, 40), count=st.integers(1, 12))
def test_every_shard_has_its_part_of_every_cell(seeds: int, count: int) -> None:
    """So that a cell in which the robot soon falls lightens no shard more than another."""
    trials = {f"{cell} {seed}": 1.0 for cell in range(10) for seed in range(seeds)}
    numbers = shares(trials, count)
    for cell in range(10):
        mine = [numbers[f"{cell} {seed}"] for seed in range(seeds)]
        counts = [mine.count(shard) for shard in range(1, count + 1)]
        assert max(counts) - min(counts) <= 2


@given(number=st.integers(-1, 12), count=st.integers(-1, 12))
def test_a_shard_reads_as_it_is_written_or_is_refused(number: int, count: int) -> None:
    text = f"{number}/{count}"
    if 1 <= number <= count:
        assert str(Shard.of(text)) == text
    else:
        with pytest.raises(UsageError):
            Shard.of(text)


@pytest.mark.parametrize(
    "text", ["0/4", "5/4", "1", "1/", "/4", "a/b", "1/4/2", "1.0/4", "", "٣/٤"]
)
def test_what_is_no_shard_is_exit_2(text: str, tmp_path: Path) -> None:
    place = ["--store", str(tmp_path / "data")]
    assert run_command_line(["run", str(FILE), "--shard", text, *place]) == 2
    assert not (tmp_path / "data").exists()


def test_a_study_has_no_shards(tmp_path: Path) -> None:
    place = ["--store", str(tmp_path / "data")]
    assert run_command_line(["run", str(STUDY), "--shard", "1/2", *place]) == 2
    assert not (tmp_path / "data").exists()


@pytest.mark.parametrize("count", [1, 4, 100])
def test_shards_one_by_one_are_the_whole(store: Store, tmp_path: Path, count: int) -> None:
    whole, wanted = Store(tmp_path / "whole"), experiment(SEEDS)
    dispatch(wanted, whole, jobs=0)
    done = 0
    for number in range(1, count + 1):
        shard = Shard(number=number, count=count)
        due = sum(outlook(wanted, store, shard).due(False).values())
        summary = dispatch(wanted, store, jobs=0, shard=shard)
        assert (summary.planned, summary.done, summary.left) == (due, due, 0)
        done += summary.done
    assert done == SEEDS * CELLS
    assert store.table(wanted.listed_as).to_csv() == whole.table(wanted.listed_as).to_csv()
    assert dispatch(wanted, store, jobs=0).done == 0


def test_a_share_hangs_on_the_plan_and_not_on_what_is_there(store: Store) -> None:
    wanted, shard = experiment(SEEDS), Shard.of("2/3")
    planned = outlook(wanted, store, shard).planned
    dispatch(wanted, store, jobs=0, shard=Shard.of("1/5"))
    again = outlook(wanted, store, shard)
    assert again.planned == planned
    assert again.count("cached") > 0
    assert dispatch(wanted, store, jobs=0, shard=shard).cached == again.count("cached")


def statuses(store: Store) -> list[ShardStatus]:
    index = store.index()
    return store.shards(store.experiments()[experiment(SEEDS).listed_as], index)


def test_the_store_alone_tells_how_far_the_shards_are(store: Store) -> None:
    wanted = experiment(SEEDS)
    share_out(wanted, store, 3)
    assert [s.state for s in statuses(store)] == ["pending"] * 3
    dispatch(wanted, store, jobs=0, shard=Shard.of("2/3"))
    with store.writing(wanted.listed_as, Shard.of("3/3")):
        assert [s.state for s in statuses(store)] == ["pending", "done", "running"]
    assert [s.state for s in statuses(store)] == ["pending", "done", "pending"]
    assert [s.left for s in statuses(store)] == [CELLS, 0, CELLS]
    dispatch(wanted, store, jobs=0)
    assert [s.state for s in statuses(store)] == ["done"] * 3


def test_shares_of_another_plan_or_with_a_flipped_bit_tell_nothing(store: Store) -> None:
    wanted = experiment(SEEDS)
    dispatch(wanted, store, jobs=0, shard=Shard.of("1/2"))
    (file,) = (store.path / "experiments" / wanted.listed_as).glob("shards*")
    content = file.read_bytes()
    for place in range(0, len(content), 97):
        flipped = bytearray(content)
        flipped[place] ^= 1
        file.write_bytes(flipped)
        assert statuses(store) == [], place
    file.write_bytes(content)
    assert len(statuses(store)) == 2
    assert run_command_line(["status", wanted.listed_as, "--store", str(store.path)]) == 0
