"""The file of a trial: whole or not there, and never a wrong number in it."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gaitlab.errors import StoreError, UnknownName
from gaitlab.log.columns import columns
from gaitlab.store import Store
from gaitlab.store.durable import write_durably
from gaitlab.store.parquet import columns_sha256, encode
from tests import recorded


@pytest.fixture
def store(tmp_path: Path) -> Store:
    return Store(tmp_path / "data")


def test_a_log_comes_back_bit_for_bit(store: Store) -> None:
    log = recorded.log()
    store.commit(recorded.record(1), log)
    found = store.log(recorded.trial_id(1))
    assert found.header == log.header
    for name, array in log.arrays.items():
        assert found.arrays[name].dtype == array.dtype
        assert found.arrays[name].tobytes() == array.tobytes(), name


@given(st.binary(min_size=4, max_size=4), st.integers(0, 9))
def test_every_float_keeps_its_bits(pattern: bytes, tick: int) -> None:
    log = recorded.log(10)
    array = log.arrays["roll"].copy()
    array[tick] = np.frombuffer(pattern, dtype=np.float32)[0]
    changed = dataclasses.replace(log, arrays={**log.arrays, "roll": array})
    table = pq.read_table(pa.BufferReader(encode(recorded.record(1), changed)))
    assert table.column("roll").to_numpy().tobytes() == array.tobytes()


def test_the_columns_of_equal_logs_have_equal_bytes_and_of_others_not() -> None:
    assert encode(recorded.record(1), recorded.log(seed=1)) == encode(
        recorded.record(1), recorded.log(seed=1)
    )
    assert columns_sha256(recorded.log(seed=1)) != columns_sha256(recorded.log(seed=2))


@pytest.mark.parametrize("state", ["DONE", "INFEASIBLE", "FAILED"])
def test_a_record_comes_back_as_it_was(store: Store, state: str) -> None:
    log = recorded.log() if state == "DONE" else None
    store.commit(recorded.record(1, state), log)
    assert store.record(recorded.trial_id(1)) == recorded.record(1, state)


def test_metrics_that_are_not_finite_come_back_as_not_defined(store: Store) -> None:
    metrics = {"time_to_fall": float("nan"), "cost_of_transport": float("inf"), "distance": 2.0}
    store.commit(recorded.record(1, **metrics), recorded.log())
    found = store.record(recorded.trial_id(1)).metrics
    assert found == {"time_to_fall": None, "cost_of_transport": None, "distance": 2.0}


def test_a_trial_without_a_log_says_why_it_has_none(store: Store) -> None:
    store.commit(recorded.record(1, "INFEASIBLE"), None)
    with pytest.raises(StoreError, match=r"it ended INFEASIBLE: .*left_leg at tick 7"):
        store.log(recorded.trial_id(1))
    with pytest.raises(StoreError, match=r"it ended INFEASIBLE"):
        store.log_part(recorded.trial_id(1), ["time"])


def test_a_part_of_a_log_is_the_same_as_in_the_whole(store: Store) -> None:
    names = ("time", "pitch", "support", "body_contact")
    store.commit(recorded.record(1), recorded.log())
    name = recorded.trial_id(1)
    part, whole = store.log_part(name, names), store.log(name)
    assert part.header == whole.header
    assert set(part.arrays) == set(names)
    for column in names:
        assert part.arrays[column].dtype == whole.arrays[column].dtype
        assert part.arrays[column].tobytes() == whole.arrays[column].tobytes()


def test_any_parquet_reader_finds_units_and_one_row_a_tick(store: Store) -> None:
    store.commit(recorded.record(1), recorded.log(40))
    file = pq.ParquetFile(store.file(recorded.trial_id(1)))
    assert file.metadata.num_rows == 40
    assert file.metadata.num_row_groups == 1
    for column in columns(recorded.JOINTS):
        field = file.schema_arrow.field(column.name)
        assert field.metadata[b"unit"].decode() == column.unit
        assert field.metadata[b"doc"].decode() == column.doc


def test_a_file_cut_anywhere_is_never_read(store: Store) -> None:
    store.commit(recorded.record(1), recorded.log())
    path = store.file(recorded.trial_id(1))
    whole = path.read_bytes()
    for length in range(0, len(whole), 997):
        path.write_bytes(whole[:length])
        with pytest.raises(StoreError, match="damaged"):
            store.log(recorded.trial_id(1))
        assert store.states() == {}


@settings(max_examples=60, deadline=None)
@given(st.data())
def test_a_flipped_bit_is_found_or_harmless(tmp_path_factory: pytest.TempPathFactory, data) -> None:
    store = Store(tmp_path_factory.mktemp("flip"))
    log, record = recorded.log(), recorded.record(1)
    store.commit(record, log)
    path = store.file(record.trial_id)
    content = bytearray(path.read_bytes())
    content[data.draw(st.integers(0, len(content) - 1))] ^= 1 << data.draw(st.integers(0, 7))
    path.write_bytes(content)
    try:
        found = store.log(record.trial_id)
    except StoreError:
        return
    assert columns_sha256(found) == columns_sha256(log)
    assert store.record(record.trial_id) == record


def test_a_trial_under_the_name_of_another_is_not_believed(store: Store) -> None:
    store.commit(recorded.record(1), recorded.log())
    other = store.file(recorded.trial_id(2))
    other.parent.mkdir(exist_ok=True)
    other.write_bytes(store.file(recorded.trial_id(1)).read_bytes())
    with pytest.raises(StoreError, match="foreign"):
        store.record(recorded.trial_id(2))
    assert list(store.states()) == [recorded.trial_id(1)]


def test_a_file_of_a_newer_version_is_named_and_never_overwritten(
    store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as patch:
        patch.setattr("gaitlab.store.parquet.FORMAT_VERSION", 99)
        store.commit(recorded.record(1), recorded.log())
    path = store.file(recorded.trial_id(1))
    before = path.read_bytes()
    with pytest.raises(StoreError, match="newer: format 99"):
        store.commit(recorded.record(1), recorded.log())
    assert path.read_bytes() == before
    assert store.states() == {}
    assert [error.kind for error in store.index().unreadable] == ["newer"]


def test_a_damaged_file_is_replaced_by_the_next_commit(store: Store) -> None:
    path = store.file(recorded.trial_id(1))
    path.parent.mkdir(parents=True)
    path.write_bytes(b"PAR1 torn")
    store.commit(recorded.record(1), recorded.log())
    assert store.states() == {recorded.trial_id(1): "DONE"}


def test_an_unknown_trial_is_said_to_be_unknown(store: Store) -> None:
    with pytest.raises(UnknownName, match="no trial"):
        store.record(recorded.trial_id(1))


def test_a_write_that_fails_leaves_the_old_file_and_nothing_else(tmp_path: Path) -> None:
    target = tmp_path / "folder"
    target.mkdir()
    with pytest.raises(StoreError, match="cannot be written"):
        write_durably(target, b"a file cannot replace a folder", within=tmp_path)
    assert list(tmp_path.iterdir()) == [target]


def test_a_folder_that_is_a_file_is_a_store_error(tmp_path: Path) -> None:
    (tmp_path / "data").write_text("not a folder")
    with pytest.raises(StoreError, match="--store DIR"):
        Store(tmp_path / "data").commit(recorded.record(1), recorded.log())
