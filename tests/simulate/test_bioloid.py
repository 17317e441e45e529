from dataclasses import replace

import numpy as np
import pytest

from gaitlab.errors import Infeasible
from gaitlab.experiment import load_experiment
from gaitlab.experiment.plan import plan
from gaitlab.model.settings import Horizon
from gaitlab.simulation.simulate import simulate


@pytest.mark.parametrize("surface", ["hard_floor", "carpet_4mm"])
def test_the_bioloid_walks_forward_with_the_shipped_constants(surface: str) -> None:
    planned = plan(load_experiment("bioloid_walk")).trials()
    trial = next(item.trial for item in planned if item.values["surface"] == surface)
    log = simulate(replace(trial, horizon=Horizon(cycles=2)))
    assert not np.any(log.arrays["fall_cause"])
    start = round(log.header.startup_time / log.header.dt)
    walked = log.arrays["trunk_x"][-1] - log.arrays["trunk_x"][start]
    assert walked > trial.gait.step_length  # of four commanded, the rest slips away


def test_the_printed_poses_have_the_feet_pass_through_each_other() -> None:
    trial = next(iter(plan(load_experiment("bioloid_poses")).trials())).trial
    with pytest.raises(Infeasible, match="overlap"):
        simulate(trial)
