"""What each experiment asked for: a copy of its file and the list of its trials."""

from __future__ import annotations

import hashlib
import json
import os
import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, NamedTuple, TypeVar

from gaitlab.errors import StoreError, UsageError, WrongValue
from gaitlab.store.durable import NotAFile, read_whole, unreachable, write_durably
from gaitlab.store.record import Scalar, canonical, is_flat

if TYPE_CHECKING:
    from gaitlab.experiment import Experiment
    from gaitlab.experiment.plan import PlannedTrial

LIST = "trials.jsonl"
EARLIER = "earlier.jsonl"  # the list before the last change
NOTHING: Mapping[str, str] = MappingProxyType({})
_T = TypeVar("_T")
_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.+-]{0,99}")


class DamagedList(StoreError):
    """The list of an experiment is not what gaitlab wrote."""


@dataclass(frozen=True, kw_only=True)
class Listed:
    """One trial that an experiment wants.

    Attributes:
        trial_id: Identity of the trial.
        cell: Index of its cell in the plan.
        values: Varied parameters by dotted path, `surface` among them.
        seed: Replicate of the cell; None in a list that an early version wrote.
    """

    trial_id: str
    cell: int
    values: Mapping[str, Scalar]
    seed: int | None = None


@dataclass(frozen=True, kw_only=True)
class TrialList:
    """The trials of an experiment in the order of its plan.

    Attributes:
        experiment: Name of the experiment.
        digest: Digest of the experiment as it was resolved.
        trials: Each trial once, or once for each name under which a ground asks for it.
        basis: Digest of each part that the cells share, by what the part is called.
        file: The experiment's file; empty in a list that an early version wrote.
    """

    experiment: str
    digest: str
    trials: tuple[Listed, ...]
    basis: Mapping[str, str] = field(default_factory=dict)
    file: str = ""


def write_list(
    experiments: Path,
    experiment: Experiment,
    planned: Iterable[PlannedTrial],
    basis: Mapping[str, str],
) -> TrialList:
    """Keep the experiment's file and the list of its trials; the list before it is kept too."""
    return write_listed(experiments, experiment, map(listed, planned), basis)


def write_listed(
    experiments: Path,
    experiment: Experiment,
    lines: Iterable[Listed],
    basis: Mapping[str, str],
) -> TrialList:
    """The same from the lines of the list: a search knows its trials without planning them."""
    folder = experiments / checked_name(experiment.listed_as)
    require_one_file(experiments, experiment)
    found = trial_list(experiment, lines, basis)
    write_durably(folder / "experiment.yaml", experiment.text.encode(), within=experiments.parent)
    _replace_list(folder, encode_list(found), experiments.parent)
    return found


def trial_list(
    experiment: Experiment, lines: Iterable[Listed], basis: Mapping[str, str] = NOTHING
) -> TrialList:
    """The list of an experiment from its lines: each trial once for each ground that asks for it.

    Args:
        experiment: The experiment.
        lines: Its trials, in the order of the plan.
        basis: Digest of each part that its cells share, by what the part is called.
    """
    unique: dict[tuple[str, Scalar], Listed] = {}
    for line in lines:
        unique.setdefault((line.trial_id, line.values.get("surface")), line)
    return TrialList(
        experiment=experiment.listed_as,
        digest=experiment.digest,
        trials=tuple(unique.values()),
        basis=basis,
        file=str(experiment.path.absolute()),
    )


def require_one_file(experiments: Path, experiment: Experiment) -> None:
    """Refuse an experiment whose name is that of another file's results.

    A file that is gone, or says the same, is no other: experiments move and are copied.

    Raises:
        UsageError: Names the other file.
    """
    with suppress(StoreError):
        other = Path(read_list(experiments / experiment.listed_as).file)
        if other.suffix and not _same_file(other, experiment.path):
            raise UsageError(
                f"{experiment.path}: the results called {experiment.listed_as} in "
                f"{experiments.parent} are those of {other}, another file of the same name; give "
                "one of the two another `name:`, or another folder with --store DIR"
            )


def _same_file(one: Path, other: Path) -> bool:
    try:
        return one.samefile(other) or one.read_bytes() == other.read_bytes()
    except OSError:
        return True


