"""What pushes the robot of a trial in which ticks."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

from gaitlab.log.course import Course
from gaitlab.model import Vector
from gaitlab.simulation.trial import Trial

NOTHING: Vector = (0.0, 0.0, 0.0)


class Pushes:
    """The push of a trial as a force in some ticks, whole ones, so that it adds up to its impulse.

    Attributes:
        first: The tick in which it begins.
        end: The tick after its last; none where nothing pushes.
        force: Its force, world frame, in [N].
    """

    def __init__(self, trial: Trial, course: Course) -> None:
        """Takes a trial and the way that its robot is commanded to go."""
        push, gait, dt = trial.push, trial.gait, trial.engine.dt
        begin = push.begin(gait.startup_time, gait.gait_period)
        ticks = max(1, round(push.duration / dt)) if push.impulse else 0
        self.first = round(begin / dt)
        self.end = self.first + ticks
        heading = course.rate * (begin - gait.startup_time)
        self.force = push.force(heading, ticks * dt) if ticks else NOTHING

    def pieces(self, start: int, stop: int) -> Iterator[tuple[int, int, Vector]]:
        """The ticks from one on, up to another, as stretches of a constant force."""
        edges = sorted({start, stop, *(t for t in (self.first, self.end) if start < t < stop)})
        for low, high in pairwise(edges):
            yield low, high, self.force if self.first <= low < self.end else NOTHING
