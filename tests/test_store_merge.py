"""Two stores into one: the union of both, whichever comes first, and nothing lost in it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pyarrow.parquet as pq
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gaitlab.cli import run_command_line
from gaitlab.errors import UsageError
from gaitlab.store import Store, fingerprint
from gaitlab.store.merge import merge
from tests import recorded

NUMBERS = st.sets(st.integers(0, 9), max_size=6)


def filled(path: Path, numbers: set[int], name: str = "sweep") -> Store:
    store = Store(path)
    (path / "trials").mkdir(parents=True)
    for number in sorted(numbers):
        store.commit(recorded.record(number), recorded.log(8, seed=number))
    store.register(recorded.experiment(name), recorded.planned(sorted(numbers)))
    return store


def trials(store: Store) -> dict[str, str]:
    return {trial_id: fingerprint(store.file(trial_id)) for trial_id in store.states()}


def rows(store: Store) -> set[str]:
    return {repr(row) for row in store.table().to_dict("records")}


@settings(max_examples=15)
@given(NUMBERS, NUMBERS)
def test_the_union_holds_both_in_either_order_and_merging_again_changes_nothing(
    tmp_path_factory: pytest.TempPathFactory, ours: set[int], theirs: set[int]
) -> None:
    folder = tmp_path_factory.mktemp("merge")
    one, other = filled(folder / "one", ours), filled(folder / "other", theirs, "second")
    reverse = filled(folder / "reverse", theirs, "second")
    done = merge(one, other)
    merge(reverse, filled(folder / "again", ours))
    assert (done.taken, done.shared) == (len(theirs - ours), len(theirs & ours))
    assert trials(one) == trials(reverse)
    assert set(one.states()) == {recorded.trial_id(number) for number in ours | theirs}
    indices = [(store.path / "index.jsonl").read_bytes() for store in (one, reverse)]
    assert indices[0] == indices[1]
    assert rows(one) == rows(reverse)
    again = merge(one, other)
    assert (again.taken, again.shared, again.conflicts) == (0, len(theirs), ())


def test_a_trial_that_both_have_with_other_numbers_is_kept_twice(tmp_path: Path) -> None:
    one, other = filled(tmp_path / "one", {1, 2}), filled(tmp_path / "other", {1})
    other.commit(recorded.record(1, distance=9.9), recorded.log(8, seed=77))
    before = trials(one)
    theirs = other.file(recorded.trial_id(1)).read_bytes()
    done = merge(one, other)
    assert trials(one) == before, "what was here stays"
    assert [path.read_bytes() for path in (one.path / "conflicts").iterdir()] == [theirs]
    assert any(recorded.trial_id(1) in message for message in done.conflicts)


@pytest.mark.parametrize("failed_here", [True, False])
def test_a_trial_that_failed_in_one_store_is_done_in_the_union(
    tmp_path: Path, failed_here: bool
) -> None:
    one, other = filled(tmp_path / "one", {1}), filled(tmp_path / "other", {1})
    (one if failed_here else other).commit(recorded.record(1, "FAILED"), None)
    done = merge(one, other)
    assert one.states() == {recorded.trial_id(1): "DONE"}
    assert (done.taken, done.shared, done.conflicts) == (int(failed_here), int(not failed_here), ())


def test_a_damaged_file_is_replaced_by_a_whole_one_and_never_taken(tmp_path: Path) -> None:
    one, other = filled(tmp_path / "one", {1, 2}), filled(tmp_path / "other", {1, 2})
    for store, number in ((one, 1), (other, 2)):
        path = store.file(recorded.trial_id(number))
        content = bytearray(path.read_bytes())
        columns = pq.read_metadata(path).row_group(0)
        column = columns.column(columns.num_columns // 4)  # amid them, where no reader looks
        # The last bytes of a column are numbers; some before them only describe them.
        content[column.data_page_offset + column.total_compressed_size - 4] ^= 1
        path.write_bytes(content)
    done = merge(one, other)
    assert (done.taken, len(done.refused)) == (1, 1)
    assert list(one.unsound()) == []


def test_lists_of_one_name_with_other_trials_are_both_kept(tmp_path: Path) -> None:
    one, other = filled(tmp_path / "one", {1, 2}), filled(tmp_path / "other", {2, 3})
    done = merge(one, other)
    names = list(one.experiments())
    assert names[0] == "sweep"
    assert len(names) == 2
    assert names[1] in done.conflicts[0]
    assert one.table("sweep")["seed"].tolist() == [1, 2]
    assert one.table(names[1])["seed"].tolist() == [2, 3]


@pytest.mark.parametrize("ours", [{1}, {1, 2, 3}])
def test_of_two_lists_of_which_one_holds_the_other_the_longer_stays(
    tmp_path: Path, ours: set[int]
) -> None:
    one, other = filled(tmp_path / "one", ours), filled(tmp_path / "other", {1, 2})
    assert merge(one, other).conflicts == ()
    assert list(one.experiments()) == ["sweep"]
    assert set(one.table("sweep")["seed"]) == ours | {1, 2}


def test_a_store_does_not_merge_with_itself_or_with_a_folder_that_is_none(tmp_path: Path) -> None:
    one = filled(tmp_path / "one", {1})
    with pytest.raises(UsageError, match="same store"):
        merge(one, one)
    with pytest.raises(UsageError, match="no store"):
        merge(one, Store(tmp_path / "nothing"))


def test_a_merge_into_nothing_is_a_copy(tmp_path: Path) -> None:
    other = filled(tmp_path / "other", {1, 2, 3})
    one = Store(tmp_path / "one")
    assert merge(one, other).taken == 3
    other.compact()
    for name in ("index.jsonl", "experiments/sweep/trials.jsonl"):
        assert (one.path / name).read_bytes() == (other.path / name).read_bytes()


def test_the_command_counts_and_names_conflicts(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    one, other = filled(tmp_path / "one", {1, 2}), filled(tmp_path / "other", {2, 3}, "second")
    assert run_command_line(["merge", str(one.path), str(other.path)]) == 0
    said = capsys.readouterr().out
    assert said == "1 trials taken, 1 were there, 0 conflicts, 0 files not taken\n"
    record = replace(recorded.record(3), metrics={"distance": 5.0})
    other.commit(record, recorded.log(8, seed=5))
    assert run_command_line(["merge", str(one.path), str(other.path)]) == 4
    assert f"conflict: trial {recorded.trial_id(3)}" in capsys.readouterr().err
