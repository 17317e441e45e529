"""Settings of the whole test run."""

from __future__ import annotations

import os
import shutil
import tempfile
from pathlib import Path

import pytest
from hypothesis import settings

# No deadline: a busy machine is no failure. Derandomised: the same commit gives the same verdict.
settings.register_profile("gaitlab", deadline=None, derandomize=True)
settings.load_profile("gaitlab")

DISK = tempfile.gettempdir()
MEMORY = Path("/dev/shm")
ROOM = 1 << 30  # bytes; a container may have a few megabytes there


def _has_room() -> bool:
    """Whether files of tests may lie in memory, and programs among them be started."""
    if not os.access(MEMORY, os.W_OK) or shutil.disk_usage(MEMORY).free < ROOM:
        return False
    return not os.statvfs(MEMORY).f_flag & os.ST_NOEXEC


# A store waits for the disk at every trial, thousands of times in a test run.
if _has_room():
    tempfile.tempdir = str(MEMORY)


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