def _replace_list(folder: Path, content: bytes, store: Path) -> None:
    """Keep what the cells were before a change, to tell later why their trials run again."""
    path = folder / LIST
    with suppress(FileNotFoundError, NotAFile):
        before = read_whole(path)
        if before == content:
            return
        write_durably(folder / EARLIER, before, within=store)
    write_durably(path, content, within=store)


def listed(item: PlannedTrial) -> Listed:
    """The line of the list that stands for a planned trial."""
    return Listed(
        trial_id=item.trial.id,
        cell=item.cell_index,
        values=_plain(item.values),
        seed=item.trial.seed,
    )


def earlier_lists(folder: Path) -> list[TrialList]:
    """The list of an experiment and the one before it, newest first, as far as there are any."""
    found = []
    for name in (LIST, EARLIER):
        with suppress(DamagedList):
            found.append(read_list(folder, name))
    return found


class Lists(NamedTuple):
    """What the experiments of a store asked for, by their names.

    Attributes:
        sound: Those that can be read.
        damaged: Why the others cannot.
    """

    sound: dict[str, TrialList]
    damaged: dict[str, DamagedList]


def read_lists(experiments: Path) -> Lists:
    """Every list below the folder of the experiments.

    Raises:
        StoreError: If the folder or a list cannot be read.
    """
    found = Lists({}, {})
    try:
        folders = sorted(experiments.iterdir()) if experiments.is_dir() else []
    except OSError as error:
        raise unreachable(experiments, error) from error
    for folder in folders:
        if not os.path.lexists(folder / LIST):
            continue
        try:
            found.sound[folder.name] = read_list(folder)
        except DamagedList as error:
            found.damaged[folder.name] = error
    return found


def read_list(folder: Path, name: str = LIST) -> TrialList:
    """The list that `write_list` kept in the folder of an experiment.

    Raises:
        DamagedList: If the list is damaged or not there.
        StoreError: If it cannot be read.
    """
    path = folder / name
    try:
        if folder.is_symlink():
            raise NotAFile(f"its folder is a link to {os.readlink(folder)}")
        first, _, rest = read_whole(path).partition(b"\n")
        head = json.loads(first)
        if head.get("sha256", _digest(rest)) != _digest(rest):
            raise ValueError("the lines are not those that were written")
        trials = tuple(_trials(rest))
        if len(trials) != head["trials"]:
            raise ValueError(f"{len(trials)} of {head['trials']} trials")
        return TrialList(
            experiment=_of(str, head["experiment"]),
            digest=_of(str, head["digest"]),
            trials=trials,
            basis={name: _of(str, value) for name, value in head.get("basis", {}).items()},
            file=_of(str, head.get("file", "")),
        )
    except (OSError, ValueError, TypeError, KeyError, AttributeError, RecursionError) as error:
        raise DamagedList(
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


def encode_list(found: TrialList) -> bytes:
    """The file of a list: a head, and one line a trial."""
    lines = (
        {"trial_id": t.trial_id, "cell": t.cell, "values": t.values, "seed": t.seed}
        for t in found.trials
    )
    rest = "".join(f"{canonical(line)}\n" for line in lines).encode()
    head = {
        "experiment": found.experiment,
        "digest": found.digest,
        "trials": len(found.trials),
        "basis": dict(found.basis),
        **({"file": found.file} if found.file else {}),
        "sha256": _digest(rest),
    }
    return f"{canonical(head)}\n".encode() + rest


def _trials(lines: bytes) -> Iterator[Listed]:
    """The lines of a list; neighbours share their values, which saves half of the memory."""
    values: Mapping[str, Scalar] = {}
    for line in lines.splitlines():
        found = Listed(**json.loads(line))
        _of(str, found.trial_id)
        for number in (found.cell, 0 if found.seed is None else found.seed):
            _of(int, number)
        if not is_flat(found.values):
            raise ValueError(f"the values of trial {found.trial_id} are of another kind")
        if found.values == values:
            found = replace(found, values=values)
        values = found.values
        yield found


def _of(kind: type[_T], value: object) -> _T:
    if not isinstance(value, kind):
        raise ValueError(f"found {value!r}"[:200])
    return value


def _digest(lines: bytes) -> str:
    return hashlib.sha256(lines).hexdigest()


def _plain(values: Mapping[str, object]) -> dict[str, Scalar]:
    return {
        path: value if isinstance(value, (bool, int, float, str)) or value is None else str(value)
        for path, value in values.items()
    }
