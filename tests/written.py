"""Files that a team of its own would write, for the tests of what reads them."""

from __future__ import annotations

from pathlib import Path

import pytest

from gaitlab.errors import FileError, Problem
from gaitlab.experiment import Experiment, load_experiment

GAIT = '''"""A team's own gait."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from gaitlab.errors import WrongValue
from gaitlab.parameters import parameter


@dataclass(frozen=True, kw_only=True)
class Gait:
    """Only what planning asks of a gait."""

    step_length: float = parameter(unit="m", low=-0.3, high=0.3, doc="step length")
    hip_height: float = parameter(0.225, unit="m", low=0.05, high=2.0, doc="hip height")
    step_height: float = parameter(0.03, unit="m", low=0.0, high=0.2, doc="lift")
    areas: int = parameter(5, unit="-", low=2, high=50, doc="areas of the landing")
    heel_strike: Literal["none", "add", "literal"] = parameter("none", unit="-", doc="heel")
    sign: Literal[1, -1, 0] = parameter(1, unit="-", doc="sign of the push-off")
    smooth: bool = parameter(False, unit="-", doc="smooth start")
    gait_period = 1.0
    startup_time = 2.0

    def __post_init__(self) -> None:
        if self.step_height >= self.hip_height:
            raise WrongValue(f"a lift of {self.step_height} m reaches the hip; lower it")

    def feet(self, t: object) -> object:
        """Never asked for here."""
        raise NotImplementedError
'''

EXPERIMENT = """\
robot: eros
gait: {type: ./my_gait.py, step_height: 0.02}
surfaces: [grass_50mm, carpet_4mm]
grid:
  gait.step_length: [0.0, 0.02, 1e-1]
  robot.sole.kind: [flat, studs]
zip:
  gait.heel_strike: [none, add]
  gait.areas: [3, 4]
seeds: 4
report: {rows: gait.step_length, compare: eros_table7}
"""


def write(folder: Path, text: str = EXPERIMENT, name: str = "walk.yaml") -> Path:
    """An experiment file with the team's gait beside it."""
    (folder / "my_gait.py").write_text(GAIT)
    (folder / name).write_text(text)
    return folder / name


def read(folder: Path, text: str = EXPERIMENT, *settings: str) -> Experiment:
    """The experiment of a text."""
    return load_experiment(write(folder, text), settings)


def changed(old: str, new: str) -> str:
    """The experiment with one passage changed; the passage must be there."""
    if old not in EXPERIMENT:
        raise ValueError(f"{old!r} is not in the experiment")
    return EXPERIMENT.replace(old, new)


def problems(folder: Path, text: str, *settings: str) -> list[Problem]:
    """What reading a text complains about."""
    with pytest.raises(FileError) as caught:
        read(folder, text, *settings)
    return caught.value.problems
