"""Code of a team's own is what it imports and what it reads; a trial is named by all of it."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

import gaitlab
from gaitlab.errors import FileError, WrongValue
from gaitlab.experiment import load_experiment
from gaitlab.experiment.plan import plan
from gaitlab.plugins import load_class, user_code
from gaitlab.running.run_trial import run_trial
from gaitlab.simulation.trial import Trial
from tests.conftest import DISK

HEAD = """\
import dataclasses
from pathlib import Path
import numpy as np
from gaitlab.gaits.eros import Gait as Shipped
HERE = Path(__file__).parent
"""
BODY = """
@dataclasses.dataclass(frozen=True, kw_only=True)
class Gait(Shipped):
    def feet(self, t):
        plain = Shipped(**{f.name: getattr(self, f.name) for f in dataclasses.fields(Shipped)})
        return dataclasses.replace(plain, step_height=plain.step_height * self.lift()).feet(t)
    def lift(self):
"""
WALK = """\
gait: {type: ./gait.py, step_height: 0.03}
robot: eros
grid: {gait.step_length: [0.02, 0.04]}
surfaces: [hard_floor]
seeds: 1
horizon: {cycles: 1, time: 0.1}
"""


@pytest.fixture
def tmp_path() -> Iterator[Path]:
    """On a disk: in memory two versions within some milliseconds have the same time."""
    with tempfile.TemporaryDirectory(dir=DISK) as folder:
        yield Path(folder)


def write(folder: Path, lift: str, head: str = "", walk: str = WALK) -> Path:
    """An experiment whose gait multiplies its lift by what a line of code gives."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "gait.py").write_text(HEAD + head + BODY + f"        {lift}\n")
    (folder / "walk.yaml").write_text(walk)
    return folder / "walk.yaml"


def ids(path: Path) -> list[str]:
    return [item.trial.id for item in plan(load_experiment(path)).trials()]


def files(path: Path) -> dict[str, str]:
    return dict(load_experiment(path).parts.gait_code.files)


def anew(planned: Trial) -> Trial:
    """A planned trial as another process makes it from its data."""
    return Trial.from_dict(json.loads(json.dumps(planned.to_dict())))


def first(path: Path) -> Trial:
    return next(plan(load_experiment(path)).trials()).trial


READ = {
    "numpy": "return float(np.loadtxt(HERE / 'lift.csv'))",
    "numpy, binary": "return float(np.load(HERE / 'lift.npy'))",
    "mapped": "return float(np.load(HERE / 'lift.npy', mmap_mode='r'))",
    "pandas": "import pandas; return float(pandas.read_csv(HERE / 'lift.csv', header=None)[0][0])",
    "json": "import json; return json.loads((HERE / 'lift.csv').read_text())",
    "yaml": "from ruamel.yaml import YAML; return float(YAML().load(HERE / 'lift.csv'))",
    "os": "import os; return float(os.read(os.open(HERE / 'lift.csv', os.O_RDONLY), 99))",
    "sqlite": (
        "from sqlite3 import connect; base = connect(HERE / 'l.db'); "
        "found = base.execute('select * from t').fetchone()[0]; base.close(); return found"
    ),
    "threads": (
        "from concurrent.futures import ThreadPoolExecutor; "
        "return float(next(ThreadPoolExecutor(1).map(np.loadtxt, [HERE / 'lift.csv'])))"
    ),
    "helper": "import helper; return helper.LIFT",
    "helper, by name": "from helper import LIFT; return LIFT",
    "helper of a helper": "import outer; return outer.helper.LIFT",
    "package": "import parts.inner; return parts.inner.LIFT",
    "package, by name": "from parts import inner; return inner.LIFT",
    "package, relative": "from parts.relative import LIFT; return LIFT",
    "relative": "from .helper import LIFT; return LIFT",
    "path": "import sys; sys.path.insert(0, str(HERE / 'lib')); import deep; return deep.LIFT",
    "importlib": (
        "import sys, importlib; sys.path.insert(0, str(HERE / 'lib')); "
        "return importlib.import_module('deeper').LIFT"
    ),
    "loaded by hand": (
        "import importlib.util as u; s = u.spec_from_file_location('h', HERE / 'helper.py'); "
        "m = u.module_from_spec(s); s.loader.exec_module(m); return m.LIFT"
    ),
    "executed": "d = {}; exec((HERE / 'helper.py').read_text(), d); return d['LIFT']",
    "run": "import runpy; return runpy.run_path(HERE / 'helper.py')['LIFT']",
    "thrice removed": "import helper; return helper.from_table()",
    "in a folder": "return float(np.loadtxt(next((HERE / 'tables').glob('*.csv'))))",
    "through a link": "return float(np.loadtxt(HERE / 'link.csv'))",
    "elsewhere": "return float(np.loadtxt(HERE / '..' / 'away.csv'))",
}


