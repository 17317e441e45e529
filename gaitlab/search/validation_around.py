"""The walks around a winner, one parameter at a time, as one experiment that grows."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from gaitlab.errors import GaitlabError
from gaitlab.experiment import Experiment, Value
from gaitlab.experiment.study import Choices, Numbers
from gaitlab.plan import plan
from gaitlab.search import Candidate, History
from gaitlab.search.results import WINNER, Margin, Margins, Switch, Walk
from gaitlab.search.validation_experiments import derived, margin_seeds, missing, rerun
from gaitlab.search.validation_margins import Verdict, ladder, next_step, reach
from gaitlab.store import Store

Run = Callable[[Experiment], bool]  # runs what is missing; False when it was stopped


class Around:
    """The walks around a winner, one parameter at a time."""

    def __init__(self, history: History, chosen: Candidate, store: Store, run: Run) -> None:
        self._experiment, self._study = history.experiment, history.study
        self._values = dict(chosen.values)
        self._store, self._run = store, run
        self._seeds = margin_seeds(history.experiment)
        self._verdicts: dict[tuple[str, Value], Verdict] = {}
        self._numbers = [
            item
            for item in self._study.search
            if isinstance(item, Numbers) and item.path in self._values
        ]
        self._choices = [
            item
            for item in self._study.search
            if isinstance(item, Choices) and item.path in self._values
        ]

    def margins(self) -> tuple[Margins, bool]:
        """What is known after walking what `run` walks, and whether that was stopped."""
        upright = self._upright()
        if not upright:
            return Margins(), False
        stopped, complete = False, True
        while steps := list(self._steps()):
            going = self._walk_all(steps)
            self._judge(steps, upright)
            if not all(step in self._verdicts for step in steps):
                stopped, complete = not going, False
                break
        return self._found(len(upright), complete), stopped

    def _upright(self) -> frozenset[tuple[str, int]]:
        """Ground and seed of the walks in which the winner itself stays up."""
        one = self._row_experiment([tuple(self._values.values())])
        if missing(one, self._store.index()):
            self._run(one)
        walks = rerun(WINNER, one, self._store.index()).walks
        return frozenset((walk.surface, walk.seed) for walk in walks if walk.up)

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
                    yield item.path, self._typed(item, step)
        for choice in self._choices:
            for option in choice.options:
                known = (choice.path, option) in self._verdicts
                if not known and option != self._values[choice.path]:
                    yield choice.path, option

    def _typed(self, item: Numbers, step: float) -> Value:
        return round(step) if item.integer else step

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
        one = self._row_experiment([tuple(self._values.values()), *rows])
        return self._run(one) if missing(one, self._store.index()) else True

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

    def _found(self, seeds: int, complete: bool) -> Margins:
        return Margins(
            numbers=tuple(self._margin(item) for item in self._numbers),
            switches=tuple(self._switch(item) for item in self._choices),
            seeds=seeds,
            complete=complete,
        )

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


def _verdict(walks: Sequence[Walk]) -> Verdict | None:
    """What a step amounts to; None while walks are missing."""
    states = {walk.state for walk in walks}
    if "MISSING" in states:
        return None
    if "INFEASIBLE" in states:
        return "out of reach"
    if "FAILED" in states:
        return "failed"
    return "holds" if all(walk.up for walk in walks) else "fell"
