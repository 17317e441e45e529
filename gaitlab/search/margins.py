"""How far one parameter may move from the winner before the robot falls.

Outwards from the winner in growing steps until one is too far, then halving the last gap. Which
step is next is a pure function of what was walked so far, so a killed run finds its place again in
the store. All steps are one experiment that grows.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from gaitlab.errors import GaitlabError
from gaitlab.experiment import Experiment, Value
from gaitlab.experiment.plan import plan
from gaitlab.experiment.study import Choices, Numbers
from gaitlab.search.candidates import Candidate, History
from gaitlab.search.final import confirming
from gaitlab.search.fresh import WINNER, Run, derived, margin_seeds, rerun
from gaitlab.search.objectives import TrialOutcome, missing
from gaitlab.store import Store

MarginEnding = Literal[
    "fell",
    "out of reach",
    "a walk failed",
    "no fall found",
    "not walked yet",
    "limit of the parameter",
]
Verdict = Literal["holds", "fell", "out of reach", "failed"]
ENDINGS: dict[Verdict, MarginEnding] = {  # of a step that does not hold
    "fell": "fell",
    "out of reach": "out of reach",
    "failed": "a walk failed",
}
RUNGS = (0.05, 0.15, 0.45)  # of the searched range, from the winner
HALVINGS = 2  # of the gap between the last step that holds and the first that does not
MOST_STEPS = len(RUNGS) + HALVINGS  # of one parameter one way


@dataclass(frozen=True, kw_only=True)
class Reach:
    """How far a parameter moves one way from the winner, everything else kept.

    Attributes:
        holds: Farthest value, in the parameter's unit, up to which no seed fell that stays up at
            the winner; the winner's own value if the first step is too far.
        fails: Nearest value at which one fell; None if none was found.
        ending: Why it goes no farther.
    """

    holds: float
    fails: float | None
    ending: MarginEnding


@dataclass(frozen=True, kw_only=True)
class Margin:
    """How far one parameter can move before the robot falls.

    Attributes:
        path: Dotted path.
        value: The winner's value.
        below: Towards smaller values.
        above: Towards larger values.
    """

    path: str
    value: float
    below: Reach
    above: Reach


@dataclass(frozen=True, kw_only=True)
class Switch:
    """Whether the robot stays up with another option of a choice, everything else kept.

    Attributes:
        path: Dotted path.
        value: The winner's option.
        holds: Option to whether no seed fell that stays up at the winner.
    """

    path: str
    value: Value
    holds: Mapping[Value, bool]


@dataclass(frozen=True, kw_only=True)
class Margins:
    """Stability around the winner, one parameter at a time.

    Attributes:
        numbers: Of the parameters that are numbers.
        switches: Of those that are choices.
        seeds: How many seeds stay up at the winner on the study's grounds and were walked at
            every step; none means that nothing can be said.
        complete: Whether every step that is needed was walked.
    """

    numbers: tuple[Margin, ...] = ()
    switches: tuple[Switch, ...] = ()
    seeds: int = 0
    complete: bool = True


def ladder(
    item: Numbers, value: float, sign: Literal[-1, 1], low: float | None, high: float | None
) -> tuple[float, ...]:
    """Values to try, outwards from the winner's, in the parameter's unit.

    They may leave the searched range, not what the parameter itself allows.

    Args:
        item: The searched parameter.
        value: The winner's value.
        sign: Which way.
        low: Smallest value the parameter allows; None for no bound.
        high: Largest value the parameter allows; None for no bound.
    """
    steps = (on_grid(item, value, _moved(item, value, sign * share)) for share in RUNGS)
    clipped = (min(max(step, _or(low, -math.inf)), _or(high, math.inf)) for step in steps)
    return tuple(dict.fromkeys(step for step in clipped if (step - value) * sign > 0))


def _or(bound: float | None, otherwise: float) -> float:
    return otherwise if bound is None else bound


def _moved(item: Numbers, value: float, share: float) -> float:
    """A value moved by a share of the range, of its ratios if the search is by ratio."""
    if item.log:
        return float(value * (item.high / item.low) ** share)
    return value + share * (item.high - item.low)


def on_grid(item: Numbers, value: float, other: float) -> float:
    """The allowed value nearest to another one, at least one step from the winner's."""
    step = item.step or (1.0 if item.integer else 0.0)
    if not step:
        return float(f"{other:.6g}")  # digits beyond are nobody's to set
    count = round((other - value) / step) or math.copysign(1.0, other - value)
    return value + count * step


