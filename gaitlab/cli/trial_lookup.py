"""The trial that a command is given: completed as it is typed, and made again from its record."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from gaitlab.cli.options import DEFAULT_STORE
from gaitlab.cli.printing import tell
from gaitlab.errors import WrongValue

if TYPE_CHECKING:
    from gaitlab.simulation.trial import Trial
    from gaitlab.store import Store
    from gaitlab.store.record import TrialRecord

ADDRESS = "First digits of a trial, EXPERIMENT/VALUE/.../SEED, or EXPERIMENT/.../worst or best."
SHOWN = 8  # digits of a trial in a message


def complete_trials(context: typer.Context, incomplete: str) -> list[str]:
    """Ids and addresses that begin so, of the store that the command is given; silent always."""
    with suppress(Exception):
        from gaitlab.store import Store
        from gaitlab.store.addresses import begun

        return list(begun(Store(Path(context.params.get("store") or DEFAULT_STORE)), incomplete))
    return []


def trial_of(store: Store, record: TrialRecord, *, allow_code: bool) -> Trial:
    """The trial of a record, which runs the user's own code that it names.

    Args:
        store: Where the record is from.
        record: What became of the trial.
        allow_code: Whether code may run that only the store names; which files, is said.

    Raises:
        WrongValue: If it may not, or the trial cannot be made any more.
    """
    from gaitlab.experiment.named_code import named_code, refusal, unnamed_code
    from gaitlab.simulation.trial import Trial, own_code

    if own_code(record.trial):
        files = unnamed_code(record.trial, named_code(store.path))
        if files and not allowed(allow_code)(files):
            raise WrongValue(f"trial {record.trial_id[:SHOWN]}: {refusal(files)}")
    return Trial.from_dict(record.trial)


def allowed(allow_code: bool) -> Callable[[Sequence[str]], bool]:
    """The answer to whether files may run that only the store names; says which do."""

    def answer(files: Sequence[str]) -> bool:
        if allow_code:
            tell(f"running code that only the store names: {', '.join(files)}")
        return allow_code

    return answer
