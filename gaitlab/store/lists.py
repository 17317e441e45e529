"""What each experiment asked for: a copy of its file and the list of its trials."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from gaitlab.errors import StoreError, WrongValue
from gaitlab.store.durable import write_durably
from gaitlab.store.record import Scalar, canonical

if TYPE_CHECKING:
    from gaitlab.experiment import Experiment
    from gaitlab.plan import PlannedTrial

_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.+-]{0,99}")


@dataclass(frozen=True, kw_only=True)
class Listed:
    """One trial that an experiment wants.

    Attributes:
        trial_id: Identity of the trial.
        cell: Index of its cell in the plan.
        values: Varied parameters by dotted path, `surface` among them.
    """

    trial_id: str
    cell: int
    values: Mapping[str, Scalar]


@dataclass(frozen=True, kw_only=True)
class TrialList:
    """The trials of an experiment in the order of its plan.

    Attributes:
        experiment: Name of the experiment.
        digest: Digest of the experiment as it was resolved.
        trials: Each trial once.
    """

    experiment: str
    digest: str
    trials: tuple[Listed, ...]


def write_list(
    experiments: Path, experiment: Experiment, planned: Iterable[PlannedTrial]
) -> TrialList:
    """Keep the experiment's file and the list of its trials, replacing earlier ones."""
    folder = experiments / checked_name(experiment.name)
    unique: dict[str, Listed] = {}
    for item in planned:
        listed = Listed(trial_id=item.trial.id, cell=item.cell_index, values=_plain(item.values))
        unique.setdefault(listed.trial_id, listed)
    found = TrialList(
        experiment=experiment.name, digest=experiment.digest, trials=tuple(unique.values())
    )
    write_durably(folder / "experiment.yaml", experiment.text.encode())
    write_durably(folder / "trials.jsonl", _encode(found))
    return found


def read_list(folder: Path) -> TrialList:
    """The list that `write_list` kept in the folder of an experiment.

    Raises:
        StoreError: If the list is damaged.
    """
    path = folder / "trials.jsonl"
    try:
        head, *lines = (json.loads(line) for line in path.read_bytes().splitlines())
        trials = tuple(Listed(**line) for line in lines)
        if len(trials) != head["trials"]:
            raise ValueError(f"{len(trials)} of {head['trials']} trials")
        return TrialList(experiment=head["experiment"], digest=head["digest"], trials=trials)
    except (OSError, ValueError, TypeError, KeyError) as error:
        raise StoreError(
            f"{path}: the list of trials is damaged ({error}). The trials themselves are safe; "
            f"`gaitlab run` of the experiment writes the list anew."
        ) from error


def checked_name(name: str) -> str:
    """The name, if it can be the name of a folder in the store.

    Raises:
        WrongValue: If it could leave the store or is too long.
    """
    if not _NAME.fullmatch(name):
        raise WrongValue(
            f"experiment name {name!r} cannot name a folder of the store: allowed are up to 100 "
            "letters, digits and _ . + -, not starting with a dot; change `name:` in the file"
        )
    return name


def _encode(found: TrialList) -> bytes:
    head = {
        "experiment": found.experiment,
        "digest": found.digest,
        "trials": len(found.trials),
    }
    lines = ({"trial_id": t.trial_id, "cell": t.cell, "values": t.values} for t in found.trials)
    return "".join(f"{canonical(line)}\n" for line in (head, *lines)).encode()


def _plain(values: Mapping[str, object]) -> dict[str, Scalar]:
    return {
        path: value if isinstance(value, (bool, int, float, str)) or value is None else str(value)
        for path, value in values.items()
    }
