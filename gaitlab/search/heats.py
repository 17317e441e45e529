"""One batch of candidates, from the first seed to what is told of each.

A batch walks round by round. In a round every candidate that is still in the race walks with the
same seeds on every ground, and only when all have done so is it decided who goes on.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import fsum

from gaitlab.experiment import Experiment, Value
from gaitlab.experiment.study import Study
from gaitlab.search import Candidate, State
from gaitlab.search.entries import Pending
from gaitlab.search.objectives import Evaluation, Outcome, evaluate
from gaitlab.search.racing import Rival, best_of, hopeless
from gaitlab.search.walks import Walk, Walks, walk_of

Shown = Callable[[int, int, Sequence[float]], None]  # number, seeds, objectives so far


@dataclass
class Runner:
    """A candidate in the race.

    Attributes:
        entry: The candidate.
        walk: Its trials.
        seeds: Seeds that it has walked with.
        reason: Why it was given up; empty while it is in the race.
    """

    entry: Pending
    walk: Walk
    seeds: int = 0
    reason: str = ""


@dataclass(frozen=True, kw_only=True)
class Heats:
    """How batches of one study are walked.

    Attributes:
        experiment: The study.
        walks: Trials.
        shown: Is shown what a candidate is worth after every round.
        alive: Is told how many candidates are in the race.
    """

    experiment: Experiment
    walks: Walks
    shown: Shown
    alive: Callable[[int], None]

    @property
    def study(self) -> Study:
        """What is searched."""
        if self.experiment.study is None:
            raise ValueError(f"{self.experiment.name} is no study")
        return self.experiment.study

    @property
    def rounds(self) -> tuple[int, ...]:
        """Seeds at the end of every round."""
        racing = self.study.racing
        return racing.rounds if racing else (len(self.experiment.seeds),)

    def run(self, batch: Sequence[Pending], best: Sequence[Rival]) -> list[Candidate]:
        """What becomes of a batch.

        Args:
            batch: The candidates.
            best: The best that were told before, to race against.

        Raises:
            Stopped: If somebody has pressed Ctrl-C.
        """
        runners = [Runner(entry, walk_of(self.experiment, entry.values)) for entry in batch]
        for runner in runners:
            runner.reason = runner.walk.refusal
        for place, seeds in enumerate(self.rounds):
            racing = [runner for runner in runners if not runner.reason]
            self.alive(len(racing))
            self._round(racing, place, seeds)
            if seeds < self.rounds[-1]:
                self._judge(racing, best)
        return [self._candidate(runner) for runner in runners]

    def rival(self, candidate: Candidate) -> Rival | None:
        """A candidate to race against, if its trials are in this store."""
        trials = walk_of(self.experiment, candidate.values).first(self.experiment.seeds)
        if not all(map(self.walks.has, trials)):
            return None
        return Rival(number=candidate.number, outcomes=[self.walks.outcome(t) for t in trials])

    def _round(self, racing: Sequence[Runner], place: int, seeds: int) -> None:
        every = list(self.experiment.seeds)
        wanted = [item for runner in racing for item in runner.walk.first(every[:seeds])]
        following = self.rounds[place + 1] if place + 1 < len(self.rounds) else seeds
        promising = sorted(racing, key=lambda runner: self._promise(runner))
        ahead = [t for runner in promising for t in runner.walk.first(every[seeds:following])]
        self.walks.walk(wanted, ahead)
        for runner in racing:
            runner.seeds = seeds

    def _promise(self, runner: Runner) -> tuple[float, ...]:
        """Sorts the candidates that will probably go on to the front."""
        if not runner.seeds:
            return ()
        found = self._evaluation(runner)
        missed = fsum(max(0.0, violation) for violation in found.violations)
        signs = [1.0 if o.direction == "minimize" else -1.0 for o in self.study.objectives]
        return (missed, *(s * v for s, v in zip(signs, found.objectives, strict=True)))

    def _judge(self, racing: Sequence[Runner], best: Sequence[Rival]) -> None:
        places = [(name, seed) for name in self.experiment.parts.surfaces for seed in self._seeds()]
        rivals = best or best_of(self.study, [self._as_rival(runner) for runner in racing])
        for runner in racing:
            others = [rival for rival in rivals if rival.number != runner.entry.number]
            runner.reason = hopeless(self.study, self._outcomes(runner), places, others)
            self.shown(runner.entry.number, runner.seeds, self._evaluation(runner).objectives)

    def _seeds(self) -> list[int]:
        return list(self.experiment.seeds)[: self.rounds[-1]]

    def _as_rival(self, runner: Runner) -> Rival:
        return Rival(number=runner.entry.number, outcomes=self._outcomes(runner))

    def _outcomes(self, runner: Runner) -> list[Outcome]:
        if runner.walk.refusal:
            return list(self._refused())
        return [
            self.walks.outcome(item) for item in runner.walk.first(self._seeds()[: runner.seeds])
        ]

    def _refused(self) -> Iterator[Outcome]:
        """Values that robot or gait refuse count like poses out of reach."""
        for surface in self.experiment.parts.surfaces:
            yield Outcome(surface=surface, seed=0, state="INFEASIBLE", metrics={})

    def _evaluation(self, runner: Runner) -> Evaluation:
        return evaluate(self.study, self._outcomes(runner))

    def _candidate(self, runner: Runner) -> Candidate:
        outcomes, found = self._outcomes(runner), self._evaluation(runner)
        trials = runner.walk.first(self._seeds()[: runner.seeds])
        infeasible = any(outcome.state == "INFEASIBLE" for outcome in outcomes)
        return Candidate(
            number=runner.entry.number,
            values=runner.entry.values,
            state=_state(infeasible, runner.seeds == self.rounds[-1]),
            objectives=found.objectives,
            violations=found.violations,
            feasible=found.feasible,
            seeds=runner.seeds,
            trial_ids=tuple(item.trial.id for item in trials),
            batch=runner.entry.batch,
            simulated=fsum(self.walks.time(item) for item in trials),
            reason=runner.reason,
        )


def _state(infeasible: bool, every_seed: bool) -> State:
    if infeasible:
        return "infeasible"
    return "done" if every_seed else "pruned"


def values_text(values: Mapping[str, Value]) -> str:
    """Values for a message: `gait.step_height = 0.03, ...`."""
    return ", ".join(f"{path} = {value}" for path, value in values.items())
