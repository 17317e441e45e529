"""Damage to the files of a store is found, or harmless; no wrong number ever comes out."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

from gaitlab.errors import StoreError
from gaitlab.log import TrialLog
from gaitlab.store import Store, TrialRecord
from gaitlab.store.parquet import columns_sha256
from tests import recorded
from tests.reliability import sweeps

CUT, FLIPS, INDEX_FLIPS = 97, 500, 300


@pytest.fixture
def store(tmp_path: Path) -> Store:
    return Store(tmp_path / "data")


def outcome(store: Store) -> tuple[TrialRecord, TrialLog] | None:
    """Record and log of the first trial, None where the store refuses to give them."""
    trial_id = recorded.trial_id(1)
    try:
        return store.record(trial_id), store.log(trial_id)
    except StoreError:
        return None


def test_a_trial_cut_at_every_97th_byte_is_never_read(store: Store) -> None:
    store.commit(recorded.record(1), recorded.log())
    path = store.file(recorded.trial_id(1))
    whole = path.read_bytes()
    for length in range(0, len(whole), CUT):
        path.write_bytes(whole[:length])
        assert outcome(store) is None, length
        assert store.states() == {}, length
    assert len(whole) // CUT > 100


def test_500_flipped_bits_are_found_or_harmless(store: Store) -> None:
    record, log = recorded.record(1), recorded.log()
    store.commit(record, log)
    path, chance, found = store.file(record.trial_id), random.Random(7), 0
    whole = path.read_bytes()
    for _ in range(FLIPS):
        path.write_bytes(flipped(whole, chance))
        given = outcome(store)
        found += given is None
        if given is not None:
            assert given[0] == record
            assert columns_sha256(given[1]) == columns_sha256(log)
    assert found > FLIPS / 2, "most bits carry something"


def flipped(content: bytes, chance: random.Random) -> bytes:
    changed = bytearray(content)
    changed[chance.randrange(len(changed))] ^= 1 << chance.randrange(8)
    return bytes(changed)


def test_flipped_bits_of_index_and_list_change_no_number_of_the_table(store: Store) -> None:
    sweeps.run(store, *sweeps.SMALL)
    right, chance = sweeps.table(store), random.Random(8)
    refused = 0
    for name in ("index.jsonl", f"experiments/{sweeps.NAME}/trials.jsonl"):
        path = store.path / name
        whole = path.read_bytes()
        for _ in range(INDEX_FLIPS // 2):
            path.write_bytes(flipped(whole, chance))
            refused += not same_or_refused(store, right)
        path.write_bytes(whole)
    assert refused > 50, "a damaged list is said to be damaged"


def same_or_refused(store: Store, right: dict[str, dict[str, object]]) -> bool:
    try:
        assert sweeps.table(store) == right
    except StoreError:
        return False
    return True


def test_a_query_of_ticks_refuses_a_flipped_log_that_duckdb_would_read(store: Store) -> None:
    sweeps.run(store, *sweeps.SMALL)
    path = store.file(next(iter(store.states())))
    content = bytearray(path.read_bytes())
    content[len(content) // 4] ^= 1  # amid the columns
    path.write_bytes(content)
    with pytest.raises(StoreError, match="verify --repair"):
        store.query("SELECT avg(roll) FROM ticks")


def test_a_foreign_file_in_a_trials_place_is_kept_aside_and_the_trial_done(store: Store) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    sweeps.run(store, *sweeps.SMALL)
    right = sweeps.content(store)
    path = store.file(next(iter(store.states())))
    pq.write_table(pa.table({"mine": [1, 2, 3]}), path)
    mine = path.read_bytes()
    assert sweeps.run(store, *sweeps.SMALL).done == 1
    assert sweeps.content(store) == right
    assert [file.read_bytes() for file in (store.path / "aside").iterdir()] == [mine]


def test_a_trial_of_an_older_format_is_named_and_kept_aside(
    store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as patch:
        patch.setattr("gaitlab.store.parquet.FORMAT_VERSION", 0)
        store.commit(recorded.record(1), recorded.log())
    old = store.file(recorded.trial_id(1)).read_bytes()
    assert [error.kind for error in store.index().unreadable] == ["older"]
    store.commit(recorded.record(1), recorded.log())
    assert store.states() == {recorded.trial_id(1): "DONE"}
    assert [file.read_bytes() for file in (store.path / "aside").iterdir()] == [old]
