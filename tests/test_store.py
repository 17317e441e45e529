"""The store as a whole: what counts, what the tables say, who may write."""

from __future__ import annotations

import os
import re
import shutil
import signal
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from gaitlab.errors import StoreError, UnknownName, UsageError, WrongValue
from gaitlab.store import Store
from tests import recorded
from tests.reliability.drivers import line_of


@pytest.fixture
def store(tmp_path: Path) -> Store:
    return Store(tmp_path / "data")


def commit(store: Store, *numbers: int) -> None:
    for number in numbers:
        store.commit(recorded.record(number), recorded.log(seed=number))
        store.note(recorded.record(number))


def test_opening_and_reading_a_store_that_is_not_there_creates_nothing(store: Store) -> None:
    assert store.states() == {}
    assert store.experiments() == {}
    assert len(store.table()) == 0
    assert not store.path.exists()


def test_a_commit_without_a_note_counts(store: Store) -> None:
    store.commit(recorded.record(1), recorded.log())
    assert store.states() == {recorded.trial_id(1): "DONE"}


def test_a_note_without_its_file_does_not_count(store: Store) -> None:
    commit(store, 1, 2)
    store.file(recorded.trial_id(1)).unlink()
    assert list(store.states()) == [recorded.trial_id(2)]


def test_the_compacted_index_does_not_depend_on_order_or_on_interruptions(tmp_path: Path) -> None:
    one, other = Store(tmp_path / "one"), Store(tmp_path / "other")
    commit(one, *range(6))
    one.compact()
    commit(other, 3, 1)
    other.compact()
    commit(other, 0, 5, 5)
    for number in (2, 4):
        other.commit(recorded.record(number), recorded.log(seed=number))
    other.compact()
    assert (one.path / "index.jsonl").read_bytes() == (other.path / "index.jsonl").read_bytes()


def test_the_index_is_rebuilt_from_the_files_alone(store: Store) -> None:
    commit(store, *range(5))
    before = store.compact()
    index = store.path / "index.jsonl"
    content = index.read_bytes()
    index.write_bytes(content.replace(b'"DONE"', b'"FAILED"'))
    assert store.rebuild() == before
    assert index.read_bytes() == content


@pytest.mark.parametrize("cut", [1, 20, 200])
def test_a_torn_index_line_costs_nothing(store: Store, cut: int) -> None:
    commit(store, 1, 2)
    index = store.path / "index.jsonl"
    index.write_bytes(index.read_bytes()[:-cut])
    commit(store, 3)
    assert set(store.states()) == {recorded.trial_id(n) for n in (1, 2, 3)}
    assert len(index.read_bytes().splitlines()) == 3


def test_files_that_are_no_trials_are_named_and_break_nothing(store: Store) -> None:
    commit(store, 1)
    folder = store.path / "trials" / "ab"
    folder.mkdir(exist_ok=True)
    (folder / "notes.txt").write_text("mine")
    (folder / f"{'ab' * 16}.parquet").write_bytes(b"PAR1")
    (store.path / "trials" / "stray.parquet").write_bytes(b"")
    assert list(store.states()) == [recorded.trial_id(1)]
    assert {e.path.name for e in store.index().unreadable} == {
        "notes.txt",
        f"{'ab' * 16}.parquet",
        "stray.parquet",
    }
    assert store.query("SELECT count(*) AS n FROM ticks")["n"].tolist() == [40]


def test_what_a_killed_writer_left_is_swept_and_never_counted(store: Store) -> None:
    commit(store, 1)
    stale = store.file(recorded.trial_id(2)).with_suffix(".parquet.77.tmp")
    stale.parent.mkdir(exist_ok=True)
    stale.write_bytes(store.file(recorded.trial_id(1)).read_bytes())
    assert list(store.states()) == [recorded.trial_id(1)]
    assert store.index().unreadable == ()
    with store.writing("anything"):
        assert not stale.exists()