def furnish(folder: Path, lift: float) -> None:
    """Everything that the gaits above may read, all of it saying the same number."""
    import sqlite3

    for inside in ("parts", "lib", "tables"):
        (folder / inside).mkdir(parents=True, exist_ok=True)
    text = f"LIFT = {lift}\n"
    (folder / "lift.csv").write_text(f"{lift}\n")
    (folder / "tables" / "a.csv").write_text(f"{lift}\n")
    (folder.parent / "away.csv").write_text(f"{lift}\n")
    (folder.parent / "linked.csv").write_text(f"{lift}\n")
    if not (folder / "link.csv").is_symlink():
        (folder / "link.csv").symlink_to(folder.parent / "linked.csv")
    np.save(folder / "lift.npy", lift)
    (folder / "l.db").unlink(missing_ok=True)
    with closing(sqlite3.connect(folder / "l.db")) as database:
        database.execute(f"create table t as select {lift} as lift")
    table = """\
from pathlib import Path
def from_table():
    return float(Path(__file__).with_name("lift.csv").read_text())
"""
    (folder / "helper.py").write_text(text + table)
    (folder / "outer.py").write_text("import helper\n")
    (folder / "parts" / "__init__.py").write_text("")
    (folder / "parts" / "inner.py").write_text(text)
    (folder / "parts" / "relative.py").write_text("from .inner import LIFT\n")
    (folder / "lib" / "deep.py").write_text("import helper\nLIFT = helper.LIFT\n")
    (folder / "lib" / "deeper.py").write_text(text)


@pytest.mark.parametrize("how", READ)
def test_whatever_a_gait_reads_names_its_trials(tmp_path: Path, monkeypatch, how: str) -> None:
    monkeypatch.setattr(sys, "path", [*sys.path])
    monkeypatch.setattr(sys, "dont_write_bytecode", True)  # two versions within one second
    folder = tmp_path / "team"
    path = write(folder, READ[how])
    furnish(folder, 1.0)
    before = first(path)
    furnish(folder, 0.5)  # as long as before and in the same instant, as an editor would not
    after = first(path)
    assert before.id != after.id
    made = anew(after)
    assert made.id == after.id
    assert made.gait.lift() == 0.5
    made.require_complete()
    with pytest.raises(WrongValue, match="has changed since the trial was planned"):
        anew(before)
    furnish(folder, 1.0)
    assert first(path).id == before.id


@pytest.mark.parametrize("head", ["import helper\n", "TABLE = np.loadtxt(HERE / 'lift.csv')\n"])
def test_what_is_read_while_it_is_loaded_counts_too(tmp_path: Path, head: str) -> None:
    path = write(tmp_path, "return 1.0", head)
    furnish(tmp_path, 1.0)
    before = ids(path)
    furnish(tmp_path, 2.0)
    assert not set(before) & set(ids(path))


def test_a_file_alone_keeps_the_identity_it_had(tmp_path: Path) -> None:
    path = write(tmp_path, "import json, scipy.signal; return 1.0")
    code = load_experiment(path).parts.gait_code
    assert code.files == ()
    assert code.identity == f"sha256:{code.digest}"
    assert set(code.to_dict()) == {"name", "digest"}


def test_what_nobody_asked_for_changes_nothing(tmp_path: Path) -> None:
    path = write(tmp_path, READ["helper"])
    furnish(tmp_path, 1.0)
    before = ids(path)
    (tmp_path / "lift.csv").write_text("7\n")
    (tmp_path / "unrelated.py").write_text("")
    assert ids(path) == before
    assert set(files(path)) == {"helper.py"}


