"""A metric of one's own: a file beside the experiment, measured, searched for, part of a trial."""

from __future__ import annotations

from pathlib import Path

import pytest

from gaitlab import plugins
from gaitlab.cli import run_command_line
from gaitlab.errors import FileError
from gaitlab.experiment import load_experiment
from gaitlab.experiment.plan import plan
from gaitlab.running.run_trial import run_trial
from gaitlab.store import Store

METRIC = """\
from helper import factor
UNIT = "m"
BETTER = "higher"
def trunk_rise(log) -> float:
    return factor * float(log["trunk_z"].max())
"""
WALK = """\
robot: eros
gait: eros
surfaces: [hard_floor]
metrics: [./trunk_rise.py]
report: {metrics: [trunk_rise]}
seeds: 1
horizon: {cycles: 1, time: 0.1}
"""
STUDY = """
study:
  objectives: [{maximize: trunk_rise}]
  search: {gait.step_height: {low: 0.01, high: 0.02}}
"""


@pytest.fixture
def walk(tmp_path: Path) -> Path:
    (tmp_path / "helper.py").write_text("factor = 2.0\n")
    (tmp_path / "trunk_rise.py").write_text(METRIC)
    (tmp_path / "walk.yaml").write_text(WALK)
    return tmp_path / "walk.yaml"


def first_id(path: Path) -> str:
    return next(plan(load_experiment(path)).trials()).trial.id


def test_it_is_measured_beside_the_others_and_stands_in_the_table(walk: Path) -> None:
    """Whether its unit stands beside it or in a decorator, in a worker as in this process."""
    head = "from gaitlab.metrics import metric\n@metric(unit='m', better='higher')\ndef"
    decorated = METRIC.replace('UNIT = "m"\nBETTER = "higher"\n', "").replace("def", head)
    (walk.parent / "rise.py").write_text(decorated.replace("trunk_rise", "rise"))
    walk.write_text(WALK.replace("./trunk_rise.py", "./trunk_rise.py, ./rise.py"))
    store = Store(walk.parent / "data")
    words = ["run", str(walk), "--store", str(store.path), "-q"]
    assert run_command_line([*words, "-j", "1"]) == 0
    trial_id = first_id(walk)
    expected = 2.0 * float(store.log(trial_id)["trunk_z"].max())
    metrics = store.record(trial_id).metrics
    assert set(metrics) == {*plugins.names("metric"), "trunk_rise", "rise"}
    for name in ("trunk_rise", "rise"):
        assert metrics[name] == pytest.approx(expected)
        table = store.query(f"SELECT {name} FROM trials")
        assert table[name][0] == pytest.approx(expected)
    assert run_command_line([*words, "-j", "0"]) == 0  # cached


def test_another_text_of_it_or_of_its_helper_is_another_trial(walk: Path) -> None:
    before = first_id(walk)
    (walk.parent / "helper.py").write_text("factor = 3.0\n")
    helped = first_id(walk)
    (walk.parent / "trunk_rise.py").write_text(METRIC.replace("max()", "min()"))
    ids = {before, helped, first_id(walk)}
    (walk.parent / "walk.yaml").write_text(WALK.replace("metrics: [./trunk_rise.py]\nreport", "#"))
    assert len({*ids, first_id(walk)}) == 4


def test_a_search_can_ask_for_it(walk: Path) -> None:
    walk.write_text(WALK.replace("report: {metrics: [trunk_rise]}\n", "") + STUDY)
    study = load_experiment(walk).study
    assert study is not None
    assert study.objectives[0].metric == "trunk_rise"


@pytest.mark.parametrize(
    "content",
    ["UNIT = 'm'\n", "def trunk_rise(log) -> float:\n    return 1.0\n", "UNIT = = 2\n",
     "UNIT = 'm'\ndef trunk_rise(log):\n    return 1.0\n",
     "UNIT = 'm'\ndef trunk_rise(log) -> Nowhere:\n    return 1.0\n", "raise SystemExit\n"],
)  # fmt: skip
def test_a_file_that_is_no_metric_is_named(walk: Path, content: str) -> None:
    (walk.parent / "trunk_rise.py").write_text(content)
    with pytest.raises(FileError) as error:
        load_experiment(walk)
    assert {problem.file.name for problem in error.value.problems} == {"trunk_rise.py"}


@pytest.mark.parametrize(
    "metric", ["stable", "./nowhere.py", "3", "{a: 1}", "./stable.py", "./helper.yaml"]
)
def test_what_is_no_file_of_ones_own_is_refused_at_its_place(walk: Path, metric: str) -> None:
    (walk.parent / "stable.py").write_text(METRIC.replace("trunk_rise", "stable"))
    walk.write_text(WALK.replace("./trunk_rise.py", metric))
    with pytest.raises(FileError):
        load_experiment(walk)


def test_what_it_raises_or_gives_wrongly_fails_its_trial_and_says_so(walk: Path) -> None:
    for wrong in ("log['no_such_column'].max()", "[1.0]"):
        (walk.parent / "trunk_rise.py").write_text(
            METRIC.replace('factor * float(log["trunk_z"].max())', wrong)
        )
        trial = next(plan(load_experiment(walk)).trials()).trial
        store = walk.parent / "data"
        store.mkdir(exist_ok=True)
        record = run_trial(trial.id, trial.to_dict(), store)
        assert record.state == "FAILED"
        assert "trunk_rise" in record.reason
