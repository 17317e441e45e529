"""Gears between two flywheels in every engine, and a rig that holds what it says it holds."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pytest

from gaitlab.model import Box, Coupling, Gantry, Joint, Link, Tree, standing
from gaitlab.model.settings import EngineName, EngineSettings, Spread
from gaitlab.model.soles import Sole
from gaitlab.simulation.engine import Engine
from gaitlab.simulation.engines import engine_named
from gaitlab.surfaces.files import load_surface
from tests.driven import each_engine, hold
from tests.ground.bench import LOCK, STILL

POSE = np.zeros(2)


@dataclass(frozen=True)
class Wheels:
    """Two wheels on a beam, only the left one driven; as much of a robot as the engine asks."""

    ratio: float = -1.0
    gantry: Gantry = "none"
    name: str = "wheels"
    feet: tuple[str, str] = ("left_wheel", "right_wheel")
    sole: Sole = Sole(length=0.1, width=0.1, heel=0.05, height=0.03, kind="studs")  # noqa: RUF009

    @property
    def couplings(self) -> tuple[Coupling, ...]:
        return (Coupling("left_axle", "right_axle", self.ratio),)

    @cached_property
    def tree(self) -> Tree:
        box = Box(size=(0.1, 0.3, 0.05), centre=(0.0, 0.0, 0.0))
        beam = Link(name="beam", parent=None, origin=(0, 0, 0), joint=None, mass=2.0, box=box)
        wheels = [
            Link(
                name=f"{side}_wheel",
                parent="beam",
                origin=(0.0, y, 0.0),
                joint=Joint(name=f"{side}_axle", axis="y", lower=-3.0, upper=3.0, servo=servo),
                mass=0.4,
                box=Box(size=(0.1, 0.02, 0.1), centre=(0.0, 0.0, 0.0)),
            )
            for side, y, servo in (("left", 0.1, "mx_64"), ("right", -0.1, None))
        ]
        return Tree((beam, *wheels))

    def joint_targets(self, feet: object) -> np.ndarray:
        raise NotImplementedError

    def hip_offset(self) -> float:
        return 0.0


def world(name: EngineName, robot: Wheels, spread: Spread = STILL, gap: float = 5.0) -> Engine:
    """The wheels high above the floor, falling freely."""
    return engine_named(name)(
        robot, load_surface("hard_floor"), (LOCK,), start=standing(robot, POSE, gap=gap),
        settings=EngineSettings(name=name, dt=0.001), spread=spread, seed=1,
    )  # fmt: skip


@each_engine
@pytest.mark.parametrize("ratio", [-1.0, 1.0, 0.5, -2.0])
def test_the_follower_turns_as_many_times_as_the_ratio_says(
    ratio: float, engine: EngineName
) -> None:
    with world(engine, Wheels(ratio=ratio)) as made:
        turned = hold(made, np.array([0.8, 0.0]), 400).joints[:, 0]
    assert turned[-1, 0] == pytest.approx(0.8, abs=0.02)
    np.testing.assert_allclose(turned[:, 1], ratio * turned[:, 0], atol=2e-3)


@each_engine
def test_a_joint_without_a_servo_takes_no_servo_and_no_torque(engine: EngineName) -> None:
    with world(engine, Wheels()) as made:
        # What is sent to a follower reaches no motor.
        assert not hold(made, np.array([0.5, 99.0]), 50).joints[:, 2, 1].any()


@each_engine
@pytest.mark.parametrize(("gantry", "held"), [("level", True), ("planar", False)])
def test_a_gantry_lets_the_trunk_fall_and_pitches_only_when_it_may(
    gantry: Gantry, held: bool, engine: EngineName
) -> None:
    tilted = Spread(friction=0.0, servo_gain=0.0, tilt=0.1, position=0.01, terrain=0.0)
    # Wheels that turn the same way pitch the trunk the other way.
    with world(engine, Wheels(ratio=1.0, gantry=gantry), tilted) as made:
        first = made.trunk
        tape = hold(made, np.array([0.8, 0.0]), 300, gantry=True)
    last, pitch = tape.trunk[-1], tape.joints[-1, 0, 2]
    assert last[2] - first[2] == pytest.approx(-0.5 * 9.81 * 0.3**2, rel=0.01)
    assert last[1] == pytest.approx(0.0, abs=1e-9)
    assert (abs(pitch) < 1e-4) == held
    assert last[4] == pytest.approx(np.sin(pitch / 2.0), abs=1e-6)
    assert (last[3], last[5]) == (0.0, 0.0)