def halfway(item: Numbers, holds: float, fails: float) -> float | None:
    """Value between two; None if the grid has none."""
    middle = math.sqrt(holds * fails) if item.log else (holds + fails) / 2.0
    middle = on_grid(item, holds, middle)
    between = min(holds, fails) < middle < max(holds, fails)
    return middle if between else None


def next_step(
    item: Numbers, value: float, rungs: Sequence[float], walked: Mapping[float, Verdict]
) -> float | None:
    """Value to walk next; None when the limit is known as finely as asked."""
    holds, fails = _outwards(value, rungs, walked)
    waiting = next((rung for rung in rungs if rung not in walked), None)
    return waiting if fails is None else _halved(item, holds, fails, walked)[2]


def _halved(
    item: Numbers, holds: float, fails: float, walked: Mapping[float, Verdict]
) -> tuple[float, float, float | None]:
    """The ends of a gap after the halvings that were walked, and the value of the next one."""
    for _ in range(HALVINGS):
        middle = halfway(item, holds, fails)
        if middle is None or middle not in walked:
            return holds, fails, middle
        holds, fails = (middle, fails) if walked[middle] == "holds" else (holds, middle)
    return holds, fails, None


def _outwards(
    value: float, rungs: Sequence[float], walked: Mapping[float, Verdict]
) -> tuple[float, float | None]:
    """Last rung that holds before the first that does not, and that one."""
    holds = value
    for rung in rungs:
        verdict = walked.get(rung)
        if verdict is None:
            return holds, None
        if verdict != "holds":
            return holds, rung
        holds = rung
    return holds, None


def reach(
    item: Numbers, value: float, rungs: Sequence[float], walked: Mapping[float, Verdict]
) -> Reach:
    """How far the parameter moves, by what was walked."""
    holds, fails = _outwards(value, rungs, walked)
    if fails is None:
        return Reach(holds=holds, fails=None, ending=_unbroken(rungs, holds))
    holds, fails, _ = _halved(item, holds, fails, walked)
    return Reach(holds=holds, fails=fails, ending=ENDINGS[walked[fails]])


def _unbroken(rungs: Sequence[float], holds: float) -> MarginEnding:
    if not rungs:
        return "limit of the parameter"
    return "no fall found" if holds == rungs[-1] else "not walked yet"


