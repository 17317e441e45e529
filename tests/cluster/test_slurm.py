"""`gaitlab submit` on a real SLURM, of one node on loopback, whose node dies again and again."""

from __future__ import annotations

import random
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter
from pathlib import Path

import pytest

from gaitlab.cli import run_command_line
from gaitlab.errors import UsageError
from gaitlab.running.slurm import limit_seconds, output_in
from tests.cluster.loopback_slurm import (
    ROOT,
    LoopbackSlurm,
    marked,
)
from tests.reliability.drivers import line_of, until

DATA = ROOT / "tests" / "data"
SHARDS, TRIALS = 3, 80  # one more than the node has processors
DEATHS, BETWEEN = 3, (3, 10)  # and how many trials are committed from one to the next
LIMITS = (
    *("1", "90", "90:30", "1:30:00", "100:00:00", "1-12", "1-12:30", "1-12:30:59", "0-1"),
    *("0:30", "1:2:3:4", "x", "1:2:x", "1-1:1:1:1", "1.5", "1 2", "1-1-1"),
)
NAMES = ("plain", "a blank", "it's", 'quo"te', "ha#sh", "100%A", "$HOME", "ümläut", "semi;co")

# Notes every simulation by what came of it, so that nobody has to be believed about their number.
METRIC = """\
from hashlib import sha256
from pathlib import Path

from gaitlab.metrics import metric


@metric(unit="m", better="higher")
def noted(log) -> float:
    with Path(__file__).with_name("simulated").open("a") as file:
        file.write(sha256(log["trunk_z"].tobytes()).hexdigest() + "\\n")
    return float(log["trunk_z"].max())
"""


def gaitlab(slurm: LoopbackSlurm, folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    """A command, typed in a folder from which SLURM is reached."""
    path = {"PYTHONPATH": str(ROOT)}
    return subprocess.run(
        [sys.executable, "-m", "gaitlab", *words], env={**slurm.environment, **path}, cwd=folder,
        capture_output=True, text=True, timeout=400.0, check=False,
    )  # fmt: skip


def lab(folder: Path) -> Path:
    """A folder with an experiment that only stands, for an instant."""
    folder.mkdir()
    shutil.copy(DATA / "stand.py", folder)
    text = (DATA / "stand.yaml").read_text().replace("cycles: 0.6", "cycles: 0.6, time: 0.1")
    more = "metrics: [./noted.py]\nreport: {metrics: [noted]}\n"
    (folder / "stand.yaml").write_text(text + more)
    (folder / "noted.py").write_text(METRIC)
    return folder


class Watched:
    """Which file each trial of a store has had while somebody looked."""

    def __init__(self, store: Path) -> None:
        self.store, self.files = store, dict[str, set[tuple[int, int]]]()
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._look_often)

    def __enter__(self) -> Watched:
        self._thread.start()
        return self

    def __exit__(self, *error: object) -> None:
        self._over.set()
        self._thread.join(30.0)
        self._look()

    def wait_for(self, trials: int, seconds: float) -> None:
        """Wait for so many more trials."""
        wanted = len(self.files) + trials
        assert until(lambda: len(self.files) >= wanted, seconds), len(self.files)

    def _look_often(self) -> None:
        while not self._over.wait(0.1):
            self._look()

    def _look(self) -> None:
        for file in (self.store / "trials").glob("*/*.parquet"):
            found = file.stat()
            self.files.setdefault(file.stem, set()).add((found.st_ino, found.st_mtime_ns))


@pytest.mark.long
def test_a_node_that_dies_again_and_again_leaves_the_table_of_one_machine(
    slurm: LoopbackSlurm, tmp_path: Path
) -> None:
    chance = random.Random(17)
    form = ("stand.yaml", "--seeds", str(TRIALS))
    many, alone = lab(tmp_path / "many shards"), lab(tmp_path / "alone")
    submitted = gaitlab(slurm, many, "submit", *form, "--shards", str(SHARDS))
    assert submitted.returncode == 0, submitted.stderr
    array, last = submitted.stdout.split()

    killed = 0
    with Watched(many / "data") as watched:
        for _ in range(DEATHS):
            watched.wait_for(chance.randint(*BETWEEN), 200.0)
            time.sleep(chance.uniform(0.0, 0.5))
            killed += slurm.kill_node()
            slurm.start_node()
        slurm.wait_until_empty(400.0)
    printed = {file.name: file.read_text() for file in many.glob("data/experiments/*/slurm/*.out")}
    assert set(printed) == {*(f"{array}_{n}.out" for n in range(1, SHARDS + 1)), f"{last}_0.out"}
    assert killed >= DEATHS, "a node died with its jobs each time"
    assert slurm.states(array) == ["COMPLETED"] * SHARDS, printed
    assert slurm.states(last) == ["COMPLETED"], printed

    one_machine = gaitlab(slurm, alone, "run", *form, "-j", "2", "-q")
    assert one_machine.returncode == 0, one_machine.stderr
    assert table(slurm, many) == table(slurm, alone)
    once = Counter((alone / "simulated").read_text().split())
    often = Counter((many / "simulated").read_text().split())
    assert set(once.values()) == {1}
    assert len(once) == TRIALS
    assert often.keys() == once.keys()
    assert often.total() - TRIALS <= killed, "only what a dying job had begun is begun again"
    assert {len(files) for files in watched.files.values()} == {1}, "a trial is committed once"
    assert len(watched.files) == TRIALS

    assert [page.parent.name for page in many.glob("reports/*/README.md")] == [
        f"stand+seeds-{TRIALS}"
    ]
    status = gaitlab(slurm, many, "status", f"stand+seeds-{TRIALS}")
    assert status.stdout.count(" done ") == SHARDS + 1, "and the head of a column"