def test_two_experiments_share_a_trial_and_each_sees_its_own_rows(store: Store) -> None:
    commit(store, 1, 2, 3, 9)
    store.register(recorded.experiment("first"), recorded.planned(range(1, 3)))
    store.register(recorded.experiment("second"), recorded.planned(range(2, 5)))
    first, second = store.table("first"), store.table("second")
    assert first["seed"].tolist() == [1, 2]
    assert second["seed"].tolist() == [2, 3]
    everything = store.table()
    assert everything["experiment"].isna().sum() == 1
    assert len(everything) == 5
    shutil.rmtree(store.path / "experiments" / "second")
    assert store.table("first").equals(first)


def test_the_table_has_metrics_varied_parameters_and_gaps_of_the_right_type(store: Store) -> None:
    commit(store, 1, 2)
    store.commit(recorded.record(3, "INFEASIBLE"), None)
    store.register(recorded.experiment(), recorded.planned(range(1, 4), **{"robot.sole": "flat"}))
    table = store.table("sweep")
    assert table["state"].tolist() == ["DONE", "DONE", "INFEASIBLE"]
    assert table["gait.step_height"].tolist() == pytest.approx([0.01, 0.02, 0.03])
    assert table["robot.sole"].tolist() == ["flat"] * 3
    assert table["stable"].mean() == 0.5
    assert "wall_time" not in table


def test_outcomes_are_those_asked_for_whatever_else_the_store_holds(store: Store) -> None:
    commit(store, 1, 2)
    wanted = [recorded.trial_id(number) for number in (2, 1, 9, 2)]
    before = store.outcomes(wanted)
    assert before["trial_id"].tolist() == wanted[:2]
    assert before["seed"].tolist() == [2, 1]
    commit(store, 3)
    store.register(recorded.experiment(), recorded.planned(range(1, 4), **{"robot.sole": "flat"}))
    assert store.outcomes(wanted).equals(before)
    assert len(Store(store.path / "nothing").outcomes(wanted)) == 0


def test_an_experiment_that_was_never_run_is_said_so(store: Store) -> None:
    store.register(recorded.experiment("first"), recorded.planned(range(1)))
    with pytest.raises(UnknownName, match="there: first"):
        store.table("second")


@pytest.mark.parametrize("name", ["../x", "/x", "a/b", "", ".hidden", "x\0", "n" * 101, "a\n"])
def test_a_name_that_leaves_the_store_is_refused(store: Store, name: str) -> None:
    with pytest.raises(WrongValue, match="change `name:`"):
        store.register(recorded.experiment(name), [])
    assert not store.path.exists()


def test_a_damaged_list_of_trials_is_said_so_with_what_to_do(store: Store) -> None:
    store.register(recorded.experiment(), recorded.planned(range(3)))
    path = store.path / "experiments" / "sweep" / "trials.jsonl"
    path.write_bytes(path.read_bytes()[:-40])
    with pytest.raises(StoreError, match=r"`gaitlab run`.*writes the list anew"):
        store.table("sweep")


def test_sql_answers_over_trials_and_ticks(store: Store) -> None:
    commit(store, 0, 1, 2)
    store.register(recorded.experiment(), recorded.planned(range(3)))
    share = store.query("SELECT surface, avg(stable::int) AS share FROM trials GROUP BY 1")
    assert share["share"].tolist() == [pytest.approx(2 / 3)]
    joined = store.query(
        "SELECT seed, count(*) AS ticks FROM trials JOIN ticks USING (trial_id) GROUP BY ALL"
    )
    assert joined["ticks"].tolist() == [40, 40, 40]


@pytest.mark.parametrize(
    "sql", ["SELEC 1", "SELECT nothing FROM trials", "", "SELECT 1 FROM nowhere"]
)
def test_wrong_sql_is_a_usage_error(store: Store, sql: str) -> None:
    commit(store, 1)
    with pytest.raises(UsageError, match=r"query"):
        store.query(sql)


