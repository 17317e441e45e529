"""Processors that may be used, and what other processes do with them: by files, and for real."""

from __future__ import annotations

import math
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitlab.running import processors
from gaitlab.running.cpu import LOOK, WorkClock, quota
from tests import limited
from tests.reliability.drivers import line_of

ROOT = Path(__file__).parent.parent
COUNT = "from gaitlab.running.cpu import processors; print(processors())"

QUOTAS = st.one_of(st.none(), st.tuples(st.integers(1000, 10**6), st.integers(1000, 10**6)))


def limit(folder: Path, version: int, allowed: tuple[int, int] | None) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    share, period = allowed or ("max" if version == 2 else -1, 100_000)
    if version == 2:
        (folder / "cpu.max").write_text(f"{share} {period}\n")
    else:
        (folder / "cpu.cfs_quota_us").write_text(f"{share}\n")
        (folder / "cpu.cfs_period_us").write_text(f"{period}\n")


def describe(root: Path, version: int, own: str, top: str, point: str) -> None:
    """What the kernel tells a process of its own group and of the tree that is mounted."""
    (root / "proc/self").mkdir(parents=True)
    named = f"0::{own}" if version == 2 else f"3:cpuset:/other\n2:cpu,cpuacct:{own}"
    (root / "proc/self/cgroup").write_text(f"7:memory:/elsewhere\n{named}\n")
    kind = "cgroup2 cgroup2 rw" if version == 2 else "cgroup cgroup rw,cpu,cpuacct"
    lines = [
        "20 1 8:1 / / rw,relatime - ext4 /dev/root rw",
        "29 20 0:20 / /sys/fs/cgroup/memory rw - cgroup cgroup rw,memory",
        f"30 20 0:26 {top} {point} rw,nosuid shared:4 - {kind}",
    ]
    written = "\n".join(line.replace("tree of groups", r"tree\040of\040groups") for line in lines)
    (root / "proc/self/mountinfo").write_text(written + "\n")


@given(
    version=st.sampled_from([1, 2]),
    chain=st.lists(QUOTAS, min_size=1, max_size=4),
    mounted=st.integers(0, 3),
    beside=QUOTAS,
)
def test_the_least_quota_from_the_own_group_up_to_what_is_mounted_counts(
    version: int,
    chain: list[tuple[int, int] | None],
    mounted: int,
    beside: tuple[int, int] | None,
) -> None:
    """As the host sees it, and in a container that sees its own groups alone."""
    names = ["", *(f"level{number}" for number in range(1, len(chain)))]
    first = min(mounted, len(chain) - 1)
    point = "/sys/fs/tree of groups"
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        place = root / point.lstrip("/")
        for depth in range(first, len(chain)):
            limit(place.joinpath(*names[first + 1 : depth + 1]), version, chain[depth])
        limit(place / "somebody else", version, beside)
        own, top = ("/" + "/".join(names[1 : end + 1]) for end in (len(chain) - 1, first))
        describe(root, version, own, top, point)
        seen = [q / p for q, p in (both for both in chain[first:] if both)]
        assert quota(root) == pytest.approx(min(seen, default=math.inf))
        assert processors(root, {}) == max(1, min(cores(), math.ceil(quota(root) if seen else 999)))


def cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@pytest.mark.parametrize(("own", "top"), [("/", "/"), ("/../other", "/"), ("/a/b", "/a/b/c")])
@pytest.mark.parametrize("version", [1, 2])
def test_a_group_that_is_not_mounted_is_looked_for_at_the_top(
    tmp_path: Path, version: int, own: str, top: str
) -> None:
    describe(tmp_path, version, own, top, "/sys/fs/cgroup/cpu")
    limit(tmp_path / "sys/fs/cgroup/cpu", version, (150_000, 100_000))
    assert quota(tmp_path) == 1.5


@pytest.mark.parametrize("text", ["", "max", "100000", "x y", "0 0", "\0", "-1 100000", "1e3 "])
def test_what_no_kernel_writes_limits_nothing(tmp_path: Path, text: str) -> None:
    describe(tmp_path, 2, "/", "/", "/sys/fs/cgroup")
    (tmp_path / "sys/fs/cgroup").mkdir(parents=True)
    (tmp_path / "sys/fs/cgroup/cpu.max").write_text(text)
    assert quota(tmp_path) == math.inf
    (tmp_path / "proc/self/mountinfo").write_text(f"{text}\n1 2 - \n - cgroup2\n")
    (tmp_path / "proc/self/cgroup").write_text(f"{text}\n::\n")
    assert quota(tmp_path) == math.inf


