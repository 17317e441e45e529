"""What decides whether a stored trial still counts: all that its numbers follow from, no more."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from gaitlab.experiment import load_experiment
from gaitlab.experiment.plan import plan
from gaitlab.running import provenance

LOADED = """
import json, sys
from gaitlab.metrics import measure
from gaitlab.simulation.simulate import simulate
from gaitlab.simulation.trial import Trial
for trial in json.load(sys.stdin):
    measure(simulate(Trial.from_dict(trial)))
print(json.dumps([getattr(module, "__file__", None) or "" for module in sys.modules.values()]))
"""


@pytest.fixture
def package(tmp_path: Path) -> Path:
    copy = tmp_path / "gaitlab"
    shutil.copytree(provenance.PACKAGE, copy, ignore=shutil.ignore_patterns("__pycache__"))
    return copy


@pytest.mark.long
def test_every_file_that_a_trial_loads_decides_whether_it_still_counts() -> None:
    experiment = load_experiment("experiments/all_robots.yaml", ["horizon.time=0.2"])
    trials = {item.trial.names.robot: item.trial.to_dict() for item in plan(experiment).trials()}
    assert len(trials) == 5
    done = subprocess.run(
        [sys.executable, "-c", LOADED],
        input=json.dumps(list(trials.values())), capture_output=True, check=True, text=True,
        timeout=300,
    )  # fmt: skip
    loaded = {Path(file) for file in json.loads(done.stdout)}
    own = {file for file in loaded if file.is_relative_to(provenance.PACKAGE)}
    own.remove(provenance.PACKAGE / "__init__.py")  # what users import; a trial takes nothing of it
    assert len(own) > 50
    assert own <= provenance.makers()[0]


def test_makers_are_the_code_and_the_data_of_a_trial_and_no_page_or_command() -> None:
    inside = {path.relative_to(provenance.PACKAGE).as_posix() for path in provenance.makers()[0]}
    assert inside >= {
        "simulation/loop.py", "kinematics/transforms.py", "robots/flow.py", "gaits/eros.py",
        "metrics/stability.py", "servos/mx_28.yaml", "surfaces/press.py", 
        "robots/nao_v40_links.csv", "robots/flow_links.csv",
    }  # fmt: skip
    rooms = {path.partition("/")[0] for path in inside}
    assert not rooms & {"report", "papers", "cli", "store", "statistics", "search", "__init__.py"}


def test_another_byte_of_a_maker_or_another_file_to_name_is_another_code(package: Path) -> None:
    before = provenance.code_digest.__wrapped__("bullet", package)
    for path in (package / "report").rglob("*.py"):
        path.write_text("# another\n")
    assert provenance.code_digest.__wrapped__("bullet", package) == before
    (package / "gaits" / "mine.py").write_text("HEIGHT = 0.2\n")
    named = provenance.code_digest.__wrapped__("bullet", package)
    assert named != before
    with (package / "simulation" / "loop.py").open("a") as code:
        code.write("# another\n")
    assert provenance.code_digest.__wrapped__("bullet", package) not in (before, named)


def test_another_version_of_a_library_is_another_code(monkeypatch: pytest.MonkeyPatch) -> None:
    before, version = provenance.code_digest.__wrapped__(), provenance._version
    for library in ("numpy", "numba", "pybullet"):
        with monkeypatch.context() as patch:
            another = lambda of, library=library: f"{version(of)}{'0' * (of == library)}"  # noqa: E731
            patch.setattr(provenance, "_version", another)
            assert provenance.code_digest.__wrapped__() != before, library