WRITING = [
    "COPY (SELECT 1 AS n) TO '{trial}'",
    "COPY (PIVOT trials ON seed USING count(*)) TO '{trial}'",
    "INSERT INTO trials BY NAME SELECT 'made' AS trial_id",
    "DELETE FROM trials",
    "CREATE TABLE made AS SELECT 1",
    "CREATE TEMP TABLE made AS SELECT 1",
    "CREATE TEMP TABLE made AS PIVOT trials ON seed USING count(*)",
    "DROP VIEW trials",
]


@pytest.mark.parametrize(
    "sql",
    [
        *WRITING,
        *(f"EXPLAIN {statement}" for statement in WRITING),
        *(f"/* EXPLAIN */ explain -- SELECT\n Analyze {statement};" for statement in WRITING),
        *(f"EXPLAIN (FORMAT json) {statement}" for statement in WRITING),
        "WITH made AS (COPY trials TO '{trial}') SELECT * FROM made",
        "EXPLAIN ANALYZE WITH made AS (COPY trials TO '{trial}') SELECT * FROM made",
        "WITH made AS (DELETE FROM trials RETURNING seed) SELECT * FROM made",
        "SELECT * FROM query($$COPY trials TO '{trial}'$$)",
        "ATTACH '{folder}/made.db'",
        "EXPORT DATABASE '{folder}/made'",
        "INSTALL httpfs",
        "SET threads = 1",
        "PRAGMA enable_profiling",
        "CALL enable_logging()",
        "SELECT 1; SELECT 2",
        "EXPLAIN SELECT 1; DROP VIEW trials",
        "SELECT * FROM read_csv('{folder}/secret.csv')",
        "SELECT * FROM '{folder}/secret.csv'",
        "SELECT * FROM ticks JOIN read_csv('{folder}/secret.csv') ON true",
        "SELECT * FROM ticks JOIN read_parquet('{trial}') ON true",
    ],
)
def test_a_query_can_neither_write_nor_read_beyond_the_views(
    store: Store, tmp_path: Path, sql: str
) -> None:
    commit(store, 1)
    (tmp_path / "secret.csv").write_text("word\nfriend\n")
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    with pytest.raises(UsageError, match=r"query"):
        store.query(sql.format(folder=tmp_path, trial=store.file(recorded.trial_id(1))))
    assert before == {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}


@pytest.mark.parametrize(
    "sql",
    [
        "-- how many?\nSELECT count(*) FROM trials;",
        "WITH one AS (SELECT 1) SELECT * FROM one",
        "FROM trials",
        "DESCRIBE trials",
        "PIVOT trials ON seed IN (1) USING count(*)",
        "PIVOT trials ON seed USING count(*) GROUP BY surface;",
        "SELECT * FROM (PIVOT trials ON seed USING count(*))",
        "EXPLAIN SELECT 1",
        "EXPLAIN /* why */ ANALYZE (SELECT 'ü')",
        "EXPLAIN (FORMAT json) FROM ticks",
    ],
)
def test_whatever_is_one_select_is_answered(store: Store, sql: str) -> None:
    commit(store, 1)
    assert len(store.query(sql))


def test_logs_of_different_robots_are_one_table_with_gaps(store: Store) -> None:
    commit(store, 1)
    store.commit(recorded.record(2), recorded.log(joints=("waist",)))
    ticks = store.query("SELECT * FROM ticks")
    assert ticks.columns[0] == "trial_id"
    for number, name, lacks in ((1, "left_knee_target", "waist"), (2, "waist_target", "left_knee")):
        rows = ticks[ticks["trial_id"] == recorded.trial_id(number)]
        log = store.log(recorded.trial_id(number))
        assert rows[name].to_numpy().tobytes() == log.arrays[name].tobytes()
        assert rows[f"{lacks}_target"].isna().all()


@pytest.fixture
def tabulated(store: Store, monkeypatch: pytest.MonkeyPatch) -> Store:
    """A store that counts as large and has its table beside it."""
    monkeypatch.setattr("gaitlab.store.store.TABLE_FROM", 0)
    commit(store, 0, 1, 2)
    store.commit(recorded.record(3, "INFEASIBLE"), None)
    store.register(recorded.experiment(), recorded.planned(range(4)))
    store.compact()
    store.tabulate()
    return store


