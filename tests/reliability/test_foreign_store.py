"""A store that somebody else made: what is wrong in it is named, and the rest goes on."""

from __future__ import annotations

import hashlib
import json
import os
import re
import shutil
import signal
import zlib
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from gaitlab.cli import run_command_line
from gaitlab.errors import StoreError, UnknownName, WrongValue
from gaitlab.experiment.named_code import named_code, unnamed_code
from gaitlab.report.gather import gather
from gaitlab.simulation.trial import Trial
from gaitlab.store import Store, TrialRecord, parquet
from gaitlab.store.record import canonical
from tests import recorded
from tests.reliability import sweeps
from tests.trials import trial

TRIALS, SECONDS = 8, 60
HERE = "<here>"  # stands in JSON where something else is put
COUNT = "SELECT count(*) AS n FROM trials"


@pytest.fixture(scope="module")
def swept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A sweep of eight trials, and beside it one of more seeds."""
    folder = tmp_path_factory.mktemp("swept")
    sweeps.run(Store(folder / "data"), *sweeps.SMALL)
    sweeps.run(Store(folder / "other"), *sweeps.SMALL, seeds=2)
    return folder


@pytest.fixture
def store(tmp_path: Path, swept: Path) -> Store:
    shutil.copytree(swept, tmp_path, dirs_exist_ok=True)
    return Store(tmp_path / "data")


class Late(BaseException):
    """Nobody takes it for a mistake of a file."""


@pytest.fixture(autouse=True)
def _in_time() -> Iterator[None]:
    """No file of a store keeps anybody waiting."""

    def late(*_: object) -> None:
        raise Late

    before = signal.signal(signal.SIGALRM, late)
    signal.alarm(SECONDS)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


def first(store: Store) -> str:
    return min(store.states())


def tree(folder: Path) -> dict[Path, bytes]:
    return {path: path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


def moved_behind_a_link(path: Path, outside: Path) -> None:
    """Put what is there elsewhere and a link to it in its place."""
    outside.mkdir(exist_ok=True)
    path.parent.mkdir(parents=True, exist_ok=True)
    if not path.exists():
        path.touch()
    target = outside / path.name
    path.rename(target)
    path.symlink_to(target)


WRITES: dict[str, Callable[[Store], object]] = {
    "run": lambda store: sweeps.run(store, *sweeps.SMALL),
    "verify": lambda store: run_command_line(
        ["verify", "--repair", "--sample", "0", "--store", str(store.path)]
    ),
    "rebuild": lambda store: run_command_line(["status", "--rebuild", "--store", str(store.path)]),
    "merge": lambda store: run_command_line(
        ["merge", str(store.path), str(store.path.parent / "other")]
    ),
}


@pytest.mark.parametrize(
    "linked",
    [
        *(
            "lock",
            "locks",
            "claims",
            "index.jsonl",
            "trials",
            "trials/{ab}",
            "trials/{ab}/{trial}.parquet",
        ),
        *("experiments", "experiments/pretended", "experiments/pretended/trials.jsonl"),
        *("experiments/pretended/experiment.yaml", "aside", "conflicts", "table.stamp"),
    ],
)
def test_nothing_is_written_through_a_link(store: Store, tmp_path: Path, linked: str) -> None:
    trial_id = first(store)
    link = store.path / linked.format(ab=trial_id[:2], trial=trial_id)
    if linked in ("aside", "conflicts"):
        link.mkdir()
        store.file(trial_id).write_bytes(b"torn")
    moved_behind_a_link(link, tmp_path / "outside")
    before = tree(tmp_path / "outside")
    for name, write in WRITES.items():
        with suppress(StoreError):
            assert write(store) != 1, "no traceback"
        assert tree(tmp_path / "outside") == before, name


def test_the_database_of_a_search_is_not_opened_behind_a_link(tmp_path: Path) -> None:
    from gaitlab.search.storage import database_file, file_storage

    file = database_file(Store(tmp_path / "data"), "search")
    for link in (file, file.with_name(f"{file.name}-journal"), file.parent):
        moved_behind_a_link(link, tmp_path / "outside")
        before = tree(tmp_path / "outside")
        with pytest.raises(StoreError, match="link"):
            file_storage(file)
        assert tree(tmp_path / "outside") == before
        link.unlink()


def test_a_lock_that_gaitlab_did_not_write_is_left_as_it_is(store: Store) -> None:
    lock = store.path / "lock"
    lock.unlink()
    (store.path.parent / "mine").write_text("precious")
    os.link(store.path.parent / "mine", lock)
    assert run_command_line(["status", "--rebuild", "--store", str(store.path)]) == 7
    assert lock.read_text() == "precious"


def endless(path: Path) -> None:
    path.symlink_to("/dev/zero")


def sparse(path: Path) -> None:
    with path.open("wb") as file:
        file.truncate(1 << 42)


@pytest.mark.parametrize("make", [os.mkfifo, endless, sparse, Path.mkdir])
@pytest.mark.parametrize(
    "place", ["index.jsonl", "table.stamp", "experiments/pretended/trials.jsonl", "trial"]
)
def test_a_file_that_never_ends_costs_that_file_alone(
    store: Store, place: str, make: Callable[[Path], None], capsys: pytest.CaptureFixture[str]
) -> None:
    path = store.file(first(store)) if place == "trial" else store.path / place
    path.unlink(missing_ok=True)
    make(path)
    where = ["--store", str(store.path)]
    assert run_command_line(["query", COUNT, "--format", "csv", *where]) == 0
    counted = TRIALS - (place == "trial")
    assert capsys.readouterr().out.split() == ["n", str(counted)]
    assert run_command_line(["status", *where]) == 0
    derived = place in ("index.jsonl", "table.stamp")
    assert (str(path) in capsys.readouterr().err) != derived


def sealed(record: TrialRecord, log: Any = None, **changed: object) -> bytes:
    """A file whose seal is right, whatever stands in it."""
    return parquet.encode(replace(record, **changed), log)


def with_header(**changed: object) -> bytes:
    class Other:
        header = recorded.log().header
        arrays = recorded.log().arrays

    log, content = Other(), {**recorded.header().to_dict(), **changed}
    log.header = type("Header", (), {"joints": recorded.JOINTS, "to_dict": lambda self: content})()
    return parquet.encode(recorded.record(1), log)  # type: ignore[arg-type]


def with_columns(table: pa.Table) -> bytes:
    """The record and seal of a trial over other columns."""
    whole = pq.read_table(pa.BufferReader(parquet.encode(recorded.record(1), recorded.log())))
    return parquet._parquet(table.replace_schema_metadata(whole.schema.metadata))


TRIAL = recorded.record(1).trial
RECORDS = {
    "no names": lambda: sealed(recorded.record(1), trial={**TRIAL, "names": None}),
    "nested names": lambda: sealed(recorded.record(1), trial={**TRIAL, "names": {"robot": [1]}}),
    "a list as trial": lambda: sealed(recorded.record(1), trial=[1]),
    "a list as seed": lambda: sealed(recorded.record(1), trial={**TRIAL, "seed": [1]}),
    "no horizon": lambda: sealed(recorded.record(1), trial={**TRIAL, "horizon": None}),
    "a list as metric": lambda: sealed(recorded.record(1), metrics={"distance": [1.0]}),
    "a great number": lambda: sealed(recorded.record(1), metrics={"distance": 10**30}),
    "a list as provenance": lambda: sealed(recorded.record(1), provenance={"host": ["lab"]}),
    "another state": lambda: sealed(recorded.record(1), state="GREAT"),
    "no reason": lambda: sealed(recorded.record(1), reason=None),
}
LOGS = {
    "no joints": lambda: with_header(joints=None),
    "one joint": lambda: with_header(joints="left_knee"),
    "text as time step": lambda: with_header(dt="fast"),
    "numbers as a number": lambda: with_header(mass=[1.0, 2.0]),
    "a column more": lambda: with_columns(pa.table({**recorded.log().arrays, "mine": [0] * 40})),
    "a column of text": lambda: with_columns(
        pa.table({**recorded.log().arrays, "roll": ["0"] * 40})
    ),
    "rows without end": lambda: with_columns(pa.table({"time": np.zeros(30_000_000, np.float32)})),
}


@pytest.mark.parametrize("lies", [RECORDS, LOGS], ids=["records", "logs"])
def test_what_is_sealed_but_wrong_is_damage_of_that_file(
    store: Store, lies: dict[str, Callable[[], bytes]]
) -> None:
    path = store.file(recorded.trial_id(1))
    path.parent.mkdir(exist_ok=True)
    for lie, content in lies.items():
        path.write_bytes(content())
        assert [(error.path, error.kind) for error in store.unsound()] == [(path, "damaged")], lie
        told: list[Exception] = []
        counted = store.query(COUNT, told.append)["n"].item()
        assert (counted, len(told)) == ((TRIALS, 1) if lies is RECORDS else (TRIALS + 1, 0)), lie
    where = ["--sample", "0", "--store", str(store.path)]
    assert run_command_line(["verify", "--repair", *where]) == 4
    assert not path.exists()
    assert run_command_line(["verify", *where]) == 0


DEEP = "[" * 100_000
KINDS = [
    *map(canonical, (None, 1, "text", [], [[]], {"labels": []}, {"labels": [], "metrics": 1})),
    DEEP,
]


def test_an_index_of_another_kind_of_json_is_put_right_from_the_trials(store: Store) -> None:
    index = store.path / "index.jsonl"
    right, whole = store.table(), index.read_bytes().splitlines()
    for kind in KINDS:
        lines = []
        for line in whole:
            head = line[len('{"crc":"00000000",') : line.index(b'"details":') + len('"details":')]
            rest = head + kind.encode() + b"}"
            lines.append(b'{"crc":"%08x",%b\n' % (zlib.crc32(rest), rest))
        index.write_bytes(b"".join(lines))
        assert store.table().equals(right), kind[:20]


@pytest.mark.parametrize("where", ["head", "line", "values", "basis", "seed", "trial_id"])
def test_a_list_of_another_kind_of_json_is_damage_of_that_list(store: Store, where: str) -> None:
    path = store.path / "experiments" / sweeps.NAME / "trials.jsonl"
    head, *lines = path.read_text().splitlines()
    for kind in KINDS:
        if kind == {"seed": "1", "trial_id": canonical("text")}.get(where):
            continue  # of the right kind
        changed, rest = dict(json.loads(head)), [json.loads(line) for line in lines]
        if where in ("values", "seed", "trial_id"):
            rest[0][where] = HERE
        if where == "basis":
            changed["basis"] = HERE
        text = "".join(f"{canonical(line)}\n" for line in rest).replace(canonical(HERE), kind)
        text = f"{kind}\n" if where == "line" else text
        sha256 = hashlib.sha256(text.encode()).hexdigest()
        changed |= {"trials": text.count("\n"), "sha256": sha256}
        first = canonical(changed).replace(canonical(HERE), kind)
        path.write_text(f"{kind if where == 'head' else first}\n{text}")
        told: list[Exception] = []
        found = store.query(
            "SELECT count(*) AS n, count(experiment) AS listed FROM trials", told.append
        )
        if where == "seed" and kind == "null":
            assert not told
            continue
        assert [str(error).partition(":")[0] for error in told] == [str(path)], kind[:20]
        assert found.to_dict("records") == [{"n": TRIALS, "listed": 0}]
    assert run_command_line(["status", sweeps.NAME, "--store", str(store.path)]) == 7
    assert sweeps.run(store, *sweeps.SMALL).cached == TRIALS
    assert len(store.table(sweeps.NAME)) == TRIALS


def gait_of(code: Path, data: dict[str, Any]) -> dict[str, Any]:
    digest = hashlib.sha256(code.read_bytes()).hexdigest()
    own = {"code": {"name": str(code), "digest": digest}, "values": {}}
    return {**data, "gait": own, "names": {**data["names"], "gait": code.stem}}


CODE = """
from pathlib import Path
Path({ran!r}).touch()
from gaitlab.gaits.stand import Gait
"""


@pytest.fixture
def coded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> tuple[Store, Path, Path]:
    """A store with one trial of a gait of somebody's own, that gait, and what it makes when run."""
    code, ran, store = tmp_path / "foreign" / "evil.py", tmp_path / "ran", Store(tmp_path / "data")
    code.parent.mkdir()
    code.write_text(CODE.format(ran=str(ran)))
    walking = trial("hard_floor", cycles=0.5)
    log = recorded.log(joints=tuple(joint.name for joint in walking.robot.tree.joints))
    given = gait_of(code, walking.to_dict())
    store.commit(replace(recorded.record(1), trial=given), log)
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    return store, code, ran