def table(slurm: LoopbackSlurm, folder: Path) -> str:
    done = gaitlab(slurm, folder, "query", "SELECT * FROM trials ORDER BY seed", "--format", "csv")
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_slurm_takes_the_script_as_it_is_printed(slurm: LoopbackSlurm, tmp_path: Path) -> None:
    given = ("--mem", "100M", "--partition", "main", "--sbatch", '--comment="a b"', "--cpus", "2")
    printed = gaitlab(slurm, lab(tmp_path / "a lab"), "submit", "stand.yaml", *given, "--dry-run")
    assert printed.returncode == 0, printed.stderr
    (tmp_path / "by hand.sh").write_text(printed.stdout)
    done = slurm.run("sbatch", "--test-only", str(tmp_path / "by hand.sh"))
    assert done.returncode == 0, done.stderr
    assert not slurm.queue()


def test_what_slurm_refuses_is_one_message_in_its_words(
    slurm: LoopbackSlurm,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("SLURM_CONF", slurm.environment["SLURM_CONF"])
    for more in ("--partition=nowhere", "--cpus=1000", "--sbatch=--no-such-option"):
        code = run_command_line(["submit", str(DATA / "pretended.yaml"), more])
        out, err = capfd.readouterr()
        assert (code, out) == (2, ""), more
        assert "sbatch refuses: " in err, more
        assert "Traceback" not in err
        assert not slurm.queue()


@pytest.mark.parametrize("limit", LIMITS)
def test_a_limit_of_time_is_to_us_what_it_is_to_slurm(slurm: LoopbackSlurm, limit: str) -> None:
    job = ["sbatch", "--parsable", "--hold", "--output=/dev/null", "--wrap=true"]
    done = slurm.run(*job, f"--time={limit}")
    if done.returncode:
        with pytest.raises(UsageError):
            limit_seconds(limit)
        return
    try:
        kept = slurm.run("squeue", "-h", "-j", done.stdout.strip(), "-o", "%l").stdout.strip()
        assert -(-limit_seconds(limit) // 60) * 60 == limit_seconds(kept)
    finally:
        slurm.run("scancel", done.stdout.strip())


def test_a_task_prints_into_the_store_whatever_its_folder_is_called(
    slurm: LoopbackSlurm, tmp_path: Path
) -> None:
    for name in NAMES:
        (tmp_path / name).mkdir()
        text = f"#!/bin/bash\n#SBATCH --array=1\n#SBATCH --output={output_in(tmp_path / name)}\n"
        (tmp_path / "job.sh").write_text(f"{text}echo here\n")
        assert slurm.run("sbatch", str(tmp_path / "job.sh")).returncode == 0, name
    slurm.wait_until_empty(60.0)
    for name in NAMES:
        assert [file.read_text() for file in (tmp_path / name).iterdir()] == ["here\n"], name


def test_no_daemon_outlives_the_tests_however_they_end(tmp_path: Path) -> None:
    begun = (
        "import sys, time; from pathlib import Path\n"
        "from tests.cluster.loopback_slurm import NoSlurm, loopback_slurm\n"
        "try:\n"
        "    with loopback_slurm(Path(sys.argv[1]), cpus=1):\n"
        "        print('up', flush=True); time.sleep(60)\n"
        "except NoSlurm: print('none', flush=True)\n"
    )
    folder = Path(tempfile.mkdtemp(prefix="gaitlab-slurm-"))
    mark = str(folder / "slurm.conf")
    command = [sys.executable, "-c", begun, str(folder)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=ROOT) as tests:
        assert tests.stdout is not None
        try:
            if line_of(tests.stdout) != "up\n":
                pytest.skip("SLURM is not installed")
            assert marked(mark)
        finally:
            tests.kill()
    assert until(lambda: not marked(mark))
    shutil.rmtree(folder)
