"""What a metric is: a pure function of the log, and what tables and comparisons need of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from inspect import getdoc
from typing import Generic, Literal, TypeAlias, TypeVar, get_type_hints

from gaitlab.log import TrialLog

Value: TypeAlias = float | bool | int | str | None
Better: TypeAlias = Literal["higher", "lower", "neither"]
V = TypeVar("V", bound=Value, covariant=True)

REQUISITES = {  # what a trial may have to have, as the end of a sentence
    "gantry": "a robot on a gantry",
    "couplings": "a robot with belts or gears between joints",
    "force sensors": "a robot with force sensors in its soles",
    "distance": "a gait that is commanded to get ahead",
    "cycle": "a horizon of at least one whole cycle of the gait",
}


@dataclass(frozen=True)
class Metric(Generic[V]):
    """A number, flag or word that a trial is judged by; call it with a log.

    Attributes:
        function: From a log to its value. It reads nothing else and raises nothing: what is not
            defined for a log is NaN, or None for words.
        unit: SI unit, `-` for counts, flags, ratios and words.
        better: Which way a walk gets better; `neither` takes no side in a comparison.
        counts_falls: Whether a fall shortens what is measured as it should; other metrics compare
            only walks that went on.
        needs: Those of `REQUISITES` without which it has no value whatever happens.
    """

    function: Callable[[TrialLog], V]
    unit: str
    better: Better = "neither"
    counts_falls: bool = False
    needs: tuple[str, ...] = ()

    def __call__(self, log: TrialLog) -> V:
        """Its value for a log."""
        return self.function(log)

    @property
    def name(self) -> str:
        """The name of its function."""
        return self.function.__name__

    @property
    def doc(self) -> str:
        """What it is, the docstring of its function."""
        return getdoc(self.function) or ""

    @property
    def kind(self) -> type:
        """What it gives: float, int, bool or str.

        Raises:
            NameError, TypeError: If the annotation of its function cannot be read.
        """
        kind = get_type_hints(self.function).get("return")
        if kind == str | None:
            return str
        return kind if kind in (float, int, bool, str) else type(None)


def metric(
    *,
    unit: str,
    better: Better = "neither",
    counts_falls: bool = False,
    needs: tuple[str, ...] = (),
) -> Callable[[Callable[[TrialLog], V]], Metric[V]]:
    """Make a metric of a function; see the attributes of `Metric`."""

    def made(function: Callable[[TrialLog], V]) -> Metric[V]:
        return Metric(function, unit, better, counts_falls, needs)

    return made
