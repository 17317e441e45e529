"""What `gaitlab optimize` does after the search: walk the winner again and say what holds."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gaitlab.cli.printing import duration, other_output_on_stderr, plural, say, tell

if TYPE_CHECKING:
    from gaitlab.search import History
    from gaitlab.search.tally import Searched
    from gaitlab.store import Store


def hold_final(found: Searched, store: Store, jobs: int, *, quiet: bool) -> tuple[Searched, bool]:
    """Let the best of a search walk with as many seeds again; whether all of it was walked.

    Raises:
        StoreError: If the store cannot be used.
        KeyboardInterrupt: At the second Ctrl-C.
    """
    from gaitlab.cli.progress import progress
    from gaitlab.search.final import decided, due
    from gaitlab.search.validation import running

    waiting = due(found.tally.history, store)
    if waiting and not quiet:
        more = plural(len(found.tally.history.experiment.seeds), "further seed")
        tell(f"Final: the best {len(waiting)} walk with {more} each; --no-validation skips it")
    with other_output_on_stderr():
        return decided(found, store, running(store, jobs, progress(quiet=True)))


def check_winner(
    history: History,
    store: Store,
    jobs: int,
    storage: str | None,
    *,
    around: bool,
    quiet: bool,
    silent: bool,
) -> bool:
    """Walk the winner on fresh seeds, every ground and around its values, and say what holds.

    Args:
        history: The finished search.
        store: Where the trials are; not held by this process.
        jobs: Worker processes; 0 walks in this process.
        storage: Address of the database, if it is not the store's own.
        around: Whether to walk around its values.
        quiet: Show no progress.
        silent: Print nothing on stdout.

    Returns:
        Whether everything was walked; False after a Ctrl-C.

    Raises:
        StoreError: If the store cannot be used.
        KeyboardInterrupt: At the second Ctrl-C.
    """
    from gaitlab.cli.progress import progress
    from gaitlab.search.validation import running, validate

    if not quiet:
        _say_effort(history, store, jobs, around)
    run = running(store, jobs, progress(quiet=quiet))
    with other_output_on_stderr():
        found = validate(history, store, run, around=around)
    if found is None:
        return True
    if not silent and not found.stopped:
        say("\n" + _text(history, store, storage))
    return not found.stopped


def _say_effort(history: History, store: Store, jobs: int, around: bool) -> None:
    from gaitlab.search.validation import chosen_of, effort, validate

    chosen = chosen_of(history)
    known = validate(history, store, lambda experiment: False, around=around)
    if chosen is None or known is None or not known.stopped:
        return
    needed = effort(history, chosen, store, jobs, around=around)
    walked = "on fresh seeds, on every ground" + (" and around its values" if around else "")
    tell(
        f"Checking candidate {chosen.number} {walked}: up to {plural(needed.walks, 'trial')}, "
        f"{duration(needed.seconds)}; falls and what the store holds make it less. "
        "--no-validation skips it"
    )


def _text(history: History, store: Store, storage: str | None) -> str:
    """What the check found, in a few lines."""
    from gaitlab.report.study.brief import brief
    from gaitlab.report.study.gathering import findings_of

    return brief(findings_of(history.experiment, store, storage))
