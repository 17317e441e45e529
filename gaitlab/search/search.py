"""The search: ask for a batch, walk it, tell what became of it, until there are enough.

A batch is asked for when everything before it is told, from a seed that hangs on the study alone,
and all of it is told before the next. So what a search finds does not depend on how many workers
there are, on which trial ends first, or on how often it was killed; only several coordinators that
share a search are free to interleave.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field, replace
from functools import partial
from signal import SIGINT

from gaitlab.dispatch.basis import basis
from gaitlab.dispatch.signals import stoppable
from gaitlab.executors import Executor, Processes, Serial, simulated
from gaitlab.experiment import Experiment, Value
from gaitlab.experiment.purposes import study_of
from gaitlab.experiment.study import Study
from gaitlab.search import Candidate, History
from gaitlab.search.asking import ask
from gaitlab.search.coordinators import BEAT
from gaitlab.search.database import Database
from gaitlab.search.entries import Pending
from gaitlab.search.heats import Heats
from gaitlab.search.request import asks_for
from gaitlab.search.space import hand_set, key
from gaitlab.search.tally import Careful, Ending, Nobody, Searched, Tally, Told, last_improvement
from gaitlab.search.walks import Stopped, Walks
from gaitlab.store import Held, Listed, Store
from gaitlab.store.store import TABLE_FROM


def optimize(
    experiment: Experiment,
    store: Store,
    *,
    jobs: int,
    storage: str | None = None,
    told: Told | None = None,
) -> Searched:
    """Go on with the search of a study until its total of candidates is told.

    The first Ctrl-C, or SIGTERM, lets the running trials end; the second Ctrl-C kills them. Either
    way the same call goes on from there.

    Args:
        experiment: A study.
        store: Where trials go; held against other runs meanwhile.
        jobs: Worker processes; 0 walks every trial in this process.
        storage: Address of a database that several machines share; by default a file of the
            store.
        told: Who is told.

    Raises:
        UsageError: If the experiment is no study, or the sampler's library is missing.
        StoreError: If the store or the database cannot be used, or the database holds another
            study of this name.
        KeyboardInterrupt: At the second Ctrl-C.
    """
    study = study_of(experiment)
    wanted = asks_for(experiment, basis(experiment))
    with store.lock() as held, Database.opened(experiment, store, storage, wanted) as database:
        task = partial(simulated, store=store.path)
        executor = Processes(task, jobs) if jobs else Serial(task)
        careful = Careful(told or Nobody())
        search = _Search(experiment, study, store, held, database, executor, careful)
        return search.run(max(1, jobs), shared=storage is not None)


@dataclass
class _Search:
    """One run of a search."""

    experiment: Experiment
    study: Study
    store: Store
    held: Held
    database: Database
    executor: Executor
    told: Careful
    shared: bool = False
    start: float = field(default_factory=time.monotonic)
    beaten: float = field(default_factory=time.monotonic)
    stopping: bool = False
    begun: int = 0
    reused: int = 0
    tally: Tally = field(init=False)
    walks: Walks = field(init=False)
    lines: dict[int, list[Listed]] = field(default_factory=dict)

    def run(self, workers: int, shared: bool) -> Searched:
        """Search until it is done or somebody stops it."""
        self.shared = shared
        self.walks = Walks(self.store, self.held, self.executor, workers, self._walked)
        self.begun = len(self.database.told())
        self.tally = self._tally(self.database.told())
        self._say_if_rebuilt()
        with stoppable(self._stop):
            self.told.start(self.tally)
            try:
                with closing(self.walks):
                    ending = self._search()
            finally:
                self.told.finish(self.tally)
            if len(self.store.compact().entries) >= TABLE_FROM:
                self.store.tabulate()
        return Searched(
            tally=self.tally,
            ending=ending,
            used_before=self.reused,
            elsewhere=self._others(),
            place=self.database.place,
        )

    def _search(self) -> Ending:
        heats = Heats(
            experiment=self.experiment,
            walks=self.walks,
            shown=self.database.report,
            alive=self._alive,
        )
        self._register(self.database.told())
        try:
            while True:
                self._pause()
                found = self._next_batch()
                if isinstance(found, str):
                    return found
                self._walk(heats, found)
        except Stopped:
            return "stopped"

    def _say_if_rebuilt(self) -> None:
        earlier = self.store.earlier(self.experiment.listed_as)
        if self.database.fresh and earlier and earlier[0].trials and not self.shared:
            self.told.message(
                f"{self.database.place} is new, but the store knows this study: the search is "
                "repeated from the start, and trials that are there are not simulated again"
            )

    def _walk(self, heats: Heats, batch: Sequence[Pending]) -> None:
        told = self.database.told()
        before = [candidate for candidate in told if candidate.number < batch[0].number]
        best = History(experiment=self.experiment, candidates=tuple(before)).front
        rivals = [rival for rival in map(heats.rival, best) if rival is not None]
        self._show(walking=len(batch), alive=len(batch))
        results = heats.run(batch, rivals)
        known = {candidate.number for candidate in told}
        for candidate in results:
            if candidate.number not in known:
                self.database.tell(candidate)
        self.reused += sum(
            not self.walks.made(trial_id)
            for candidate in results
            for trial_id in candidate.trial_ids
            if candidate.number not in known
        )
        everything = self.database.told()
        self._register(everything)
        self.tally = self._tally(everything)
        self.told.update(self.tally)

    def _next_batch(self) -> Sequence[Pending] | Ending:
        """What to walk next, or why there is nothing."""
        database, living = self.database, self._living()
        pending = database.pending()
        orphans = [p for p in pending if p.owner == database.me or p.owner not in living]
        if orphans:
            return self._taken_over(orphans[0], living)
        told = database.told()
        if self._gone_stale(told):
            return "no improvement"
        room = self.study.trials - len(told) - len(pending)
        if room <= 0:
            return "elsewhere" if pending else "complete"
        first = None if told or pending else hand_set(self.experiment, self.study)
        salt = living.index(database.me) + 1 if len(living) > 1 else 0
        running = [other.values for other in pending]
        proposals = ask(self.study, database.remembered(), first=first, running=running, salt=salt)
        if not proposals:
            return "elsewhere" if pending else "exhausted"
        return database.add(proposals[:room], len(told) + len(pending), self.study.trials) or (
            self._next_batch()
        )

    def _taken_over(self, orphan: Pending, living: Sequence[str]) -> Sequence[Pending]:
        """The batch of a candidate that a coordinator left behind, completed if it was alone."""
        database = self.database
        batch = database.batch_of(orphan)
        database.take_over([p for p in database.pending() if p in batch])
        missing = min(self.study.batch, self.study.trials - orphan.batch) - len(batch)
        earlier = database.remembered(before=batch[0].number)
        if missing > 0 and len(earlier) == orphan.batch and len(living) == 1:
            first = None if earlier else hand_set(self.experiment, self.study)
            there = {key(p.values) for p in batch}
            again = ask(self.study, earlier, first=first)
            lost = [p for p in again if key(p.values) not in there][:missing]
            database.add(lost, orphan.batch, self.study.trials, asked_by=orphan.asked_by)
        return database.batch_of(orphan)

    def _gone_stale(self, told: Sequence[Candidate]) -> bool:
        if self.study.early_stop is None or not told:
            return False
        history = History(experiment=self.experiment, candidates=tuple(told))
        after = [c for c in told if c.number > last_improvement(history)]
        return len(after) >= self.study.early_stop

    def _living(self) -> tuple[str, ...]:
        """Coordinators; a file in the store has one, for it holds the store."""
        return self.database.living() if self.shared else (self.database.me,)

    def _others(self) -> tuple[str, ...]:
        return tuple(name for name in self._living() if name != self.database.me)

    def _pause(self) -> None:
        if self.stopping:
            raise Stopped

    def _stop(self, number: int) -> None:
        if self.stopping and number == SIGINT:
            raise KeyboardInterrupt
        self.stopping = True
        self.executor.drain()
        self.told.message(f"stopping: {self.executor.running} running trials are finished first")

    def _walked(self) -> None:
        """A trial has ended."""
        if self.shared and time.monotonic() - self.beaten > BEAT:
            self.beaten = time.monotonic()
            self.database.beat()
        self._show()

    def _alive(self, count: int) -> None:
        self._pause()
        self._show(alive=count)

    def _show(self, walking: int | None = None, alive: int | None = None) -> None:
        self.tally = replace(
            self.tally,
            walking=self.tally.walking if walking is None else walking,
            alive=self.tally.alive if alive is None else alive,
            walked=self.walks.count,
            simulated=self.walks.seconds,
            seconds=time.monotonic() - self.start,
        )
        self.told.update(self.tally)

    def _tally(self, candidates: Sequence[Candidate]) -> Tally:
        return Tally(
            history=History(experiment=self.experiment, candidates=tuple(candidates)),
            total=self.study.trials,
            walked=self.walks.count,
            simulated=self.walks.seconds,
            seconds=time.monotonic() - self.start,
            begun=self.begun,
        )

    def _register(self, told: Sequence[Candidate]) -> None:
        """List the trials of the candidates, so that tables and queries know whose they are."""
        for candidate in told:
            if candidate.number not in self.lines:
                self.lines[candidate.number] = list(_lines(self.experiment, candidate))
        lines = [line for number in sorted(self.lines) for line in self.lines[number]]
        self.store.register_lines(self.experiment, lines, basis(self.experiment))


def _lines(experiment: Experiment, candidate: Candidate) -> list[Listed]:
    """Trials of a candidate, seed by seed and within a seed ground by ground."""
    surfaces = list(experiment.parts.surfaces)
    lines = []
    for place, trial_id in enumerate(candidate.trial_ids):
        seed, ground = divmod(place, len(surfaces))
        values: Mapping[str, Value] = {**candidate.values, "surface": surfaces[ground]}
        lines.append(
            Listed(
                trial_id=trial_id,
                cell=candidate.number * len(surfaces) + ground,
                values=values,
                seed=experiment.seeds[seed],
            )
        )
    return lines