class Around:
    """The walks around a winner, one parameter at a time."""

    def __init__(self, history: History, chosen: Candidate, store: Store, run: Run) -> None:
        self._experiment = confirming(history.experiment)
        self._values = dict(chosen.values)
        self._store, self._run = store, run
        self._seeds = margin_seeds(history.experiment)
        self._verdicts: dict[tuple[str, Value], Verdict] = {}
        searched = [item for item in history.study.search if item.path in self._values]
        self._numbers = [item for item in searched if isinstance(item, Numbers)]
        self._choices = [item for item in searched if isinstance(item, Choices)]

    def margins(self) -> tuple[Margins, bool]:
        """What is known after walking what `run` walks, and whether that was stopped."""
        winner = self._row_experiment([tuple(self._values.values())])
        if missing(winner, self._store.index()):
            self._run(winner)
        walks = rerun(WINNER, winner, self._store.index()).walks
        upright = frozenset((walk.surface, walk.seed) for walk in walks if walk.stable)
        if not upright:
            return Margins(), False
        stopped, complete = False, True
        while steps := list(self._steps()):
            going = self._walk_all(steps)
            self._judge(steps, upright)
            if not all(step in self._verdicts for step in steps):
                stopped, complete = not going, False
                break
        found = Margins(
            numbers=tuple(self._margin(item) for item in self._numbers),
            switches=tuple(self._switch(item) for item in self._choices),
            seeds=len(upright),
            complete=complete,
        )
        return found, stopped

    def _row_experiment(self, rows: Sequence[Sequence[Value]]) -> Experiment:
        return derived(self._experiment, "margins", tuple(self._values), rows, self._seeds)

    def _rungs(self, item: Numbers) -> dict[int, tuple[float, ...]]:
        known = self._experiment.parts.parameter(item.path)
        value = float(self._values[item.path])
        return {
            -1: ladder(item, value, -1, known.low, known.high),
            1: ladder(item, value, 1, known.low, known.high),
        }

    def _steps(self) -> Iterator[tuple[str, Value]]:
        """Every value to walk next, each parameter both ways at once."""
        for item in self._numbers:
            for rungs in self._rungs(item).values():
                walked = self._walked(item.path)
                step = next_step(item, float(self._values[item.path]), rungs, walked)
                if step is not None:
                    yield item.path, round(step) if item.integer else step
        for choice in self._choices:
            for option in choice.options:
                known = (choice.path, option) in self._verdicts
                if not known and option != self._values[choice.path]:
                    yield choice.path, option

    def _walked(self, path: str) -> dict[float, Verdict]:
        return {float(value): v for (of, value), v in self._verdicts.items() if of == path}

    def _row(self, step: tuple[str, Value]) -> tuple[Value, ...]:
        return tuple({**self._values, step[0]: step[1]}.values())

    def _walk_all(self, steps: Sequence[tuple[str, Value]]) -> bool:
        """Walk every step that the gait does not refuse, listing those before them too."""
        for step in steps:
            if self._refused(step):
                self._verdicts[step] = "out of reach"
        tried = [*self._verdicts, *steps]
        rows = [self._row(s) for s in dict.fromkeys(tried) if not self._refused(s)]
        wanted = self._row_experiment([tuple(self._values.values()), *rows])
        return self._run(wanted) if missing(wanted, self._store.index()) else True

    def _refused(self, step: tuple[str, Value]) -> bool:
        """Whether the gait or robot itself refuses the values, before any trial."""
        try:
            next(plan(self._row_experiment([self._row(step)])).trials())
        except (GaitlabError, ValueError, ArithmeticError):
            return True
        return False

    def _judge(
        self, steps: Sequence[tuple[str, Value]], upright: frozenset[tuple[str, int]]
    ) -> None:
        index = self._store.index()
        for step in steps:
            if step in self._verdicts:
                continue
            walks = rerun("", self._row_experiment([self._row(step)]), index).walks
            verdict = _verdict([w for w in walks if (w.surface, w.seed) in upright])
            if verdict is not None:
                self._verdicts[step] = verdict

    def _margin(self, item: Numbers) -> Margin:
        value, rungs = float(self._values[item.path]), self._rungs(item)
        walked = self._walked(item.path)
        return Margin(
            path=item.path,
            value=value,
            below=reach(item, value, rungs[-1], walked),
            above=reach(item, value, rungs[1], walked),
        )

    def _switch(self, item: Choices) -> Switch:
        tried = [option for option in item.options if (item.path, option) in self._verdicts]
        holds = {option: self._verdicts[item.path, option] == "holds" for option in tried}
        return Switch(path=item.path, value=self._values[item.path], holds=holds)


def _verdict(walks: Sequence[TrialOutcome]) -> Verdict | None:
    """What a step amounts to; None while walks are missing."""
    states = {walk.state for walk in walks}
    if "MISSING" in states:
        return None
    if "INFEASIBLE" in states:
        return "out of reach"
    if "FAILED" in states:
        return "failed"
    return "holds" if all(walk.stable for walk in walks) else "fell"
