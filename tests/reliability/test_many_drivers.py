"""Many drivers on one store at once, and killed: nothing is refused, lost or simulated twice.

Trials are pretended (see `sweeps`): what is proven is how the drivers get along.
"""

from __future__ import annotations

import errno
import os
import random
import select
import signal
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from gaitlab.errors import StoreError
from gaitlab.store import Claims, Shard, Store
from gaitlab.store.durable import write_durably
from tests.reliability import sweeps
from tests.reliability.drivers import Drivers, drivers, until

ROUNDS, KILLS, SHARDS = 8, 20, 4
SEEDS = 3
FORM = f"pretended+seeds-{SEEDS}"
OTHERS = {  # settings, and the name that makes an experiment of its own of them
    "low": ("grid.gait.step_length=[0.0, 0.04]",),
    "high": ("grid.gait.step_length=[0.04, 0.08]",),
    "soft": ("surfaces=[grass_50mm]",),
    "hard": ("surfaces=[carpet_4mm, hard_floor]",),
}


@pytest.fixture(scope="module")
def gaitlab() -> Iterator[Drivers]:
    with drivers() as started:
        yield started


@pytest.fixture
def store(tmp_path: Path) -> Store:
    return Store(tmp_path / "data")


def whole(store: Store, *more: str, jobs: int = 0) -> tuple[str, ...]:
    place = ("--store", str(store.path), "--seeds", str(SEEDS), "-j", str(jobs))
    return ("run", str(sweeps.FILE), *place, *more)


def shard(store: Store, number: int, jobs: int = 0) -> tuple[str, ...]:
    return whole(store, "--shard", f"{number}/{SHARDS}", jobs=jobs)


def other(store: Store, name: str) -> tuple[str, ...]:
    return whole(store, *(word for setting in OTHERS[name] for word in ("--set", setting)))


def test_eight_drivers_at_once_refuse_lose_and_repeat_nothing(
    gaitlab: Drivers, tmp_path: Path
) -> None:
    """Four shards of one experiment, and four experiments that share trials with it."""
    undisturbed = Store(tmp_path / "undisturbed" / "data")
    assert gaitlab.run(*whole(undisturbed), task="pretend") == 0
    for name in OTHERS:
        assert gaitlab.run(*other(undisturbed, name), task="pretend") == 0
    wanted, files = sweeps.content(undisturbed, FORM), set(sweeps.logs(undisturbed))
    for number in range(ROUNDS):
        store = Store(tmp_path / str(number) / "data")
        commands = [shard(store, n) for n in range(1, SHARDS + 1)]
        commands += [other(store, name) for name in OTHERS]
        started = [gaitlab.start(*words, task="pretend") for words in commands]
        assert [gaitlab.wait(pid) for pid in started] == [0] * len(commands)
        assert set(sweeps.logs(store)) == files
        assert sweeps.simulated_more_than_once(store) == []
        assert gaitlab.run(*whole(store), task="pretend") == 0, "which puts the index in order"
        assert sweeps.content(store, FORM) == wanted
        assert store.table(FORM).equals(undisturbed.table(FORM))
        assert list(store.path.rglob("*.tmp")) == []


@pytest.mark.long
def test_shards_killed_at_random_instants_are_run_again_and_leave_no_trace(
    gaitlab: Drivers, store: Store, tmp_path: Path
) -> None:
    undisturbed = Store(tmp_path / "undisturbed" / "data")
    assert gaitlab.run(*whole(undisturbed)) == 0
    chance, kills = random.Random(17), 0
    running = {
        number: gaitlab.start(*shard(store, number, jobs=1)) for number in range(1, SHARDS + 1)
    }
    while kills < KILLS and running:
        time.sleep(chance.uniform(0.0, 0.3))
        number = chance.choice(list(running))
        os.kill(running[number], signal.SIGKILL)
        code = gaitlab.wait(running.pop(number))
        kills += code == -signal.SIGKILL
        if code != 0:
            running[number] = gaitlab.start(*shard(store, number, jobs=1))
    assert kills >= KILLS // 4
    assert [gaitlab.wait(pid) for pid in running.values()] == [0] * len(running)
    assert gaitlab.run(*whole(store)) == 0
    assert sweeps.content(store, FORM) == sweeps.content(undisturbed, FORM)
    assert sweeps.twice(store) == []
    assert list(store.path.rglob("*.tmp")) == []


