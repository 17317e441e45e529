"""`import gaitlab`: what a notebook gets is what the command line says, and it says it in types."""

from __future__ import annotations

import json
import os
import pty
import re
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest

import gaitlab
from gaitlab.cli import run_command_line
from gaitlab.errors import GaitlabError, NothingRun, UnknownName, UsageError, WrongValue
from gaitlab.metrics import lookup, numeric_names
from gaitlab.store import Store
from tests import pretended
from tests.test_docs import TINY

ROOT = Path(__file__).parent.parent
SHIPPED = ROOT / "experiments" / "eros_quick.yaml"
USER_SCRIPT = """\
import gaitlab

loaded = gaitlab.load("eros_quick", set={"gait.step_height": 0.02}, seeds=2)
summary = loaded.run(jobs=2)
done: int = summary.done
mean = loaded.trials()["distance"].mean()
trial = loaded.simulate({"surface": "grass_50mm"}, seed=1)
state: str = trial.state
page = loaded.report(format="html")
name: str = page.name
ticks = gaitlab.open_store("data").ticks("eros_quick/worst")
"""


@pytest.fixture(scope="module")
def walked(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder in which a tiny experiment was run from Python, in MuJoCo, by two workers."""
    folder = tmp_path_factory.mktemp("walked")
    tiny = folder / "tiny.yaml"
    text = TINY.format(shipped=SHIPPED).replace("name: eros_quick", "name: tiny")
    tiny.write_text(f"{text}engine: {{name: mujoco}}\n")
    summary = gaitlab.load(tiny).run(folder / "data", jobs=0)
    assert (summary.done, summary.failed) == (2 * 2, 0)
    return folder


@pytest.fixture
def tiny(walked: Path, monkeypatch: pytest.MonkeyPatch) -> gaitlab.LoadedExperiment:
    """That experiment, its store being the one that is taken when none is named."""
    monkeypatch.chdir(walked)
    return gaitlab.load("./tiny.yaml")


def test_the_table_is_that_of_the_command_line(
    tiny: gaitlab.LoadedExperiment, capsys: pytest.CaptureFixture[str]
) -> None:
    table = tiny.trials()
    assert run_command_line(["query", "--format", "json", "SELECT * FROM trials"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert [row["trial_id"] for row in printed] == list(table["trial_id"])
    for name in table.columns:
        for ours, theirs in zip(table[name], (row[name] for row in printed), strict=True):
            assert (pd.isna(ours) and theirs is None) or ours == theirs, name
    pd.testing.assert_frame_equal(table, gaitlab.open_store("data").trials(), check_like=True)


def test_every_number_of_the_table_has_its_unit_and_is_a_number(
    tiny: gaitlab.LoadedExperiment, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("gaitlab.metrics._own", {})  # of tests before this one
    table = tiny.trials()
    units = table.attrs["units"]
    assert {name: units[name] for name in numeric_names()} == {
        name: lookup(name).unit for name in numeric_names()
    }
    assert units["gait.step_length"] == "m"
    assert gaitlab.open_store().trials().attrs["units"] == units
    for name in numeric_names():
        assert table[name].dtype.kind in "fi", name
        assert np.isfinite(table[name].dropna().astype(float)).all()


def test_missing_numbers_are_nan_even_where_all_are_missing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("gaitlab.running.processes.simulated", pretended.pretend)
    loaded = gaitlab.load(pretended.FILE, seeds=1)
    loaded.run(tmp_path, jobs=1)
    table = loaded.trials(tmp_path)
    infeasible = table[table["state"] != "DONE"]
    assert len(infeasible)
    assert infeasible["distance"].isna().all()
    assert table["distance"].dtype == "float64"


def test_the_ticks_are_those_of_the_file(tiny: gaitlab.LoadedExperiment) -> None:
    store = Store(Path("data"))
    for trial_id in tiny.trials()["trial_id"]:
        ticks = tiny.ticks(trial_id)
        stored = pq.read_table(store.file(trial_id)).to_pandas()
        pd.testing.assert_frame_equal(ticks, stored)
        assert set(ticks.attrs["units"]) == set(ticks.columns)
    last = tiny.trials().iloc[-1]
    named = tiny.ticks(f"tiny/{last['surface']}/gait.heel_strike={last['gait.heel_strike']}/0")
    pd.testing.assert_frame_equal(named, tiny.ticks(last["trial_id"][:10]))


def test_what_is_simulated_in_memory_has_the_bits_of_the_stored_trial(
    tiny: gaitlab.LoadedExperiment,
) -> None:
    table, cells = tiny.trials(), tiny.cells
    for index, row in enumerate(table.itertuples(index=False)):
        trial = tiny.simulate(index, seed=row.seed)
        assert trial.id == row.trial_id
        pd.testing.assert_frame_equal(trial.ticks, tiny.ticks(trial.id))
        stored = Store(Path("data")).record(trial.id)
        np.testing.assert_equal(
            {name: value for name, value in trial.metrics.items() if value == value},
            {name: value for name, value in stored.metrics.items() if value is not None}
            | {name: None for name, value in trial.metrics.items() if value is None},
        )
        assert tiny.simulate(cells.loc[index], seed=row.seed).id == trial.id


def test_a_setting_is_the_one_of_the_command_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    given = {
        "gait.step_height": np.float64(0.02),
        "horizon": {"cycles": 1, "time": 5.0},
        "surfaces": ["grass_30mm", "carpet_4mm"],
        "gait.x_law": "quarter",
        "spread.friction": 1e-7,
    }
    texts = [
        "gait.step_height=0.02",
        "horizon={cycles: 1, time: 5.0}",
        "surfaces=[grass_30mm, carpet_4mm]",
        "gait.x_law=quarter",
        "spread.friction=1e-07",
    ]
    typed, written = gaitlab.load("eros_quick", set=given), gaitlab.load("eros_quick", set=texts)
    assert typed.experiment == written.experiment


def test_a_page_from_python_is_that_of_the_command_line(
    tiny: gaitlab.LoadedExperiment, tmp_path: Path
) -> None:
    page = tiny.report(output=tmp_path / "python")
    assert run_command_line(["report", "./tiny.yaml", "--output", str(tmp_path / "line")]) == 0
    ours, theirs = page.read_text(), (tmp_path / "line" / page.name).read_text()
    assert ours == theirs


@pytest.mark.parametrize("validation", [False, True])
def test_a_search_from_python_walks_what_the_command_line_walks(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, validation: bool
) -> None:
    monkeypatch.setattr("gaitlab.running.processes.simulated", pretended.pretend_well)
    settings = ["study.trials=4", "seeds=1"]
    loaded = gaitlab.load("eros_small", set=settings)
    result = loaded.optimize(tmp_path / "python", jobs=0, validation=validation)
    words = ["--set", settings[0], "--set", settings[1], "-j", "0", "--quiet"]
    words += [] if validation else ["--no-validation"]
    assert run_command_line(["optimize", "eros_small", *words, "--store", f"{tmp_path}/line"]) == 0
    ours, theirs = (Store(tmp_path / name).states() for name in ("python", "line"))
    assert ours == theirs
    assert result.status.finished == 4
    assert set(loaded.trials(tmp_path / "python")["trial_id"]) <= ours.keys()


def test_only_what_an_experiment_asks_for_now_is_in_its_table(
    tiny: gaitlab.LoadedExperiment,
) -> None:
    fewer = gaitlab.load("./tiny.yaml", set={"surfaces": ["hard_floor"]})
    assert set(fewer.trials()["surface"]) == {"hard_floor"}
    with pytest.raises(NothingRun):
        gaitlab.load("./tiny.yaml", set={"gait.step_height": 0.011}).trials()


@pytest.mark.parametrize(
    "cell", [99, -1, {"surface": "hard_floor"}, {"surfce": "hard_floor"}, {"surface": "moon"}]
)
def test_a_cell_that_is_none_or_several_is_refused(
    tiny: gaitlab.LoadedExperiment, cell: object
) -> None:
    with pytest.raises(WrongValue):
        tiny.simulate(cell)  # type: ignore[arg-type]


def test_what_is_wrong_is_an_error_of_gaitlab(tmp_path: Path) -> None:
    with pytest.raises(UnknownName):
        gaitlab.load("no_such_experiment")
    with pytest.raises(UsageError):
        gaitlab.load("eros_quick", set=["gait.step_height"])
    with pytest.raises(UsageError):
        gaitlab.load("eros_small").run(tmp_path, jobs=0)
    with pytest.raises(UsageError):
        gaitlab.load("eros_quick").optimize(tmp_path, jobs=0)
    loaded = gaitlab.load("eros_quick")
    for wrong in (
        *({"jobs": -1}, {"shard": "5/4"}, {"shard": "half"}),
        *({"dask": "local", "cluster": object()}, {"dask": "slurm", "jobs": 2}, {"dask": "some"}),
    ):
        with pytest.raises(UsageError):
            loaded.run(tmp_path, **wrong)  # type: ignore[arg-type]
    with pytest.raises(UsageError):
        loaded.report(format="pdf", store=tmp_path)  # type: ignore[arg-type]
    with pytest.raises(NothingRun):
        loaded.report(store=tmp_path)
    with pytest.raises(NothingRun):
        gaitlab.open_store(tmp_path).trials()
    with pytest.raises(NothingRun):
        gaitlab.load("eros_small").trials(tmp_path)
    with pytest.raises(GaitlabError):
        gaitlab.open_store(tmp_path).ticks("eros_quick/worst")


def test_an_infeasible_trial_says_why_and_has_no_ticks() -> None:
    settings = {"gait.step_height": 0.2, "horizon.cycles": 0.5, "engine.name": "mujoco"}
    far = gaitlab.load("eros_quick", set=settings).simulate(0)
    assert (far.state, len(far.ticks), bool(far.reason)) == ("INFEASIBLE", 0, True)


def test_a_script_without_ceremony_runs_trials_in_worker_processes(tmp_path: Path) -> None:
    script = tmp_path / "mine.py"
    text = TINY.format(shipped=SHIPPED)
    (tmp_path / "tiny.yaml").write_text(f"{text}engine: {{name: mujoco}}\n")
    script.write_text(
        "import gaitlab\nprint(gaitlab.load('./tiny.yaml').run(jobs=2).done, flush=True)\n"
    )
    done = subprocess.run(
        [sys.executable, str(script)],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        timeout=300,
        check=True,
    )
    assert done.stdout.split() == ["4"], "the script ran once, its workers did not run it again"


SHOWN = """
import gaitlab
gaitlab.load("./tiny.yaml").run(jobs=0{more})
"""


@pytest.mark.parametrize(
    ("terminal", "more"), [(True, ""), (True, ", progress=False"), (False, "")]
)
def test_a_terminal_is_shown_how_far_a_run_is(walked: Path, terminal: bool, more: str) -> None:
    ours, theirs = pty.openpty()
    done = subprocess.run(
        [sys.executable, "-c", SHOWN.format(more=more)],
        stdout=subprocess.DEVNULL,
        stderr=theirs if terminal else subprocess.PIPE,
        cwd=walked,
        env={**os.environ, "PYTHONPATH": str(ROOT), "TERM": "xterm"},
        timeout=300,
        check=True,
    )
    os.close(theirs)
    shown = b""
    with suppress(OSError):  # the end of a terminal
        while part := os.read(ours, 1 << 16):
            shown += part
    os.close(ours)
    assert bool(shown or done.stderr) is (terminal and not more)


def test_importing_gaitlab_loads_nothing_else_of_it() -> None:
    code = "import sys, gaitlab; print(*[m for m in sys.modules if m.startswith('gaitlab.')])"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=300
    )
    assert done.stdout.split() == []
    heavy = "import sys, gaitlab; print(*{'numpy', 'pandas', 'pyarrow', 'typer'} & {*sys.modules})"
    done = subprocess.run(
        [sys.executable, "-c", heavy], capture_output=True, text=True, check=True, timeout=300
    )
    assert done.stdout.split() == []


def test_only_the_command_line_asks_the_front_of_the_package() -> None:
    package = ROOT / "gaitlab"
    asks = re.compile(rf"from gaitlab import [^\n]*\b({'|'.join(gaitlab.__all__)})\b")
    found = {file.parent.name for file in package.rglob("*.py") if asks.search(file.read_text())}
    assert found == {"cli", "search"}, "and `__version__` stands at the head of a winner"
    assert not {*gaitlab.__all__} & {path.stem for path in package.iterdir()}


@pytest.mark.long
def test_a_users_script_is_typed(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(USER_SCRIPT)
    wrong = USER_SCRIPT.replace("jobs=2", "jobs='two'").replace("seed=1", "sed=1")
    (tmp_path / "wrong.py").write_text(wrong)
    command = [sys.executable, "-m", "mypy", "--strict", "--ignore-missing-imports"]
    command += ["--cache-dir", str(tmp_path / "cache"), "--follow-imports=silent"]
    environment = {"MYPYPATH": str(ROOT), "PATH": "/usr/bin:/bin", "HOME": str(tmp_path)}
    done = subprocess.run(
        [*command, "mine.py", "wrong.py"],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        env=environment,
        timeout=600,
    )
    faults = [line for line in done.stdout.splitlines() if ": error:" in line]
    assert all(line.startswith("wrong.py") for line in faults), done.stdout
    assert len(faults) == 2, done.stdout
    assert (ROOT / "gaitlab" / "py.typed").exists()
