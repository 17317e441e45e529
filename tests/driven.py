"""An engine driven by hand: it goes on whatever happens to the robot."""

from __future__ import annotations

from importlib.util import find_spec
from math import inf

import numpy as np
import pytest

from gaitlab.log.course import Course
from gaitlab.simulation.ending import Ending
from gaitlab.simulation.engine import Engine
from gaitlab.simulation.engines import ENGINES
from gaitlab.simulation.tape import Tape

INSTALLED = [name for name, kind in ENGINES.items() if find_spec(kind.package)]
each_engine = pytest.mark.parametrize("engine", INSTALLED)


def endless() -> Ending:
    """Nothing ends the trial but numbers that are none."""
    ending = Ending(
        dt=0.002, standing_height=0.3, startup=0, distance=inf, course=Course(ahead=0.0)
    )
    ending.rule[:3] = inf, inf, -inf
    return ending


def drive(engine: Engine, targets: np.ndarray, gantry: bool = False) -> Tape:
    """Let it walk; what happened. Shape of targets (ticks, joints), in [rad]."""
    tape = Tape(len(targets), targets.shape[1] + gantry)
    engine.advance(targets, tape, endless())
    return tape


def hold(engine: Engine, pose: np.ndarray, ticks: int, gantry: bool = False) -> Tape:
    """The same targets all the time. Shape of pose (joints,)."""
    return drive(engine, np.tile(pose, (ticks, 1)), gantry)