def test_the_same_twice_is_refused_and_what_is_beside_it_is_not(
    gaitlab: Drivers, store: Store, tmp_path: Path
) -> None:
    pid = gaitlab.start(*shard(store, 1), task="held")
    assert until(lambda: sweeps.committed(store) >= 2)
    errors = tmp_path / "errors"
    for words in (shard(store, 1), whole(store)):
        assert gaitlab.run(*words, task="pretend", errors=errors) == 7
        assert f"process {pid}," in errors.read_text()
    with pytest.raises(StoreError, match=f"process {pid},"), store.alone():
        pass
    assert gaitlab.run(*shard(store, 2), task="pretend") == 0
    (tmp_path / "go").touch()
    assert gaitlab.wait(pid) == 0
    with store.alone():
        assert gaitlab.run(*shard(store, 3), task="pretend", errors=errors) == 7
    assert gaitlab.run(*whole(store), task="pretend") == 0
    assert sweeps.twice(store) == []


def test_a_claim_is_one_process_s_until_it_gives_it_up_or_dies(store: Store) -> None:
    store.path.mkdir()
    first, second = "0" * 31 + "1", "f" * 32
    reading, writing = os.pipe()
    pid = os.fork()
    if pid == 0:
        claims = Claims(store.path)
        os.write(writing, b"1" if claims.take(first) and claims.take(first) else b"0")
        time.sleep(120.0)  # it is killed long before
        os._exit(1)
    assert select.select([reading], [], [], 60.0)[0], "the other process says nothing"
    assert os.read(reading, 1) == b"1"
    mine = Claims(store.path)
    assert (mine.take(first), mine.take(second)) == (False, True)
    os.kill(pid, signal.SIGKILL)
    os.waitpid(pid, 0)  # at once, for it is killed
    assert mine.take(first)
    mine.close()
    for descriptor in (reading, writing):
        os.close(descriptor)


Rename = Callable[[Path, Path], None]


@pytest.mark.parametrize("number", [errno.ENOENT, errno.EEXIST, errno.ESTALE])
@pytest.mark.parametrize("worked", [True, False])
def test_a_rename_whose_answer_was_lost_is_looked_at(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: int, worked: bool
) -> None:
    """A server that is asked again says that there is no such file, or that there is one."""
    rename, asked = os.replace, list[Path]()

    def answered_wrongly(source: Path, target: Path) -> None:
        asked.append(target)
        if len(asked) > 1 or worked:
            rename(source, target)
        if len(asked) == 1:
            raise OSError(number, os.strerror(number))

    monkeypatch.setattr(os, "replace", answered_wrongly)
    monkeypatch.setattr("gaitlab.store.durable.BETWEEN_TRIES", 0.001)
    (tmp_path / "file").write_bytes(b"before")
    write_durably(tmp_path / "file", b"after", within=tmp_path)
    assert (tmp_path / "file").read_bytes() == b"after"
    assert os.listdir(tmp_path) == ["file"]
    assert len(asked) == (1 if worked else 2)


@pytest.mark.parametrize("number", [errno.ENOENT, errno.EIO, errno.ENOSYS, errno.EXDEV])
def test_a_rename_that_never_works_is_said_so_and_leaves_what_was_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: int
) -> None:
    def refused(source: Path, target: Path) -> None:
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(os, "replace", refused)
    monkeypatch.setattr("gaitlab.store.durable.BETWEEN_TRIES", 0.001)
    (tmp_path / "file").write_bytes(b"before")
    with pytest.raises(StoreError):
        write_durably(tmp_path / "file", b"after", within=tmp_path)
    assert (tmp_path / "file").read_bytes() == b"before"
    assert os.listdir(tmp_path) == ["file"]


def test_a_list_that_is_replaced_while_it_is_read_is_read_again(
    store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The server that keeps the old file for nobody says so by ESTALE."""
    sweeps.run(store, *sweeps.SMALL)
    before, opened, stale = store.table(sweeps.NAME), os.open, [3]

    def replaced(path: object, *rest: object, **named: object) -> int:
        if str(path).endswith(("trials.jsonl", "index.jsonl")) and stale[0]:
            stale[0] -= 1
            raise OSError(errno.ESTALE, os.strerror(errno.ESTALE))
        return opened(path, *rest, **named)  # type: ignore[arg-type]

    monkeypatch.setattr(os, "open", replaced)
    assert store.table(sweeps.NAME).equals(before)
    assert stale == [0]


def test_a_shard_is_in_no_ones_way_by_its_name(store: Store) -> None:
    """An experiment may be called like a shard's lock."""
    with (
        store.writing("walk", Shard.of("1/2")),
        store.writing("walk", Shard.of("2/2")),
        store.writing("1-of-2"),
        store.writing("whole"),
    ):
        pass