def test_slurm_gives_fewer_and_never_more(tmp_path: Path) -> None:
    assert processors(tmp_path, {"SLURM_CPUS_PER_TASK": "1"}) == 1
    for text in ("100000", "0", "", "-3", "2(x3)", "many", "\u0663"):
        assert processors(tmp_path, {"SLURM_CPUS_PER_TASK": text}) == cores()


def counted(**how: object) -> int:
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        [sys.executable, "-c", COUNT], env=environment, capture_output=True, text=True,
        check=True, timeout=120, **how,  # type: ignore[call-overload]
    )  # fmt: skip
    return int(done.stdout)


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="no masks on this system")
def test_a_mask_of_one_core_is_one_processor() -> None:
    core = min(os.sched_getaffinity(0))
    assert counted(preexec_fn=lambda: os.sched_setaffinity(0, {core})) == 1


def test_a_real_group_limits_and_so_does_the_one_above_it() -> None:
    with limited.group(0.5) as above, limited.group(None, within=above) as group:
        assert counted(preexec_fn=limited.entering(above)) == 1
        assert counted(preexec_fn=limited.entering(group)) == 1
    with limited.group(1.2) as group:
        assert counted(preexec_fn=limited.entering(group)) == min(2, cores())


@contextmanager
def process(code: str) -> Iterator[int]:
    """A Python that does this, once it does it."""
    command = [sys.executable, "-S", "-c", f"import time\nprint(flush=True)\n{code}"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as started:
        assert started.stdout is not None
        try:
            line_of(started.stdout)
            yield started.pid
        finally:
            started.kill()


def watched(pid: int, seconds: float, looks: int = 20) -> WorkClock:
    clock = WorkClock(pid)
    for _ in range(looks):
        time.sleep(seconds / looks)
        clock.look()
    return clock


linux = pytest.mark.skipif(sys.platform != "linux", reason="only Linux tells what others do")
SPIN, SLEEP, POLL = "while 1: pass", "time.sleep(99)", "while 1: time.sleep(0.01)"


@linux
@pytest.mark.parametrize("code", [SLEEP, POLL])
def test_who_sleeps_does_nothing(code: str) -> None:
    with process(code) as pid:
        clock = watched(pid, 1.0)
    assert clock.worked < 0.2 < 0.5 < clock.idle


@linux
def test_who_is_stopped_does_nothing_and_who_goes_on_works() -> None:
    with process(SPIN) as pid:
        os.kill(pid, signal.SIGSTOP)
        time.sleep(0.1)
        stopped = watched(pid, 1.0)
        os.kill(pid, signal.SIGCONT)
        clock = WorkClock(pid)
        end = time.monotonic() + 60.0
        while clock.worked < 1.5 and time.monotonic() < end:
            time.sleep(0.1)
            clock.look()
    assert stopped.worked < 0.1 < 0.5 < stopped.idle
    assert clock.worked >= 1.5
    assert clock.idle < 0.5


@linux
@pytest.mark.parametrize("looks", [1, 4, 100])
def test_who_gets_little_of_a_processor_waits(looks: int) -> None:
    """The kernel gives no less than a hundredth, which three share."""
    with (
        limited.group(0.01) as group,
        process(SPIN) as pid,
        process(SPIN) as second,
        process(SPIN) as third,
    ):
        for spinning in (pid, second, third):
            limited.put(group, spinning)
        clock = watched(pid, 4.0, looks)
    assert clock.worked < 1.0
    assert clock.idle < 1.0 + clock.worked


@linux
def test_time_in_which_nobody_looked_is_not_held_against_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    with process(SLEEP) as pid:
        clock = WorkClock(pid)
        later = time.monotonic() + 3600.0
        monkeypatch.setattr(time, "monotonic", lambda: later)
        clock.look()
    assert clock.idle <= 2.0 * LOOK
