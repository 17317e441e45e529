"""What `gaitlab run --dry-run` says: the plan as a table, or as an object for machines."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping
from typing import TYPE_CHECKING

from gaitlab.cli.printing import columns, duration, number, plural, size

if TYPE_CHECKING:
    from gaitlab.running import Cost, Outlook, Standing

LONGEST_TABLE = 30  # cells of a plan that are listed; more are summed up
SHOWN_VALUES = 12  # of a path in such a sum


def plan_text(found: Outlook, needed: Cost, retry_failed: bool, as_json: bool) -> str:
    """The plan as a table, a row a cell and a reason for everything that would run."""
    if as_json:
        return json.dumps(plan_object(found, needed))
    short = len(found.standings) <= LONGEST_TABLE
    table = _every_cell(found, retry_failed) if short else _cells_by_reason(found, retry_failed)
    total = f"{plural(found.planned, 'trial')} in {plural(len(found.standings), 'cell')}: "
    total += f"{found.count('cached')} cached, {needed.trials} to run, "
    total += f"up to {duration(needed.seconds)} and {size(needed.size)}"
    code = [f"this experiment runs code of your own: {file}" for file in found.own_code]
    return "\n".join([f"{table}\n\n{total}", *code])


def plan_object(found: Outlook, needed: Cost) -> dict[str, object]:
    """What a plan is for machines."""
    counts = {"new": 0, "file damaged": 0, "failed before": 0, **found.due(True)}
    return {
        "planned": found.planned,
        "cached": found.count("cached"),
        "to_run": {stand.replace(" ", "_"): count for stand, count in counts.items()},
        "seconds": round(needed.seconds),
        "bytes": round(needed.size),
    }


def _every_cell(found: Outlook, retry_failed: bool) -> str:
    paths = list(found.values[0]) if found.values else []
    rows = [
        [*(number(values[path]) for path in paths), *_standing_cells(standing, retry_failed)]
        for values, standing in zip(found.values, found.standings, strict=True)
    ]
    return columns([*paths, "cached", "to run", "why"], rows)


def _cells_by_reason(found: Outlook, retry_failed: bool) -> str:
    """What is varied, and how many cells stand how: a long plan in a few lines."""
    varied = [[path, _values(found, path)] for path in found.values[0]]
    stands = [tuple(_standing_cells(standing, retry_failed)) for standing in found.standings]
    rows = [[str(count), *stand] for stand, count in Counter(stands).items()]
    head = ("cells", "cached in each", "to run in each", "why")
    return f"{columns(('varied', 'values'), varied)}\n\n{columns(head, rows)}"


def _values(found: Outlook, path: str) -> str:
    """The values of a path, those in the middle left out when they are many."""
    if path in found.swept:
        return found.swept[path]
    values = list(dict.fromkeys(number(cell[path]) for cell in found.values))
    if len(values) > SHOWN_VALUES:
        half = SHOWN_VALUES // 2
        values = [*values[:half], f"... {len(values) - 2 * half} more ...", *values[-half:]]
    return ", ".join(values)


def _standing_cells(standing: Mapping[Standing, int], retry_failed: bool) -> list[str]:
    due = {
        stand: count
        for stand, count in standing.items()
        if stand != "cached" and (retry_failed or stand != "failed before")
    }
    reasons = [stand if len(due) == 1 else f"{count} {stand}" for stand, count in due.items()]
    if standing.get("failed before") and not retry_failed:
        reasons.append(f"{standing['failed before']} failed before, left (--retry-failed)")
    return [str(standing.get("cached", 0)), str(sum(due.values())), ", ".join(reasons)]
