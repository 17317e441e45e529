"""What a trial asks of a physics engine, whichever it is.

An engine is made for one trial and thrown away, so that equal trials give equal logs, bit for bit.
All engines draw the same numbers for the same seed (`replicate`), so that a trial in one can be
paired with the same trial in another.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol

import numpy as np

from gaitlab.model import Robot, Start, Vector
from gaitlab.model.randomness import randomness
from gaitlab.model.servo import Servo
from gaitlab.model.settings import EngineSettings, Slope, Spread
from gaitlab.servos.latency import unequally_late
from gaitlab.simulation.ending import Ending
from gaitlab.simulation.tape import Tape
from gaitlab.surfaces.surface import Surface

DOWN: Vector = Slope().gravity  # on the level


class Engine(Protocol):
    """A robot on its servos and its ground, standing, ready to be commanded."""

    def __init__(
        self,
        robot: Robot,
        surface: Surface,
        servos: Sequence[Servo],
        *,
        start: Start,
        settings: EngineSettings,
        spread: Spread,
        seed: int,
        gravity: Vector = DOWN,
    ) -> None:
        """Build the world.

        Args:
            robot: The robot.
            surface: The ground.
            servos: One per driven joint, in the order of the robot's tree.
            start: Where the robot stands; on a pile it is lifted to where that carries it.
            settings: Time step and solver.
            spread: How far this replicate may differ from the nominal robot.
            seed: Seed of the replicate.
            gravity: In [m/s^2]; the ground is the plane z = 0, however gravity leans.

        Raises:
            WrongValue: If this engine cannot carry a part of the robot; says which.
        """

    def __enter__(self) -> Engine: ...

    def __exit__(self, *_: object) -> None: ...

    @property
    def trunk(self) -> np.ndarray:
        """The trunk as it is now, as a row of the tape. Shape (13,)."""

    def advance(self, targets: np.ndarray, tape: Tape, ending: Ending) -> int:
        """Walk on for as many ticks as there are targets, or until the trial ends.

        A target acts after the latency of each servo. `advance` of n rows is n times `advance` of
        one, bit for bit.

        Args:
            targets: What the servos are sent in each tick, in [rad]; a joint without a servo
                ignores it. Shape (ticks, joints).
            tape: Receives what happens, from its `length` on.
            ending: Says after every tick whether that was the last.

        Returns:
            What `ended` said of the last tick.
        """

    def pull(self, force: Vector) -> None:
        """Pull at the trunk's centre of mass from now on, world frame, in [N]."""


class Replicate(NamedTuple):
    """What one seed makes of the nominal robot and ground, the same in every engine.

    Attributes:
        friction: Coefficient between the soles and the ground.
        servos: The servos, each with its own latency.
        gain: Factor on the position gain of each servo. Shape (servos,).
        terrain: Stream of the pile's irregularity.
    """

    friction: float
    servos: Sequence[Servo]
    gain: np.ndarray
    terrain: np.random.Generator


def replicate(surface: Surface, servos: Sequence[Servo], spread: Spread, seed: int) -> Replicate:
    """Draw what belongs to a seed; each quantity has a stream of its own."""
    streams = randomness(seed)
    slip = 1.0 + spread.friction * streams.friction.uniform(-1.0, 1.0)
    gain = 1.0 + spread.servo_gain * streams.servo.uniform(-1.0, 1.0, len(servos))
    late = unequally_late(servos, spread.servo_latency, streams.servo)
    friction = float(surface.friction * surface.friction_scale * slip)
    return Replicate(friction, late, gain, streams.terrain)
