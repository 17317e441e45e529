"""Settings of the whole test run."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Generator
from importlib.util import find_spec
from pathlib import Path

import pytest
from hypothesis import settings

from gaitlab.errors import NoEngine

# Threads of a matrix library that wait for each other on a busy machine take many times as long.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# No deadline: a busy machine is no failure. Derandomised: the same commit gives the same verdict.
settings.register_profile("gaitlab", deadline=None, derandomize=True)
settings.load_profile("gaitlab")

DISK = tempfile.gettempdir()
MEMORY = Path("/dev/shm")
BULLET = ("pybullet", "pybullet_utils")
ROOM = 1 << 30  # bytes; a container may have a few megabytes there
COMPILE_TIME = 300.0  # s for what takes half a minute on an idle machine
COMPILING = pytest.StashKey[subprocess.Popen[bytes]]()


def _has_room() -> bool:
    """Whether files of tests may lie in memory, and programs among them be started."""
    if not os.access(MEMORY, os.W_OK) or shutil.disk_usage(MEMORY).free < ROOM:
        return False
    return not os.statvfs(MEMORY).f_flag & os.ST_NOEXEC


# A store waits for the disk at every trial, thousands of times in a test run.
if _has_room():
    tempfile.tempdir = str(MEMORY)


# Where PyBullet is not installed, what asks for it is skipped and says so: a module or a test that
# imports it or walks in it, found by the error, and a test marked `bullet`, which hears otherwise.
NO_BULLET = (__file__, 1, "Skipped: PyBullet is not installed")


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report() -> Generator[None, pytest.CollectReport, pytest.CollectReport]:
    report = yield
    if report.failed and "ModuleNotFoundError: No module named 'pybullet" in str(report.longrepr):
        report.outcome, report.longrepr = "skipped", NO_BULLET
    return report


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    call: pytest.CallInfo[None],
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    report = yield
    error = call.excinfo.value if call.excinfo else None
    asks = isinstance(error, NoEngine) or getattr(error, "name", "") in BULLET
    if report.failed and asks and find_spec("pybullet") is None:
        report.outcome, report.longrepr = "skipped", NO_BULLET
    return report


def pytest_xdist_auto_num_workers() -> int:
    """Half as many again as there are processors: a third of the time tests wait for processes."""
    from gaitlab.running.cpu import processors

    return processors() * 3 // 2


def pytest_sessionstart(session: pytest.Session) -> None:
    """Compile once for all workers, while they collect."""
    config, quiet = session.config, subprocess.DEVNULL
    if (config.getoption("numprocesses", 0) or 0) > 1 and not hasattr(config, "workerinput"):
        command = [sys.executable, "-m", "tests.compiling"]
        config.stash[COMPILING] = subprocess.Popen(
            command, cwd=config.rootpath, stdout=quiet, stderr=quiet
        )


@pytest.hookimpl(tryfirst=True)
def pytest_runtestloop(session: pytest.Session) -> None:
    """Give out no test before that; what is wrong with it, the tests will tell."""
    if (compiling := session.config.stash.get(COMPILING, None)) is None:
        return
    try:
        compiling.wait(COMPILE_TIME)
    except subprocess.TimeoutExpired:
        compiling.kill()


def pytest_runtest_setup(item: pytest.Item) -> None:
    if item.get_closest_marker("bullet") and find_spec("pybullet") is None:
        pytest.skip("PyBullet is not installed")


@pytest.fixture(scope="session")
def swept_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder in which `gaitlab run tests/data/pretended.yaml` was given once; for copies."""
    from gaitlab.cli import run_command_line
    from tests.pretended import FILE, pretend_well

    folder = tmp_path_factory.mktemp("swept")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.setattr("gaitlab.running.processes.simulated", pretend_well)
        assert run_command_line(["run", str(FILE), "-j", "0", "--quiet"]) == 0
    return folder
