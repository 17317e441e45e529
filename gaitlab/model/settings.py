"""Numbers of a trial that belong neither to robot, gait nor ground."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from gaitlab.errors import WrongValue
from gaitlab.model.servo import FORMER_TICKS
from gaitlab.parameters import parameter

EngineName = Literal["bullet", "mujoco"]
SOLVER_ITERATIONS = 50  # Bullet's own default


@dataclass(frozen=True, kw_only=True)
class EngineSettings:
    """Which physics engine simulates, and how it integrates."""

    name: EngineName = parameter(
        "bullet", unit="-", doc="bullet is the reference, mujoco the fast one", late=True
    )
    dt: float = parameter(
        0.002,
        unit="s",
        low=1e-4,
        high=0.01,
        doc="one tick of the log; several steps of the engine where servos ask for it",
    )
    solver_iterations: int = parameter(
        SOLVER_ITERATIONS,
        unit="-",
        low=1,
        high=1000,
        doc="of Bullet's constraint solver a tick; MuJoCo's goes on until it has converged",
    )

    def __post_init__(self) -> None:
        if self.name != "bullet" and self.solver_iterations != SOLVER_ITERATIONS:
            raise WrongValue(
                f"solver_iterations is {self.solver_iterations}, but it is Bullet's alone: "
                f"{self.name}'s solver goes on until it has converged; leave it out"
            )


@dataclass(frozen=True, kw_only=True)
class Horizon:
    """When a trial ends if the robot does not fall: whichever comes first."""

    cycles: float = parameter(
        9.0, unit="-", low=0.5, high=1e4, doc="full-amplitude gait cycles walked"
    )
    distance: float = parameter(
        6.0, unit="m", low=0.01, high=1e3, doc="displacement of the trunk along the commanded way"
    )
    time: float = parameter(
        60.0, unit="s", low=0.1, high=3600.0, doc="time since full-amplitude walking started"
    )


@dataclass(frozen=True, kw_only=True)
class Spread:
    """How much the replicates of one cell differ; each quantity has its own random stream."""

    friction: float = parameter(
        0.10,
        unit="-",
        low=0.0,
        high=0.5,
        source="assumption",
        doc="friction of the ground is scaled by 1 + this x U(-1, 1)",
    )
    servo_gain: float = parameter(
        0.05,
        unit="-",
        low=0.0,
        high=0.5,
        source="assumption",
        doc="position gain of each servo is scaled by 1 + this x U(-1, 1)",
    )
    servo_latency: float = parameter(
        0.0,
        unit="s",
        low=0.0,
        high=0.2,
        source="assumption: all servos of a type are equally late",
        doc="each servo's latency is moved by this x U(-1, 1), never below 0",
        late=True,
        former=FORMER_TICKS,
    )
    tilt: float = parameter(
        0.00873,
        unit="rad",
        low=0.0,
        high=0.2,
        source="assumption: 0.5 degrees",
        doc="initial lean of the legs in roll and pitch, uniform within +- this",
    )
    position: float = parameter(
        0.001,
        unit="m",
        low=0.0,
        high=0.05,
        source="assumption: 1 mm",
        doc="initial x and y of the robot, uniform within +- this",
    )
    terrain: float = parameter(
        1.0,
        unit="-",
        low=0.0,
        high=1.0,
        source="assumption",
        doc="scale of the pile's own irregularity; 0 makes every lawn perfectly even",
    )