def test_two_folders_with_helpers_of_one_name_do_not_mix(tmp_path: Path) -> None:
    old, new = (write(tmp_path / name, READ["helper of a helper"]) for name in ("old", "new"))
    furnish(tmp_path / "old", 0.25)
    furnish(tmp_path / "new", 0.75)
    trials = [first(old), first(new)]
    assert [trial.gait.lift() for trial in trials] == [0.25, 0.75]
    assert [anew(trial).gait.lift() for trial in trials] == [0.25, 0.75]
    assert trials[0].id != trials[1].id
    assert "helper" not in sys.modules


def test_the_folder_can_move(tmp_path: Path) -> None:
    path = write(tmp_path / "here", READ["thrice removed"])
    furnish(tmp_path / "here", 1.0)
    before = ids(path)
    os.rename(tmp_path / "here", tmp_path / "there")
    assert ids(tmp_path / "there" / "walk.yaml") == before


def test_two_tables_that_change_places_are_another_gait(tmp_path: Path) -> None:
    path = write(tmp_path, "a, b = (float((HERE / n).read_text()) for n in 'ab'); return a / b")
    found = []
    for a, b in (("1", "2"), ("2", "1")):
        (tmp_path / "a").write_text(a)
        (tmp_path / "b").write_text(b)
        found += ids(path)
    assert len(set(found)) == len(found)


def test_installed_modules_are_not_replaced_by_folders_of_their_name(tmp_path: Path) -> None:
    (tmp_path / "numpy").mkdir()
    (tmp_path / "gaitlab").mkdir()
    (tmp_path / "gaitlab" / "__init__.py").write_text("raise RuntimeError\n")
    (tmp_path / "json.py").write_text("raise RuntimeError\n")
    path = write(tmp_path, "import json, numpy.linalg; return 1.0")
    assert files(path) == {}


def test_each_value_of_the_grid_shows_what_it_reads(tmp_path: Path) -> None:
    walk = WALK.replace("gait.step_length: [0.02, 0.04]", "gait.heel_strike: [none, add]")
    path = write(
        tmp_path, "return float((HERE / f'{self.heel_strike}.csv').read_text())", walk=walk
    )
    for name in ("none", "add"):
        (tmp_path / f"{name}.csv").write_text("1")
    assert set(files(path)) == {"none.csv", "add.csv"}


def test_what_is_read_only_later_is_refused_until_it_is_declared(tmp_path: Path) -> None:
    lift = "return float((HERE / 'late.csv').read_text()) if len(t) > 60 else 1.0"
    path = write(tmp_path, "return 1.0")
    text = (tmp_path / "gait.py").read_text().replace("return 1.0", lift)
    text = text.replace("self.lift()", "self.lift(t)").replace("lift(self)", "lift(self, t)")
    (tmp_path / "gait.py").write_text(text)
    (tmp_path / "late.csv").write_text("1.0")
    (tmp_path / "store").mkdir()
    trial = first(path)
    record = run_trial(trial.id, trial.to_dict(), tmp_path / "store")
    assert record.state == "FAILED"
    assert "late.csv" in record.reason
    assert "depends:" in record.reason
    (tmp_path / "walk.yaml").write_text(WALK + "depends: [./late.csv]\n")
    declared = first(path)
    assert declared.id != trial.id
    assert run_trial(declared.id, declared.to_dict(), tmp_path / "store").state == "DONE"


@pytest.mark.parametrize(
    "unseen",
    [
        "import pyarrow.csv; return 1.0",
        "import subprocess; return 1.0 + subprocess.run('true').returncode",
        "import os; return 1.0 + os.system('true')",
        "import ctypes; ctypes.CDLL(None); return 1.0",
    ],
)
def test_what_cannot_be_seen_is_refused_or_declared(tmp_path: Path, unseen: str) -> None:
    path = write(tmp_path, unseen)
    with pytest.raises(FileError) as caught:
        load_experiment(path)
    assert "`depends: []`" in str(caught.value)
    assert str(caught.value).startswith(f"{path}:1:")
    path.write_text(WALK + "depends: []\n")
    assert anew(first(path)).gait_code.declared
    (tmp_path / "tables").mkdir()
    (tmp_path / "tables" / "x.parquet").write_text("1")
    path.write_text(WALK + "depends: [./tables]\n")
    before = ids(path)
    assert set(files(path)) == {"tables/x.parquet"}
    (tmp_path / "tables" / "x.parquet").write_text("2")
    assert not set(before) & set(ids(path))


