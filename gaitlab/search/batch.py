"""One batch of candidates, from the first seed to what became of each, and the workers it needs.

A batch walks racing round by racing round. In a round every candidate that is still in the race
walks with the same seeds on every ground, and only when all have done so is it decided who goes
on. Trials are ordinary ones: what any experiment or search has walked is not walked again.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import fsum

from gaitlab.errors import WrongValue
from gaitlab.experiment import Experiment, Value, candidate, study_of
from gaitlab.experiment.plan import PlannedTrial, plan
from gaitlab.experiment.study import Study
from gaitlab.running.executor import Executor, Job, job_of
from gaitlab.running.executor import Outcome as Ended
from gaitlab.running.pace import Pace
from gaitlab.running.sweep import settle
from gaitlab.search.candidates import Candidate, CandidateState, costs
from gaitlab.search.database import Pending
from gaitlab.search.objectives import (
    Evaluation,
    TrialOutcome,
    evaluate,
    outcome_of,
    stored_outcome,
)
from gaitlab.search.racing import Rival, best_of, hopeless
from gaitlab.simulation.trial import duration
from gaitlab.store import Held, Index, Store


class Stopped(Exception):
    """Somebody pressed Ctrl-C, and what was running has ended."""


@dataclass(frozen=True)
class CandidateTrials:
    """What a candidate would have to walk.

    Attributes:
        trials: Its trials by seed; empty if the values are refused.
        refusal: Why nothing can be walked; empty if it can.
    """

    trials: Mapping[int, Sequence[PlannedTrial]]
    refusal: str = ""

    def of(self, seeds: Sequence[int]) -> list[PlannedTrial]:
        """Trials of some seeds on every ground, seed by seed."""
        return [item for seed in seeds for item in self.trials.get(seed, ())]


def candidate_trials(experiment: Experiment, values: Mapping[str, Value]) -> CandidateTrials:
    """The trials of a candidate; what robot or gait refuse is a finding and no mistake."""
    trials: dict[int, list[PlannedTrial]] = {}
    try:
        for item in plan(candidate(experiment, values)).trials():
            trials.setdefault(item.trial.seed, []).append(item)
    except (WrongValue, ValueError, ArithmeticError) as error:
        return CandidateTrials({}, " ".join(str(error).split()))
    return CandidateTrials(trials)


@dataclass
class TrialRunner:
    """Results of trials, from the store or from workers that live as long as the search.

    Attributes:
        store: Where trials are kept.
        held: The store's lock.
        executor: Runs trials.
        workers: How many at a time.
        walked: Called after every trial that was walked.
        count: Trials that were walked.
        seconds: Simulated time of those, in [s].
        pace: How fast they were, for the next time that somebody asks how long it takes.
    """

    store: Store
    held: Held
    executor: Executor
    workers: int
    walked: Callable[[], None]
    count: int = 0
    seconds: float = 0.0
    pace: Pace = field(default_factory=Pace.here)
    _queue: deque[Job] = field(default_factory=deque)
    _under_way: dict[str, PlannedTrial] = field(default_factory=dict)
    _made: dict[str, TrialOutcome] = field(default_factory=dict)

    @cached_property
    def _index(self) -> Index:
        return self.store.compact()

    @cached_property
    def _ended(self) -> Generator[Ended, None, None]:
        return self.executor.run(_Queued(self._queue))

    def close(self) -> None:
        """End the workers, whatever they do."""
        self._ended.close()
        self.pace.save()

    def has(self, item: PlannedTrial) -> bool:
        """Whether a trial is in the store."""
        return item.trial.id in self._made or item.trial.id in self._index.entries

    def made(self, trial_id: str) -> bool:
        """Whether a trial was walked by this run."""
        return trial_id in self._made

    def outcome(self, item: PlannedTrial) -> TrialOutcome:
        """What became of a trial that is in the store."""
        return self._made.get(item.trial.id) or stored_outcome(item, self._index)

    def time(self, item: PlannedTrial) -> float:
        """Simulated time of a trial that is in the store, in [s]; 0 if it was not simulated."""
        outcome = self.outcome(item)
        if not outcome.walked:
            return 0.0
        time = outcome.metrics.get("time_to_fall" if outcome.fell else "walked_time")
        return item.trial.gait.startup_time + (time if isinstance(time, int | float) else 0.0)

    def walk(self, wanted: Sequence[PlannedTrial], ahead: Sequence[PlannedTrial] = ()) -> None:
        """See to it that trials are in the store.

        Args:
            wanted: The trials.
            ahead: Those that will probably be wanted next; a worker that would otherwise wait
                for the last of the wanted ones may begin with them.

        Raises:
            Stopped: If the executor takes no more; the trials that ran are kept.
        """
        missing = {item.trial.id: item for item in wanted if not self.has(item)}
        for item in missing.values():
            self._submit(item)
        later = (item for item in ahead if not self.has(item))
        while missing:
            while not self._queue and len(self._under_way) < self.workers:
                item_ahead = next(later, None)
                if item_ahead is None:
                    break
                self._submit(item_ahead)
            ended = next(self._ended, None)
            if ended is None:
                raise Stopped
            missing.pop(self._keep(ended), None)

    def _submit(self, item: PlannedTrial) -> None:
        trial_id = item.trial.id
        if trial_id not in self._under_way:
            self._under_way[trial_id] = item
            seconds = duration(item.trial.gait, item.trial.horizon)
            self._queue.append(job_of(trial_id, item.trial.to_dict(), seconds))

    def _keep(self, ended: Ended) -> str:
        self.held.check()
        record = ended.record or settle(self.store, ended)
        self.store.note(record)
        item = self._under_way.pop(record.trial_id)
        self.pace.learn(item.trial, record)
        self._made[record.trial_id] = outcome_of(item, record.state, record.metrics)
        self.count += 1
        self.seconds += self.time(item)
        self.walked()
        return record.trial_id


class _Queued(Iterator[Job]):
    """Jobs as long as there are some; more may come later."""

    def __init__(self, queue: deque[Job]) -> None:
        self._queue = queue

    def __next__(self) -> Job:
        if not self._queue:
            raise StopIteration
        return self._queue.popleft()


@dataclass
class Racer:
    """A candidate in the race.

    Attributes:
        pending: The candidate.
        trials: What it would have to walk.
        seeds: How many seeds it has walked with.
        reason: Why it was given up; empty while it is in the race.
    """

    pending: Pending
    trials: CandidateTrials
    seeds: int = 0
    reason: str = ""


@dataclass(frozen=True, kw_only=True)
class Race:
    """How batches of one study are walked.

    Attributes:
        experiment: The study.
        runner: Results of trials.
        report: Is given number, seeds and objectives of a candidate after every round.
        alive: Is given how many candidates are in the race.
    """

    experiment: Experiment
    runner: TrialRunner
    report: Callable[[int, int, Sequence[float]], None]
    alive: Callable[[int], None]

    @property
    def study(self) -> Study:
        """What is searched."""
        return study_of(self.experiment)

    @property
    def rounds(self) -> tuple[int, ...]:
        """How many seeds were walked at the end of every round."""
        racing = self.study.racing
        return racing.rounds if racing else (len(self.experiment.seeds),)

    def run(self, batch: Sequence[Pending], best: Sequence[Rival]) -> list[Candidate]:
        """What becomes of a batch.

        Args:
            batch: The candidates.
            best: The best of those before, to race against.

        Raises:
            Stopped: If somebody has pressed Ctrl-C.
        """
        racers = [Racer(item, candidate_trials(self.experiment, item.values)) for item in batch]
        for racer in racers:
            racer.reason = racer.trials.refusal
        for number, seeds in enumerate(self.rounds):
            racing = [racer for racer in racers if not racer.reason]
            self.alive(len(racing))
            self._walk_round(racing, number)
            if seeds < self.rounds[-1]:
                self._judge(racing, best)
        return [self._candidate(racer) for racer in racers]

    def rival(self, candidate: Candidate) -> Rival | None:
        """A candidate to race against, if its trials are in this store."""
        trials = candidate_trials(self.experiment, candidate.values).of(self.experiment.seeds)
        if not all(map(self.runner.has, trials)):
            return None
        return Rival(number=candidate.number, outcomes=list(map(self.runner.outcome, trials)))

    def _walk_round(self, racing: Sequence[Racer], number: int) -> None:
        every, seeds = list(self.experiment.seeds), self.rounds[number]
        wanted = [item for racer in racing for item in racer.trials.of(every[:seeds])]
        following = every[seeds : next(iter(self.rounds[number + 1 :]), seeds)]
        promising = sorted(racing, key=self._promise)
        ahead = [item for racer in promising for item in racer.trials.of(following)]
        self.runner.walk(wanted, ahead)
        for racer in racing:
            racer.seeds = seeds

    def _promise(self, racer: Racer) -> tuple[float, ...]:
        """Sorts the candidates that will probably go on to the front."""
        if not racer.seeds:
            return ()
        evaluation = self._evaluation(racer)
        missed = fsum(max(0.0, violation) for violation in evaluation.violations)
        return (missed, *costs(self.study, evaluation.objectives))

    def _judge(self, racing: Sequence[Racer], best: Sequence[Rival]) -> None:
        places = [(name, seed) for name in self.experiment.parts.surfaces for seed in self._seeds()]
        own = [Rival(number=r.pending.number, outcomes=self._outcomes(r)) for r in racing]
        rivals = best or best_of(self.study, own)
        for racer in racing:
            number = racer.pending.number
            others = [rival for rival in rivals if rival.number != number]
            racer.reason = hopeless(self.study, self._outcomes(racer), places, others)
            self.report(number, racer.seeds, self._evaluation(racer).objectives)

    def _seeds(self) -> list[int]:
        return list(self.experiment.seeds)[: self.rounds[-1]]

    def _walked(self, racer: Racer) -> list[PlannedTrial]:
        return racer.trials.of(self._seeds()[: racer.seeds])

    def _outcomes(self, racer: Racer) -> list[TrialOutcome]:
        if racer.trials.refusal:  # counts like poses out of reach
            return [
                TrialOutcome(surface=surface, seed=0, state="INFEASIBLE", metrics={})
                for surface in self.experiment.parts.surfaces
            ]
        return list(map(self.runner.outcome, self._walked(racer)))

    def _evaluation(self, racer: Racer) -> Evaluation:
        return evaluate(self.study, self._outcomes(racer))

    def _candidate(self, racer: Racer) -> Candidate:
        evaluation, trials = self._evaluation(racer), self._walked(racer)
        state: CandidateState = "done" if racer.seeds == self.rounds[-1] else "pruned"
        if any(outcome.state == "INFEASIBLE" for outcome in self._outcomes(racer)):
            state = "infeasible"
        return Candidate(
            number=racer.pending.number,
            values=racer.pending.values,
            state=state,
            objectives=evaluation.objectives,
            violations=evaluation.violations,
            feasible=evaluation.feasible,
            seeds=racer.seeds,
            trial_ids=tuple(item.trial.id for item in trials),
            batch=racer.pending.batch,
            simulated=fsum(map(self.runner.time, trials)),
            reason=racer.reason,
        )