COMMANDS = [
    ["verify", "--sample", "1", "-j", "0"],
    ["export", "{trial}", "--output", "walk.csv"],
    ["export", "{trial}", "--to", "mjcf-urdf"],
    ["replay", "{trial}", "--output", "walk.png", "-j", "0"],
]


@pytest.mark.parametrize("words", COMMANDS, ids=lambda words: " ".join(words[:4]))
def test_code_that_the_store_alone_names_runs_only_when_it_is_allowed(
    coded: tuple[Store, Path, Path], words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    store, code, ran = coded
    trial_id = next(iter(store.states()))
    call = [word.format(trial=trial_id) for word in words] + ["--store", str(store.path)]
    code_before = run_command_line(call)
    told = capsys.readouterr().err
    assert code_before == (0 if words[0] == "verify" else 3)
    assert str(code) in told
    assert "--allow-code" in told
    assert not ran.exists()
    run_command_line([*call, "--allow-code"])
    assert str(code) in capsys.readouterr().err
    assert ran.exists()


def test_code_that_an_experiment_file_here_names_with_the_same_text_is_the_user_s(
    coded: tuple[Store, Path, Path],
) -> None:
    store, code, ran = coded
    names = partial(unnamed_code, store.record(next(iter(store.states()))).trial)
    assert names(named_code(store.path)) == [str(code)]
    Path("experiments").mkdir()
    mine = Path("experiments/mine.yaml")
    for text in (
        "gait: {type: ../../foreign/evil.py}",
        "walkers:\n  - {gait: ../../foreign/evil.py}",
    ):
        mine.write_text(text)
        assert names(named_code(store.path)) == []
    assert names(named_code(Path("experiments"))) == [str(code)], "the store names nothing itself"
    code.write_text(code.read_text() + "\n")
    assert names(named_code(store.path)) == [str(code)], "another text is other code"
    assert not ran.exists(), "looking runs nothing"


def test_a_report_runs_no_code_but_that_of_its_experiments(
    coded: tuple[Store, Path, Path], swept: Path
) -> None:
    foreign, code, ran = coded
    store = Store(foreign.path.parent / "swept")
    shutil.copytree(swept / "data", store.path)
    trial_id = first(store)
    other = foreign.record(first(foreign))
    store.commit(replace(other, trial_id=trial_id), recorded.log())
    results = gather([sweeps.experiment(*sweeps.SMALL)], store)
    with pytest.raises(WrongValue, match=re.escape(str(code))):
        results.trial(trial_id)
    assert not ran.exists()


@pytest.mark.parametrize("kind", [None, [1], {"code": None}, {"code": {"digest": 1}}, "text"])
def test_a_record_that_makes_no_trial_is_said_so(kind: object) -> None:
    data = trial("hard_floor").to_dict()
    for name in data.keys() - {"physics_version"}:
        with pytest.raises((WrongValue, UnknownName)):
            Trial.from_dict({**data, name: kind})