@pytest.mark.parametrize("wrong", ["lift.csv", "[./none.csv]", "[tables]", "[1]", "{a: 1}", "''"])
def test_a_wrong_declaration_is_refused(tmp_path: Path, wrong: str) -> None:
    path = write(tmp_path, "return 1.0", walk=f"{WALK}depends: {wrong}\n")
    (tmp_path / "tables").mkdir()
    with pytest.raises(FileError, match="depends: found"):
        load_experiment(path)


def test_a_declaration_without_code_of_ones_own_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "walk.yaml"
    path.write_text(WALK.replace("./gait.py", "eros") + "depends: []\n")
    with pytest.raises(FileError, match="depends: no robot"):
        load_experiment(path)


def test_what_it_has_written_itself_is_no_part_of_it(tmp_path: Path) -> None:
    path = write(tmp_path, "p = HERE / 'scratch'; p.write_text('1'); return float(p.read_text())")
    assert files(path) == {}


def test_robots_and_controllers_are_watched_as_gaits_are(tmp_path: Path) -> None:
    robot = "from gaitlab.robots import eros\nimport dataclasses\nimport geometry\n" + (
        "@dataclasses.dataclass(frozen=True, kw_only=True)\nclass Robot(eros.Robot):\n    pass\n"
    )
    balance = robot.replace("robots import eros", "balance import ankle_hip").replace(
        "Robot(eros.Robot)", "Balance(ankle_hip.Balance)"
    )
    (tmp_path / "robot.py").write_text(robot)
    (tmp_path / "balance.py").write_text(balance)
    path = write(tmp_path, "return 1.0")
    text = WALK.replace("robot: eros", "robot: ./robot.py\nbalance: ./balance.py")
    path.write_text(text)
    seen = set()
    for number in (1, 2):
        (tmp_path / "geometry.py").write_text(f"KNEE = {number}\n")
        parts = load_experiment(path).parts
        assert [dict(code.files).keys() for code in parts.codes] == [
            {"geometry.py"},
            set(),
            {"geometry.py"},
        ]
        seen |= {*ids(path)}
    assert len(seen) == 4


def test_another_process_finds_the_same_names(tmp_path: Path) -> None:
    path = write(tmp_path, READ["thrice removed"])
    furnish(tmp_path, 1.0)
    program = (
        "import sys\n"
        "from gaitlab.experiment import load_experiment\n"
        "from gaitlab.experiment.plan import plan\n"
        "print(*[item.trial.id for item in plan(load_experiment(sys.argv[1])).trials()])"
    )
    environment = {**os.environ, "PYTHONPATH": str(Path(gaitlab.__file__).parent.parent)}
    command = [sys.executable, "-c", program, str(path)]
    there = subprocess.run(
        command, capture_output=True, text=True, check=True, env=environment, timeout=300
    )
    assert there.stdout.split() == ids(path)


def test_a_helper_that_is_missing_is_named_as_the_file_names_it(tmp_path: Path) -> None:
    path = write(tmp_path, "return 1.0", "import parts.nothing\n")
    furnish(tmp_path, 1.0)
    with pytest.raises(FileError, match=r"gait\.py:6: .*No module named 'parts\.nothing'"):
        load_experiment(path)


def test_the_same_files_are_loaded_once(tmp_path: Path) -> None:
    write(tmp_path, READ["helper"])
    furnish(tmp_path, 1.0)
    load = lambda: load_class("gait", "./gait.py", tmp_path)  # noqa: E731
    before = load()
    assert before(step_length=0.0).lift() == 1.0
    assert load() is before
    furnish(tmp_path, 2.0)
    assert load()(step_length=0.0).lift() == 2.0
    assert user_code(tmp_path / "gait.py").unchanged