SQL = "SELECT * FROM trials ORDER BY trial_id"


def test_a_query_answers_the_same_from_the_table_beside_a_store(tabulated: Store) -> None:
    from_file = tabulated.query(SQL)
    assert tabulated._table_file.fresh
    tabulated._table_file.remove()
    gathered = tabulated.query(SQL)
    assert from_file.equals(gathered)
    assert from_file.dtypes.equals(gathered.dtypes)


@pytest.mark.parametrize("change", ["commit", "remove", "list", "flip"])
def test_a_table_of_another_state_of_the_store_is_not_used(tabulated: Store, change: str) -> None:
    if change == "commit":
        commit(tabulated, 7)
    elif change == "remove":
        tabulated.file(recorded.trial_id(0)).unlink()
    elif change == "list":
        tabulated.register(recorded.experiment("more"), recorded.planned(range(2)))
    else:
        content = bytearray(tabulated._table_file.path.read_bytes())
        content[len(content) // 2] ^= 1
        tabulated._table_file.path.write_bytes(content)
    assert not tabulated._table_file.fresh
    count = {"commit": 5, "remove": 3, "list": 6, "flip": 4}[change]
    assert tabulated.query("SELECT count(*) AS n FROM trials")["n"].tolist() == [count]


def test_the_table_goes_along_with_a_copy_of_the_store(tabulated: Store, tmp_path: Path) -> None:
    shutil.copytree(tabulated.path, tmp_path / "copy", copy_function=shutil.copyfile)
    copy = Store(tmp_path / "copy")
    assert copy._table_file.fresh
    assert copy.query(SQL).equals(tabulated.query(SQL))


def test_compacting_a_store_in_order_writes_nothing(store: Store) -> None:
    commit(store, 1, 2, 3)
    store.compact()
    before = (store.path / "index.jsonl").stat().st_mtime_ns
    store.compact()
    assert (store.path / "index.jsonl").stat().st_mtime_ns == before


def test_a_store_that_is_replaced_while_it_is_held_is_noticed(store: Store, tmp_path: Path) -> None:
    with store.writing("one") as held:
        held.check()
        store.path.rename(tmp_path / "away")
        with pytest.raises(StoreError, match="vanished"):
            held.check()
        with store.writing("one"), pytest.raises(StoreError, match="vanished"):
            held.check()


HOLDER = """
import sys
from pathlib import Path
from gaitlab.store import Store
with Store(Path(sys.argv[1])).writing("sweep"):
    print("held", flush=True)
    sys.stdin.read()
"""


def hold(store: Store) -> subprocess.Popen[str]:
    process = subprocess.Popen(
        [sys.executable, "-c", HOLDER, str(store.path)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    assert line_of(process.stdout) == "held\n"
    return process


def test_a_second_run_is_refused_by_name_and_readers_are_not(store: Store) -> None:
    commit(store, 1)
    with hold(store) as process:
        named = f"host {re.escape(socket.gethostname())}, process {process.pid}, since 2"
        with pytest.raises(StoreError, match=named), store.writing("sweep"):
            pass
        with pytest.raises(StoreError, match=named), store.alone():
            pass
        with store.writing("another"):
            commit(store, 2)
        assert len(store.states()) == 2
        process.communicate("", timeout=60.0)
    with store.writing("sweep"), store.writing("another"):
        commit(store, 3)
    with store.alone():
        commit(store, 4)


def test_a_lock_dies_with_its_holder(store: Store) -> None:
    with hold(store) as process:
        os.kill(process.pid, signal.SIGKILL)
        process.wait(30.0)
    with store.writing("sweep"):
        pass


def test_a_copied_store_is_a_store(store: Store, tmp_path: Path) -> None:
    commit(store, 1, 2)
    store.register(recorded.experiment(), recorded.planned(range(1, 3)))
    with hold(store) as process:
        shutil.copytree(store.path, tmp_path / "copy")
        copy = Store(tmp_path / "copy")
        with copy.writing("sweep"):
            assert copy.table().equals(store.table())
        process.communicate("", timeout=60.0)
