"""`gaitlab merge` and `verify`: two stores into one, and whether a store is what it was."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gaitlab.cli.options import DEFAULT_STORE, AllowCode, StoreFolder
from gaitlab.cli.printing import say, tell
from gaitlab.cli.trial_lookup import allowed

if TYPE_CHECKING:
    from gaitlab.running.verify import Verdict
    from gaitlab.store import Store

NEEDS_ATTENTION = 4  # exit code: what is right is kept, something else was found
DEFAULT_SAMPLE = 3  # trials simulated again


def merge(
    into: Annotated[Path, typer.Argument(metavar="A", help="Folder that gets everything.")],
    other: Annotated[Path, typer.Argument(metavar="B", help="Folder that is only read.")],
) -> int:
    """Add all trials and experiments of store B to store A; B stays as it is.

    Where both hold a trial and disagree, A's stays and B's goes to A/conflicts; exit code 4.

    \b
    Example:
      gaitlab merge data ../laptop/data
    """
    from gaitlab.store import Store
    from gaitlab.store.merge import merge as merge_stores

    done = merge_stores(Store(into), Store(other))
    for message in done.conflicts:
        tell(f"conflict: {message}")
    for message in done.refused:
        tell(f"not taken: {message}")
    counts = f"{done.taken} trials taken, {done.shared} were there, "
    say(f"{counts}{len(done.conflicts)} conflicts, {len(done.refused)} files not taken")
    return NEEDS_ATTENTION if done.conflicts or done.refused else 0


def verify(
    sample: Annotated[
        int,
        typer.Option("--sample", metavar="N", min=0, help="Trials to simulate again, at random."),
    ] = DEFAULT_SAMPLE,
    jobs: Annotated[
        int, typer.Option("-j", "--jobs", metavar="N", min=0, help="Worker processes for them.")
    ] = 1,
    repair: Annotated[
        bool,
        typer.Option("--repair", help="Set damaged files aside, so that `run` does them again."),
    ] = False,
    allow_code: AllowCode = False,
    store: StoreFolder = DEFAULT_STORE,
) -> int:
    """Check the checksums of every trial, and simulate some again: the bits must be the same.

    \b
    Example:
      gaitlab verify --sample 10
    """
    from gaitlab.running.verify import verify as verify_store
    from gaitlab.store import Store

    results = Store(store)
    found = verify_store(results, sample=sample, jobs=jobs, allowed=allowed(allow_code))
    for problem in found.unsound:
        tell(f"not sound: {problem}")
    for message in found.different:
        tell(f"not repeated: {message}")
    for message in found.skipped:
        tell(f"not simulated again: {message}")
    if repair:
        _repair(results, found)
    say(
        f"{found.checked} trials sound, {len(found.unsound)} files not; "
        f"{found.repeated} simulated again bit for bit, {len(found.different)} not"
    )
    return 0 if found.sound else NEEDS_ATTENTION


def _repair(results: Store, found: Verdict) -> None:
    damaged = [error.path for error in found.unsound if error.kind == "damaged"]
    if not damaged:
        return
    with results.lock():
        for path in damaged:
            if path.exists():
                tell(f"set aside: {path} is now {results.set_aside(path)}")
        results.compact()
