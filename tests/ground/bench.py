"""A sled on two soles: the plate, weight and spring scale of a turf laboratory, in a real engine.

Two flat soles hang rigidly below a beam, so that what is measured is the ground and nothing else.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from gaitlab.model import Box, Joint, Link, Tree, standing
from gaitlab.model.servo import Servo
from gaitlab.model.settings import EngineName, EngineSettings, Spread
from gaitlab.model.soles import Sole
from gaitlab.simulation.engines import engine_named
from gaitlab.simulation.tape import Tape
from gaitlab.surfaces import Surface
from gaitlab.surfaces.files import load_surface
from tests.driven import endless

GRAVITY = 9.81
AREA = 0.125 * 0.080  # m^2 of one sole
ENGINE: EngineName = "bullet"  # that a bench stands in if none is named
STILL = Spread(friction=0.0, servo_gain=0.0, tilt=0.0, position=0.0, terrain=0.0)
PEDESTALS = ("grass_50mm", "grass_30mm", "grass_10mm", "carpet_4mm")
LOCK = Servo(
    stall_torque=60.0, no_load_speed=20.0, voltage=12.0, supply=12.0, torque_limit=1.0,
    position_gain=60.0, latency=0.0, resolution=0.0, backlash=0.0, mass=0.0,
)  # fmt: skip


def surface(name: str, **changes: float) -> Surface:
    return replace(load_surface(name), **changes)


@dataclass(frozen=True)
class Sled:
    """Satisfies `gaitlab.model.Robot` as far as the engine asks."""

    mass: float = 3.5
    kind: str = "studs"
    pitch: float = 0.0
    grid: tuple[int, int] = (4, 3)
    gantry: str = "none"
    name: str = "sled"
    feet: tuple[str, str] = ("left_foot", "right_foot")
    sole: Sole = field(init=False)
    tree: Tree = field(init=False)

    def __post_init__(self) -> None:
        sole = Sole(
            length=0.125, width=0.080, heel=0.0625, height=0.038, kind=self.kind,
            supports_along=self.grid[0], supports_across=self.grid[1],
        )  # fmt: skip
        beam = Link(
            name="beam", parent=None, origin=(0.0, 0.0, 0.0), joint=None, mass=self.mass - 0.24,
            box=Box(size=(0.10, 0.30, 0.02), centre=(0.0, 0.0, 0.0)),
        )  # fmt: skip
        feet = [
            Link(
                name=f"{side}_foot", parent="beam", origin=(0.0, y, 0.0), mass=0.12,
                joint=Joint(name=f"{side}_hinge", axis="y", lower=-0.6, upper=0.6, servo="mx_64"),
                box=Box(size=(0.125, 0.08, 0.01), centre=(0.0, 0.0, -0.033)),
            )
            for side, y in (("left", 0.1), ("right", -0.1))
        ]  # fmt: skip
        object.__setattr__(self, "sole", sole)
        object.__setattr__(self, "tree", Tree((beam, *feet)))


class Bench:
    """A sled on a surface, and the instruments on it.

    Attributes:
        last: What the last tick gave.
    """

    def __init__(
        self, surface: Surface, sled: Sled, *, gap: float, dt: float = 0.002,
        spread: Spread = STILL, seed: int = 0, engine: EngineName | None = None,
        gravity: tuple[float, float, float] = (0.0, 0.0, -GRAVITY),
    ) -> None:  # fmt: skip
        self.dt, self.sled, engine = dt, sled, engine or ENGINE
        self.pose = np.full(2, sled.pitch)
        self.engine = engine_named(engine)(
            sled, surface, (LOCK, LOCK), start=standing(sled, self.pose, gap=gap),
            settings=EngineSettings(name=engine, dt=dt), spread=spread, seed=seed,
            gravity=gravity,
        )  # fmt: skip
        self._ending, self._joints = endless(), 2 + (sled.gantry != "none")
        self.last = Tape(0, self._joints)

    def __enter__(self) -> Bench:
        return self

    def __exit__(self, *_: object) -> None:
        self.engine.__exit__()

    def tick(self, force: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> None:
        """One tick with a force on the middle of the beam, in [N]."""
        self.last = Tape(1, self._joints)
        self.engine.pull(force)
        self.engine.advance(self.pose[None], self.last, self._ending)

    def run(self, seconds: float, force: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> None:
        for _ in range(round(seconds / self.dt)):
            self.tick(force)

    def pull(self, speed: float, gain: float = 2000.0) -> float:
        """Pull along x towards a speed [m/s] for a tick; returns the force used, in [N]."""
        force = gain * (speed - float(self.engine.trunk[7]))
        self.tick((force, 0.0, 0.0))
        return force

    @property
    def gap(self) -> float:
        """Gap under the middle of the soles, in [m]."""
        return float(self.engine.trunk[2]) - 0.038

    @property
    def plough(self) -> float:
        """Plough force on both feet along x, in [N]."""
        return float(self.last.plough[-1, :, 0].sum())

    def energy(self) -> float:
        """Kinetic and potential energy of the beam and feet as one body, in [J]."""
        trunk = self.engine.trunk
        speed = float(np.dot(trunk[7:10], trunk[7:10]))
        return 0.5 * self.sled.mass * speed + self.sled.mass * GRAVITY * float(trunk[2])
