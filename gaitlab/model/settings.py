"""Numbers of a trial that belong neither to robot, gait nor ground."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import cos, radians, sin, sqrt
from typing import Literal

from gaitlab.errors import WrongValue
from gaitlab.log import GRAVITY
from gaitlab.model.servo import FORMER_TICKS
from gaitlab.model.tree import Vector
from gaitlab.parameters import parameter

EngineName = Literal["bullet", "mujoco"]
SOLVER_ITERATIONS = 50  # Bullet's own default
STEEPEST = (
    30.0  # degrees; a sole would need a friction of 0.58 there, and feet do not turn much farther
)


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


@dataclass(frozen=True, kw_only=True)
class Slope:
    """How the ground is tilted, as the robot faces when it is put down on it.

    The world frame is the ground's: z is at a right angle to it, x and y lie in it, and it is
    gravity that leans. So a robot that stands at a right angle to a slope has no roll and no pitch
    in the log, while its IMU, which feels gravity, reads a pitch of minus `pitch` and a roll of
    `roll`. A gantry stands on the slope.
    """

    pitch: float = parameter(
        0.0,
        unit="deg",
        low=-STEEPEST,
        high=STEEPEST,
        doc="how steeply the ground rises ahead of the robot: above 0 uphill, below 0 downhill",
        late=True,
    )
    roll: float = parameter(
        0.0,
        unit="deg",
        low=-STEEPEST,
        high=STEEPEST,
        doc="how steeply the ground rises to its left",
        late=True,
    )

    @property
    def up(self) -> Vector:
        """Against gravity, a unit vector; its x and y are the sines of `pitch` and `roll`."""
        x, y = sin(radians(self.pitch)), sin(radians(self.roll))
        return x, y, sqrt(1.0 - x * x - y * y)

    @property
    def gravity(self) -> Vector:
        """In [m/s^2]."""
        x, y, z = self.up
        return -GRAVITY * x, -GRAVITY * y, -GRAVITY * z

    @property
    def level(self) -> tuple[float, float, float, float] | None:
        """Shortest turn from the ground's frame to one whose z is `up`, xyzw; None on the level.

        About their cross product, by the angle between them. Derived here.
        """
        x, y, z = self.up
        if not x and not y:
            return None
        w = sqrt(0.5 * (1.0 + z))
        return 0.5 * y / w, -0.5 * x / w, 0.0, w


@dataclass(frozen=True, kw_only=True)
class Push:
    """A push at the trunk's centre of mass, along the ground, once in a trial.

    Its force is constant over `duration`, rounded to whole ticks, and such that it adds up to
    `impulse` exactly. The instant goes by the gait's clock, `gait_period` after the start-up; who
    stands has the cycles of the horizon.
    """

    impulse: float = parameter(
        0.0, unit="N s", low=0.0, high=1000.0, doc="force times duration; 0 is no push", late=True
    )
    direction: float = parameter(
        0.0,
        unit="deg",
        low=-360.0,
        high=360.0,
        doc="where it pushes to, seen from above, from where the gait means the robot to face: "
        "0 forwards, 90 to the left, 180 backwards",
        late=True,
    )
    cycle: int = parameter(
        3,
        unit="-",
        low=1,
        high=10_000,
        doc="cycle in which it begins, after the start-up",
        late=True,
    )
    instant: float = parameter(
        0.25, unit="-", low=0.0, high=1.0, doc="phase of that cycle at which it begins", late=True
    )
    duration: float = parameter(
        0.05,
        unit="s",
        low=1e-4,
        high=1.0,
        source="assumption: short beside a step and longer than a knock",
        doc="how long it lasts",
        late=True,
    )

    def begin(self, startup_time: float, gait_period: float) -> float:
        """When it begins, in [s] from the start of the trial.

        Args:
            startup_time: Of the gait, in [s].
            gait_period: Likewise.
        """
        return startup_time + (self.cycle - 1 + self.instant) * gait_period

    def force(self, heading: float, seconds: float) -> Vector:
        """The force of a push that takes so long, in [N].

        Args:
            heading: Where the gait means the robot to face, to the left of x, in [rad].
            seconds: How long it takes, in [s].
        """
        size, angle = self.impulse / seconds, heading + radians(self.direction)
        return size * cos(angle), size * sin(angle), 0.0


# What a file sets and a trial has beside robot, gait, ground and servos, by the file's key.
SETTINGS: Mapping[str, type] = {
    "engine": EngineSettings,
    "horizon": Horizon,
    "spread": Spread,
    "slope": Slope,
    "push": Push,
}
LATE = ("slope", "push")  # of these; left out of a trial's identity where nothing is set
