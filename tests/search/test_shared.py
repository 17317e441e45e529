"""Several coordinators, perhaps on several machines, that share one search by a real PostgreSQL."""

from __future__ import annotations

import os
import shutil
import signal
import socket
import subprocess
import tempfile
import time
from collections.abc import Iterator
from datetime import datetime, timedelta, timezone
from multiprocessing import get_context
from pathlib import Path

import pytest

from gaitlab.search.heartbeat import PREFIX, SILENCE, living, now, this_process
from gaitlab.store import Store
from tests.search import searches
from tests.search.searches import search, told

BINARIES = sorted(Path("/usr/lib/postgresql").glob("*/bin/initdb"))
SETTINGS = ("study.trials=12", "seeds=2", "study.racing=off")


def _as_somebody() -> dict[str, str]:
    """The server refuses to run as root."""
    return {"user": "nobody"} if os.geteuid() == 0 else {}


def _run(*command: object) -> None:
    words = [str(word) for word in command]
    subprocess.run(words, check=True, stdout=subprocess.DEVNULL, timeout=120, **_as_somebody())  # type: ignore[call-overload]


@pytest.fixture(scope="module")
def server() -> Iterator[str]:
    if not BINARIES:
        pytest.skip("no PostgreSQL is installed")
    binaries = BINARIES[-1].parent
    folder = Path(tempfile.mkdtemp(prefix="gaitlab-postgresql-"))
    if os.geteuid() == 0:
        shutil.chown(folder, "nobody")
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        port = found.getsockname()[1]
    data, options = folder / "data", f"-p {port} -k {folder} -c listen_addresses=127.0.0.1 -F"
    _run(binaries / "initdb", "-D", data, "-A", "trust", "-U", "robot", "-N")
    _run(binaries / "pg_ctl", "-D", data, "-o", options, "-l", folder / "log", "-w", "start")
    try:
        yield f"postgresql://robot@127.0.0.1:{port}/postgres"
    finally:
        _run(binaries / "pg_ctl", "-D", data, "-m", "immediate", "stop")
        shutil.rmtree(folder, ignore_errors=True)


def test_a_search_in_a_server_is_the_one_in_a_file(server: str, folder: Path) -> None:
    settings = (*SETTINGS, "name=alone")
    one, two = Store(folder / "one"), Store(folder / "two")
    search(one, *settings)
    search(two, *settings, storage=server)
    assert told(two, *settings, storage=server) == told(one, *settings)


def _share(place: Path, server: str) -> None:
    settings = (*SETTINGS, "name=shared")
    search(Store(place), *settings, storage=server, task=searches.pretend_slowly)
    os._exit(0)


def test_two_coordinators_share_the_candidates(server: str, folder: Path) -> None:
    places = [folder / name for name in ("here", "there")]
    processes = [get_context("fork").Process(target=_share, args=(p, server)) for p in places]
    for process in processes:
        process.start()
    for process in processes:
        process.join(timeout=120.0)
    found = told(Store(places[0]), *SETTINGS, "name=shared", storage=server)
    assert len(found) == 12
    assert len({tuple(sorted(candidate.values.items())) for candidate in found}) == 12
    walked = [len(Store(place).states()) for place in places]
    assert min(walked) > 0, "both have walked"


def test_what_a_killed_coordinator_left_is_taken_over(server: str, folder: Path) -> None:
    settings = (*SETTINGS, "name=shared_and_killed")
    killed = get_context("fork").Process(target=_left, args=(folder / "one", server, settings))
    killed.start()
    end = time.monotonic() + 60.0
    while not len(Store(folder / "one").states()) and time.monotonic() < end:
        time.sleep(0.02)
    assert killed.pid is not None
    os.kill(killed.pid, signal.SIGKILL)
    killed.join(30.0)
    search(Store(folder / "two"), *settings, storage=server)
    undisturbed = Store(folder / "three")
    search(undisturbed, *settings)
    assert told(Store(folder / "two"), *settings, storage=server) == told(undisturbed, *settings)


def _left(place: Path, server: str, settings: tuple[str, ...]) -> None:
    search(Store(place), *settings, storage=server, task=searches.pretend_slowly)


def test_a_coordinator_lives_while_its_process_does_or_signs() -> None:
    me = this_process()
    host = socket.gethostname()
    late = (datetime.now(timezone.utc) - 2 * SILENCE).isoformat()
    early = (datetime.now(timezone.utc) - timedelta(seconds=30)).isoformat()
    signs = {
        f"{PREFIX}{me}": late,
        f"{PREFIX}{host}:4194304:1": now(),
        f"{PREFIX}elsewhere:7:1": early,
        f"{PREFIX}nowhere:7:1": late,
        f"{PREFIX}ended:7:1": "",
        "something else": "entirely",
    }
    assert living(signs) == tuple(sorted((me, "elsewhere:7:1")))
