"""`gaitlab run` of a reproduction: its experiments in turn, and the sum of what they did."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from gaitlab.cli.common import (
    INTERRUPTED,
    SOME_FAILED,
    plan_object,
    progress_of,
    refuse_large,
    share_of,
    summary_text,
    tell_reasons,
)
from gaitlab.cli.printing import columns, duration, other_output_on_stderr, plural, say, size, tell
from gaitlab.cli.progress import end_line, summary_object
from gaitlab.errors import UsageError
from gaitlab.experiment import Experiment
from gaitlab.experiment.plan import plan
from gaitlab.papers.reproduction import Reproduction
from gaitlab.running import Cost, Outlook, Summary, cost, dispatch, outlook, total
from gaitlab.running.executor import Cluster
from gaitlab.store import Shard, Store

COUNTED = ("planned", "cached", "done", "infeasible", "failed", "left")  # of a summary


@dataclass(frozen=True, kw_only=True)
class RunOptions:
    """Options of the command.

    Attributes:
        workers: Worker processes; 0 runs in this process.
        cluster: Has the workers, elsewhere.
        shard: Which share of each experiment to run; None for all of them.
        retry_failed: Run trials again that failed before.
        as_json: Print the counts as one object.
        json_lines: Print every event as an object.
        quiet: Show no progress.
        yes: Run even if it takes more than a day.
        again: Arguments that make another command mean the same trials.
    """

    workers: int
    cluster: Cluster | None
    shard: Shard | None
    retry_failed: bool
    as_json: bool
    json_lines: bool
    quiet: bool
    yes: bool
    again: str


def run_members(whole: Reproduction, store: Store, options: RunOptions, *, dry_run: bool) -> int:
    """Run every experiment of a reproduction, or say what would run.

    Raises:
        UsageError: If all of them together take more than a day and nobody said yes.
        StoreError: If the store cannot be used.
    """
    costs = [
        cost(planned, share_of(planned.size, options.shard), options.workers)
        for planned in map(plan, whole.members)
    ]
    refuse_large(_sum(costs), options.yes)
    if dry_run:
        say(_plans(whole.members, store, options))
        return 0
    try:
        done = _run_in_turn(whole.members, store, options)
    except KeyboardInterrupt:
        tell(f"stopped at once; what is committed is safe. Go on: gaitlab run {options.again}")
        return INTERRUPTED
    found = total(done.values())
    say(_outcome(done, found, options))
    return INTERRUPTED if found.interrupted else SOME_FAILED if found.failed else 0


def only_one(names: Sequence[str]) -> str:
    """The one reproduction that a page is made of.

    Raises:
        UsageError: If more than one thing is named.
    """
    if len(names) != 1:
        raise UsageError(
            f"{' and '.join(names)}: a reproduction has a page of its own; report it alone"
        )
    return names[0]


def _sum(costs: Sequence[Cost]) -> Cost:
    return Cost(
        trials=sum(one.trials for one in costs),
        seconds=sum(one.seconds for one in costs),
        size=sum(one.size for one in costs),
    )


def _run_in_turn(
    members: Sequence[Experiment], store: Store, options: RunOptions
) -> dict[str, Summary]:
    """What was done of each member; after a Ctrl-C nothing of those that come later."""
    done: dict[str, Summary] = {}
    for number, member in enumerate(members, start=1):
        if any(summary.interrupted for summary in done.values()):
            done[member.name] = Summary(planned=plan(member).size)
            continue
        if options.json_lines:
            say(json.dumps({"event": "member", "experiment": member.name, "number": number}))
        elif not options.quiet:
            tell(f"{member.name} ({number} of {len(members)})")
        progress = progress_of(
            options.quiet, options.json_lines
        )  # before stdout is kept from others
        with other_output_on_stderr():
            done[member.name] = dispatch(
                member,
                store,
                jobs=options.workers,
                shard=options.shard,
                retry_failed=options.retry_failed,
                progress=progress,
                cluster=options.cluster,
            )
        tell_reasons(store, member.listed_as, done[member.name])
    return done


def _outcome(done: Mapping[str, Summary], found: Summary, options: RunOptions) -> str:
    """What stdout ends with: the members one by one, their sum, and what comes next."""
    if options.json_lines:
        return end_line(found)
    if options.as_json:
        members = {name: summary_object(summary) for name, summary in done.items()}
        return json.dumps({**summary_object(found), "members": members})
    rows = [[name, *(str(getattr(one, key)) for key in COUNTED)] for name, one in done.items()]
    text = summary_text(found, options.again, options.shard)
    return f"{columns(('experiment', *COUNTED), rows)}\n\n{text}"


def _plans(members: Sequence[Experiment], store: Store, options: RunOptions) -> str:
    """What would run of each member, and of all of them together."""
    found = {member.name: outlook(member, store, options.shard) for member in members}
    needed = {}
    for member in members:
        due = sum(found[member.name].due(options.retry_failed).values())
        needed[member.name] = cost(plan(member, programs=False), due, options.workers)
    whole = _sum(list(needed.values()))
    planned = sum(one.planned for one in found.values())
    cached = sum(one.count("cached") for one in found.values())
    if options.as_json or options.json_lines:
        plans_object = {
            "planned": planned,
            "cached": cached,
            "to_run": whole.trials,
            "seconds": round(whole.seconds),
            "bytes": round(whole.size),
            "members": {name: plan_object(found[name], needed[name]) for name in found},
        }
        return json.dumps(plans_object)
    rows = [[name, *_plan_cells(found[name], needed[name])] for name in found]
    head = ("experiment", "cells", "planned", "cached", "to run", "up to", "logs up to")
    counts = f"{plural(planned, 'trial')} in {plural(len(members), 'experiment')}: {cached} cached"
    cost_text = f"up to {duration(whole.seconds)} and {size(whole.size)}"
    code = sorted({file for one in found.values() for file in one.own_code})
    notes = [f"this reproduction runs code of your own: {file}" for file in code]
    total_line = f"{counts}, {whole.trials} to run, {cost_text}"
    return "\n".join([columns(head, rows), "", total_line, *notes])


def _plan_cells(found: Outlook, needed: Cost) -> list[str]:
    counts = len(found.standings), found.planned, found.count("cached"), needed.trials
    return [*map(str, counts), duration(needed.seconds), size(needed.size)]
