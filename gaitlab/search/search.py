"""The search: ask for a batch, walk it, tell what became of it, until there are enough.

A batch is asked for when everything before it is finished, from a seed that hangs on the study
alone, and all of it is told before the next. So what a search finds does not depend on how many
workers there are, on which trial ends first, or on how often it was killed; only several processes
that share a search are free to interleave.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from contextlib import closing, suppress
from dataclasses import dataclass, field, replace
from signal import SIGINT
from typing import Literal, TypeAlias

from gaitlab.experiment import Experiment, study_of
from gaitlab.experiment.study import Study
from gaitlab.running.basis import basis
from gaitlab.running.executor import Cluster, Considerate, Executor
from gaitlab.running.processes import executor
from gaitlab.running.signals import stoppable
from gaitlab.search import heartbeat
from gaitlab.search.batch import Race, Stopped, TrialRunner
from gaitlab.search.candidates import Candidate, History
from gaitlab.search.database import Database, Pending, asks_for
from gaitlab.search.sampling import ask
from gaitlab.search.space import base_values, key
from gaitlab.simulation.engines import require_engine
from gaitlab.store import Held, Listed, Store
from gaitlab.store.store import TABLE_FROM

# Why a search has ended: all candidates are finished; no improvement for long; the space holds no
# more; another process walks the last ones; somebody pressed Ctrl-C.
SearchEnding: TypeAlias = Literal["complete", "no improvement", "exhausted", "elsewhere", "stopped"]


@dataclass(frozen=True, kw_only=True)
class SearchStatus:
    """A search at an instant.

    Attributes:
        history: The finished candidates.
        total: Candidates to try.
        walking: Candidates of the batch under way.
        alive: Of those, how many were not given up.
        walked: Trials that this run has simulated.
        simulated: Their simulated time, in [s].
        seconds: Wall time of this run, in [s].
        begun: Candidates that were finished before this run.
    """

    history: History
    total: int
    walking: int = 0
    alive: int = 0
    walked: int = 0
    simulated: float = 0.0
    seconds: float = 0.0
    begun: int = 0

    @property
    def finished(self) -> int:
        """Candidates that are finished."""
        return len(self.history.candidates)

    def count(self, state: str) -> int:
        """Candidates that are finished in a state."""
        return sum(candidate.state == state for candidate in self.history.candidates)

    @property
    def rate(self) -> float:
        """Simulated seconds per second of wall time."""
        return self.simulated / self.seconds if self.seconds else 0.0

    @property
    def time_left(self) -> float | None:
        """Wall time until the end at the pace of this run, in [s]; None before any is finished."""
        done = self.finished - self.begun
        return self.seconds / done * max(0, self.total - self.finished) if done else None


@dataclass(frozen=True, kw_only=True)
class SearchResult:
    """A search when it has ended or was stopped.

    Attributes:
        status: Where it stands.
        ending: Why it ended.
        cached: Trials of the candidates finished in this run that the store held already.
        elsewhere: Processes that are walking the rest.
        place: Where the database is.
    """

    status: SearchStatus
    ending: SearchEnding
    cached: int
    elsewhere: tuple[str, ...]
    place: str

    @property
    def history(self) -> History:
        """The finished candidates."""
        return self.status.history

    @property
    def over(self) -> bool:
        """Whether there is nothing more to search, here or elsewhere."""
        return self.ending not in ("stopped", "elsewhere")

    def with_history(self, history: History) -> SearchResult:
        """The same after the final."""
        return replace(self, status=replace(self.status, history=history))


class SearchCallback:
    """Is called while a search goes on; does nothing unless a subclass does."""

    def start(self, status: SearchStatus) -> None:
        """It is known where the search stands; nothing has walked."""

    def update(self, status: SearchStatus) -> None:
        """A trial has ended or candidates are finished."""

    def message(self, text: str) -> None:
        """Something the user should know now."""

    def finish(self, status: SearchStatus) -> None:
        """Nothing walks any more."""


def optimize(
    experiment: Experiment,
    store: Store,
    *,
    jobs: int,
    storage: str | None = None,
    callback: SearchCallback | None = None,
    cluster: Cluster | None = None,
) -> SearchResult:
    """Go on with the search of a study until its total of candidates is finished.

    The first Ctrl-C, or SIGTERM, lets the running trials end; the second Ctrl-C kills them. Either
    way the same call goes on from there.

    Args:
        experiment: A study.
        store: Where trials go. Other experiments may be run on it meanwhile, and other processes
            that share this search.
        jobs: Worker processes; 0 walks every trial in this process.
        storage: Address of a database that several machines share; by default a file of the
            store.
        callback: Is called as the search goes on; a terminal that has gone stops no search.
        cluster: Has the workers, instead of `jobs`.

    Raises:
        UsageError: If the experiment is no study, or the sampler's library is missing.
        NoEngine: If an engine that it asks for is not installed.
        StoreError: If another run is at the study, the store or the database cannot be used, or
            the database holds another study of this name.
        KeyboardInterrupt: At the second Ctrl-C.
    """
    study = study_of(experiment)
    for name in experiment.engines | ({study.confirm} if study.confirm else set()):
        require_engine(name)
    wanted = asks_for(experiment, basis(experiment))
    callback = callback or SearchCallback()
    with (
        store.writing(experiment.listed_as, others=storage is not None) as held,
        Database.opened(experiment, store, storage, wanted) as database,
    ):
        search = _Search(
            experiment=experiment,
            study=study,
            store=store,
            held=held,
            database=database,
            executor=Considerate(executor(store.path, jobs, cluster, callback.message), store),
            workers=max(1, cluster.workers if cluster else jobs),
            shared=storage is not None,
            callback=callback,
        )
        return search.run()


@dataclass(kw_only=True)
class _Search:
    """One run of a search."""

    experiment: Experiment
    study: Study
    store: Store
    held: Held
    database: Database
    executor: Executor
    workers: int
    shared: bool
    callback: SearchCallback
    start: float = field(default_factory=time.monotonic)
    beaten: float = field(default_factory=time.monotonic)
    stopping: bool = False
    begun: int = 0
    cached: int = 0
    status: SearchStatus = field(init=False)
    runner: TrialRunner = field(init=False)
    lines: dict[int, list[Listed]] = field(default_factory=dict)

    def run(self) -> SearchResult:
        """Search until it is done or somebody stops it."""
        self.runner = TrialRunner(self.store, self.held, self.executor, self.workers, self._walked)
        candidates = self.database.candidates()
        self.begun = len(candidates)
        earlier = self.store.earlier(self.experiment.listed_as)
        if self.database.fresh and earlier and earlier[0].trials and not self.shared:
            self._message(
                f"{self.database.place} is new, but the store knows this study: the search is "
                "repeated from the start, and trials that are there are not simulated again"
            )
        self._finished(candidates)
        with stoppable(self._stop):
            with suppress(OSError):
                self.callback.start(self.status)
            try:
                with closing(self.runner):
                    ending = self._search()
            finally:
                with suppress(OSError):
                    self.callback.finish(self.status)
            if len(self.store.compact().entries) >= TABLE_FROM:
                self.store.tabulate()
        others = (name for name in self.database.living() if name != self.database.me)
        return SearchResult(
            status=self.status,
            ending=ending,
            cached=self.cached,
            elsewhere=tuple(others),
            place=self.database.place,
        )

    def _search(self) -> SearchEnding:
        race = Race(
            experiment=self.experiment,
            runner=self.runner,
            report=self.database.report,
            alive=self._alive,
        )
        try:
            while True:
                self._pause()
                batch = self._next_batch()
                if isinstance(batch, str):
                    return batch
                self._walk(race, batch)
        except Stopped:
            return "stopped"

    def _walk(self, race: Race, batch: Sequence[Pending]) -> None:
        known = self.database.candidates()
        before = tuple(candidate for candidate in known if candidate.number < batch[0].number)
        best = History(experiment=self.experiment, candidates=before).front
        rivals = [rival for rival in map(race.rival, best) if rival is not None]
        self.status = replace(self.status, walking=len(batch), alive=len(batch))
        self._show()
        numbers = {candidate.number for candidate in known}
        for candidate in race.run(batch, rivals):
            if candidate.number not in numbers:
                self.database.tell(candidate)
                self.cached += sum(not self.runner.made(trial) for trial in candidate.trial_ids)
        self._finished(self.database.candidates())
        self._update()

    def _next_batch(self) -> Sequence[Pending] | SearchEnding:
        """What to walk next, or why there is nothing."""
        database, living = self.database, self.database.living()
        pending = database.pending()
        orphans = [p for p in pending if p.owner == database.me or p.owner not in living]
        if orphans:
            return self._taken_over(orphans[0], living)
        candidates = database.candidates()
        if self._gone_stale(candidates):
            return "no improvement"
        begun = len(candidates) + len(pending)
        room = self.study.trials - begun
        if room <= 0:
            return "elsewhere" if pending else "complete"
        proposals = ask(
            self.study,
            database.observations(),
            first=None if begun else base_values(self.experiment, self.study),
            running=[other.values for other in pending],
            salt=living.index(database.me) + 1 if len(living) > 1 else 0,
        )
        if not proposals:
            return "elsewhere" if pending else "exhausted"
        return database.add(proposals[:room], begun, self.study.trials) or self._next_batch()

    def _taken_over(self, orphan: Pending, living: Sequence[str]) -> Sequence[Pending]:
        """The batch of a candidate that another process left behind, completed if it was alone."""
        database = self.database
        batch = database.batch_of(orphan)
        database.take_over([p for p in database.pending() if p in batch])
        missing = min(self.study.batch, self.study.trials - orphan.batch) - len(batch)
        earlier = database.observations(before=batch[0].number)
        if missing > 0 and len(earlier) == orphan.batch and len(living) == 1:
            first = None if earlier else base_values(self.experiment, self.study)
            there = {key(p.values) for p in batch}
            again = ask(self.study, earlier, first=first)
            lost = [p for p in again if key(p.values) not in there][:missing]
            database.add(lost, orphan.batch, self.study.trials, asked_by=orphan.asked_by)
        return database.batch_of(orphan)

    def _gone_stale(self, candidates: Sequence[Candidate]) -> bool:
        if self.study.early_stop is None or not candidates:
            return False
        history = History(experiment=self.experiment, candidates=tuple(candidates))
        after = [c for c in candidates if c.number > history.last_improvement]
        return len(after) >= self.study.early_stop

    def _pause(self) -> None:
        if self.stopping:
            raise Stopped

    def _stop(self, number: int) -> None:
        if self.stopping and number == SIGINT:
            raise KeyboardInterrupt
        self.stopping = True
        self.executor.drain()
        self._message(f"stopping: {self.executor.running} running trials are finished first")

    def _walked(self) -> None:
        """A trial has ended."""
        if self.shared and time.monotonic() - self.beaten > heartbeat.INTERVAL:
            self.beaten = time.monotonic()
            self.database.beat()
        self._show()

    def _alive(self, count: int) -> None:
        self._pause()
        self.status = replace(self.status, alive=count)
        self._show()

    def _show(self) -> None:
        self.status = replace(
            self.status,
            walked=self.runner.count,
            simulated=self.runner.seconds,
            seconds=time.monotonic() - self.start,
        )
        self._update()

    def _update(self) -> None:
        with suppress(OSError):
            self.callback.update(self.status)

    def _message(self, text: str) -> None:
        with suppress(OSError):
            self.callback.message(text)

    def _finished(self, candidates: tuple[Candidate, ...]) -> None:
        """Take in the finished candidates, and list their trials in the store.

        So tables and queries know whose they are.
        """
        self.status = SearchStatus(
            history=History(experiment=self.experiment, candidates=candidates),
            total=self.study.trials,
            walked=self.runner.count,
            simulated=self.runner.seconds,
            seconds=time.monotonic() - self.start,
            begun=self.begun,
        )
        for candidate in candidates:
            if candidate.number not in self.lines:
                self.lines[candidate.number] = _lines(self.experiment, candidate)
        lines = [line for number in sorted(self.lines) for line in self.lines[number]]
        self.store.register_lines(self.experiment, lines, basis(self.experiment))


def _lines(experiment: Experiment, candidate: Candidate) -> list[Listed]:
    """Trials of a candidate, seed by seed and within a seed ground by ground."""
    surfaces = list(experiment.parts.surfaces)
    lines = []
    for place, trial_id in enumerate(candidate.trial_ids):
        seed, ground = divmod(place, len(surfaces))
        lines.append(
            Listed(
                trial_id=trial_id,
                cell=candidate.number * len(surfaces) + ground,
                values={**candidate.values, "surface": surfaces[ground]},
                seed=experiment.seeds[seed],
            )
        )
    return lines
