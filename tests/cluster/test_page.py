"""The page on many machines, typed as it stands, on a real SLURM of one node."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.cluster.loopback_slurm import ROOT, LoopbackSlurm
from tests.test_docs import TINY, blocks

PAGE = ROOT / "docs" / "clusters.md"


@pytest.mark.long
def test_every_command_of_the_page_works_in_its_order(slurm: LoopbackSlurm, tmp_path: Path) -> None:
    (tmp_path / "experiments").mkdir()
    shipped = ROOT / "experiments" / "eros_quick.yaml"
    (tmp_path / "experiments" / "eros_quick.yaml").write_text(TINY.format(shipped=shipped))
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    environment = {**slurm.environment, "PATH": path, "PYTHONPATH": str(ROOT)}
    lines = [
        line
        for line in "".join(blocks(PAGE, "sh")).splitlines()
        if "parallel" not in line or shutil.which("parallel")
    ]
    assert sum("submit" in line for line in lines) >= 2
    for line in lines:
        done = subprocess.run(
            ["bash", "-c", line], cwd=tmp_path, env=environment, check=False,
            capture_output=True, text=True, timeout=300.0,
        )  # fmt: skip
        assert done.returncode == 0, f"{line}\n{done.stdout}\n{done.stderr}"
        if "submit" in line and "--dry-run" not in line:
            slurm.wait_until_empty(300.0)
    assert (tmp_path / "reports" / "eros_quick" / "README.md").exists()
