"""Damage to the files of a store is found, or harmless; no wrong number ever comes out."""

from __future__ import annotations

import errno
import io
import os
import random
import re
import resource
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from gaitlab.errors import StoreError
from gaitlab.log import TrialLog
from gaitlab.log.columns import columns
from gaitlab.store import Store, TrialRecord
from gaitlab.store.merge import merge
from gaitlab.store.parquet import Unreadable, columns_sha256, read_columns
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


def test_columns_that_are_whole_but_not_those_of_the_trial_are_no_log(store: Store) -> None:
    """Every page's checksum is right and the record's seal too; only the columns' SHA-256 tells."""
    record, log = recorded.record(1), recorded.log()
    store.commit(record, log)
    path = store.file(record.trial_id)
    table = pq.read_table(path)
    roll = table.schema.get_field_index("roll")
    exchanged = table.set_column(roll, table.schema.field("roll"), table.column("pitch"))
    pq.write_table(exchanged, path, write_page_checksum=True)
    assert store.record(record.trial_id) == record
    with pytest.raises(StoreError, match="damaged"):
        store.log(record.trial_id)


def test_a_part_of_a_log_is_as_it_was_written_or_refused(store: Store) -> None:
    """Some columns are read without the SHA-256 of all; the checksums of their pages tell."""
    record, log = recorded.record(1), recorded.log(ticks=2000)
    store.commit(record, log)
    path, chance = store.file(record.trial_id), random.Random(9)
    whole, refused = path.read_bytes(), 0
    chunk = pq.ParquetFile(path).metadata.row_group(0).column(log_index(path, "pitch"))
    first, length = chunk.data_page_offset, chunk.total_compressed_size
    for _ in range(100):
        content = bytearray(whole)
        content[first + chance.randrange(length)] ^= 1 << chance.randrange(8)
        path.write_bytes(content)
        try:
            part = read_columns(path, ["pitch"])
        except Unreadable:
            refused += 1
            continue
        assert part is not None
        np.testing.assert_array_equal(part.arrays["pitch"], log.arrays["pitch"])
    assert refused > 90


def log_index(path: Path, name: str) -> int:
    index: int = pq.read_schema(path).get_field_index(name)
    return index


def test_a_name_of_a_column_that_is_no_text_any_more_is_damage(store: Store) -> None:
    """The reader decodes names as UTF-8, which the highest bit of one letter ends."""
    store.commit(recorded.record(1), recorded.log())
    path = store.file(recorded.trial_id(1))
    whole = path.read_bytes()
    for column in columns(recorded.JOINTS):
        place = whole.index(b"\x18%c%b" % (len(column.name), column.name.encode())) + 2
        path.write_bytes(whole[:place] + bytes([whole[place] | 0x80]) + whole[place + 1 :])
        assert outcome(store) is None, column.name
        assert [error.kind for error in store.index().unreadable] == ["damaged"]


def failing(broken: Path, number: int) -> Callable[[Path], io.FileIO]:
    """Opens files as ever, but for one whose disk gives an error at every read."""

    class Failing(io.FileIO):
        def read(self, size: int | None = -1) -> bytes:
            raise OSError(number, os.strerror(number))

    return lambda path: (Failing if path == broken else io.FileIO)(path)


@pytest.mark.parametrize("number", [errno.EIO, errno.EACCES, errno.ESTALE])
def test_a_disk_that_fails_is_no_damage_of_the_file(
    store: Store, monkeypatch: pytest.MonkeyPatch, number: int
) -> None:
    sweeps.run(store, *sweeps.SMALL)
    right, trials = sweeps.content(store), sorted(store.states())
    other = Store(store.path.with_name("other"))
    merge(other, store)
    (store.path / "index.jsonl").unlink()
    with monkeypatch.context() as patch:
        patch.setattr("gaitlab.store.parquet.open_to_read", failing(store.file(trials[0]), number))
        assert [error.kind for error in store.unsound()] == ["unreachable"]
        assert sorted(store.states()) == trials[1:]
        for reading in (store.record, store.log):
            with pytest.raises(StoreError, match=re.escape(os.strerror(number))):
                reading(trials[0])
        for writing in (
            lambda: store.make_way(store.file(trials[0])),
            lambda: sweeps.run(store, *sweeps.SMALL),
            lambda: merge(store, other),
        ):
            with pytest.raises(StoreError, match=re.escape(os.strerror(number))):
                writing()
    assert sweeps.run(store, *sweeps.SMALL).cached == len(trials)
    assert sweeps.content(store) == right


def test_a_process_that_may_open_no_file_judges_none(store: Store) -> None:
    sweeps.run(store, *sweeps.SMALL)
    right, trial_id = sweeps.content(store), next(iter(store.states()))
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (os.dup(0), hard))
    try:
        for reading in (store.index, store.rebuild, lambda: store.record(trial_id)):
            with pytest.raises(StoreError, match="open files"):
                reading()
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
    assert sweeps.content(store) == right


WITHOUT_MEMORY = """
import resource, sys
from pathlib import Path
from gaitlab.store import Store
import pyarrow.parquet
store = Store(Path(sys.argv[1]))
store.index()
used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (used + int(sys.argv[2]),) * 2)
try:
    print(list(store.unsound()))
except Exception as error:
    print(type(error).__name__, error)
"""


@pytest.mark.parametrize("room", [0, 1_000_000, 20_000_000])
def test_a_process_without_memory_judges_no_file(store: Store, room: int) -> None:
    store.commit(recorded.record(1), recorded.log(30_000))
    words = [sys.executable, "-c", WITHOUT_MEMORY, str(store.path), str(room)]
    done = subprocess.run(words, capture_output=True, text=True, check=False, timeout=60)
    assert done.stdout.startswith(f"StoreError {store.path}"), done
    assert os.strerror(errno.ENOMEM) in done.stdout


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
    group = pq.ParquetFile(path).metadata.row_group(0)
    amid = group.column(group.num_columns // 2)
    content = bytearray(path.read_bytes())
    content[amid.data_page_offset + amid.total_compressed_size - 1] ^= 1
    path.write_bytes(content)
    with pytest.raises(StoreError, match="verify --repair"):
        store.query("SELECT avg(roll) FROM ticks")


def test_a_foreign_file_in_a_trials_place_is_kept_aside_and_the_trial_done(store: Store) -> None:
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
