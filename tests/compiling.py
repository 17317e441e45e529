"""A moment of walking in each engine that is there, run as a module for what it leaves compiled.

Where nothing is kept yet, compiling takes half a minute of a processor, and the workers of a test
run and the processes that they start would all do it at the same time.
"""

from __future__ import annotations

from importlib.util import find_spec

from gaitlab.metrics import measure
from gaitlab.simulation.simulate import simulate
from tests.trials import trial

ENGINES = {"mujoco": "mujoco", "bullet": "pybullet"}  # and the package of each

if __name__ == "__main__":
    for engine, package in ENGINES.items():
        if find_spec(package):
            measure(simulate(trial("grass_50mm", cycles=0.2, engine={"name": engine})))
