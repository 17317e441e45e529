"""A SLURM of one node for the tests of a file."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.cluster.loopback_slurm import LoopbackSlurm, NoSlurm, loopback_slurm

CPUS = 2  # that the node pretends to have


@pytest.fixture(scope="module")
def slurm() -> Iterator[LoopbackSlurm]:
    folder = Path(tempfile.mkdtemp(prefix="gaitlab-slurm-"))
    try:
        with loopback_slurm(folder, cpus=CPUS) as running:
            yield running
    except NoSlurm as error:
        pytest.skip(str(error))
    finally:
        shutil.rmtree(folder, ignore_errors=True)
