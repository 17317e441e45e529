"""Which trial is meant: by the first digits of its id, or by its place in an experiment.

`eros_quick/grass_50mm/0.04/2` is the trial of the experiment eros_quick that has these values and
this seed, in any order and only as many as are needed; `eros_quick/worst` is the first to fall.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

from gaitlab.documents.printable import columns, number
from gaitlab.errors import UnknownName
from gaitlab.store.entry import Entry
from gaitlab.store.lists import TrialList
from gaitlab.store.record import Scalar
from gaitlab.store.store import Store

HEX = re.compile(r"[0-9a-fA-F]{4,32}")
LISTED = 8  # trials named when none or several are meant
SHOWN = 8  # digits of a trial in a list; more where two begin alike
EXTREMES = ("worst", "best")


class FoundTrial(NamedTuple):
    """A trial in an experiment.

    Attributes:
        entry: What the index knows of it.
        experiment: Name of the experiment; empty when none asks for it.
        values: Varied parameters by dotted path.
    """

    entry: Entry
    experiment: str
    values: Mapping[str, Scalar]


def trial_at(store: Store, address: str) -> str:
    """The one trial that an address means.

    Raises:
        UnknownName: If it means none or several; lists the nearest with cell, seed and outcome.
    """
    head, *parts = [part for part in address.strip().split("/") if part] or [""]
    if not parts and HEX.fullmatch(head) and head not in store.experiments():
        return _by_digits(store, head.lower())
    return _by_place(store, address, head, parts)


def is_address(store: Store, text: str) -> bool:
    """Whether a text can only mean a trial: digits of one, or a place in an experiment of it."""
    head = text.strip().partition("/")
    return bool(HEX.fullmatch(text)) or (head[1] != "" and head[0] in store.lists().sound)


def begun(store: Store, text: str) -> Iterator[str]:
    """What an address that begins so may go on with: experiments, values, seeds, whole ids."""
    head, slash, last = text.rpartition("/")
    lists = store.lists().sound
    if not slash:
        yield from (f"{name}/" for name in lists if name.startswith(text))
        yield from (name for name in store.index().entries if text and name.startswith(text))
        return
    experiment, *parts = head.split("/")
    if experiment not in lists:
        return
    places = _narrowed(store, text, _trials_of(store, lists[experiment]), parts)
    following = [*_open_values(places), *EXTREMES]
    if len(following) == len(EXTREMES):
        following = [*dict.fromkeys(str(p.entry.details.labels["seed"]) for p in places), *EXTREMES]
    yield from (f"{head}/{part}" for part in following if part.startswith(last))


def _open_values(places: Sequence[FoundTrial]) -> Iterator[str]:
    """What tells some trials apart beside their seeds, each value as an address has it."""
    for path in dict.fromkeys(name for place in places for name in place.values):
        values = list(dict.fromkeys(place.values.get(path) for place in places))
        for value in values if len(values) > 1 else ():
            if isinstance(value, int) and not isinstance(value, bool):
                yield f"{_leaf(path)}={value}"  # a whole number alone is a seed
            elif value is not None:
                yield repr(value) if isinstance(value, float) else number(value)


def _by_digits(store: Store, digits: str) -> str:
    entries = store.index().entries
    fitting = [name for name in sorted(entries) if name.startswith(digits)]
    if len(fitting) == 1:
        return fitting[0]
    near = fitting or sorted(entries, key=lambda name: (-_shared(name, digits), name))
    places = _places(store, near[:LISTED])
    found = (
        f"{len(fitting)} trials start with {digits}; give more digits"
        if fitting
        else (f"no trial starts with {digits}; the nearest")
    )
    raise UnknownName(f"{store.path}: {found}:\n{_listed(places, len(fitting))}")


def _shared(one: str, other: str) -> int:
    return next((i for i, (a, b) in enumerate(zip(one, other, strict=False)) if a != b), len(other))


def place_of(store: Store, trial_id: str) -> str:
    """Where a trial stands: its experiment and the cell in it; empty where none asks for it."""
    (place,) = _places(store, [trial_id])
    cell = ", ".join(f"{_leaf(path)} {number(value)}" for path, value in place.values.items())
    return ": ".join(part for part in (place.experiment, cell) if part)


def _places(store: Store, names: Sequence[str]) -> list[FoundTrial]:
    """Where trials stand; the first experiment that asks for one counts."""
    entries = store.index().entries
    known: dict[str, tuple[str, Mapping[str, Scalar]]] = {}
    for found in store.experiments().values():
        for item in found.trials:
            known.setdefault(item.trial_id, (found.experiment, item.values))
    return [FoundTrial(entries[name], *known.get(name, ("", {}))) for name in names]


def _by_place(store: Store, address: str, experiment: str, parts: Sequence[str]) -> str:
    lists, damaged = store.lists()
    if experiment in damaged:
        raise damaged[experiment]
    if experiment not in lists:
        from gaitlab.plugins import nearest

        known = ", ".join(lists) or "none"
        raise UnknownName(
            f"{store.path}: {address!r} means no trial{nearest(experiment, list(lists))}. Give "
            "the first digits of a trial, at least 4, or EXPERIMENT/VALUE/.../SEED. Experiments "
            f"here: {known}"
        )
    places = _trials_of(store, lists[experiment])
    extreme = parts[-1] if parts and parts[-1] in EXTREMES else None
    wanted = parts[:-1] if extreme else parts
    fitting = _narrowed(store, address, places, wanted)
    if extreme:
        fitting = _extreme(fitting, extreme) or fitting
    if len(fitting) == 1:
        return fitting[0].entry.trial_id
    raise UnknownName(
        f"{store.path}: {len(fitting)} trials are at {address}; add a value, a seed, or worst or "
        f"best:\n{_listed(fitting[:LISTED], len(fitting))}"
    )


def _trials_of(store: Store, found: TrialList) -> list[FoundTrial]:
    """The trials of an experiment that are in the store."""
    entries = store.index().entries
    return [
        FoundTrial(entries[item.trial_id], found.experiment, item.values)
        for item in found.trials
        if item.trial_id in entries
    ]


def _narrowed(
    store: Store, address: str, places: list[FoundTrial], parts: Iterable[str]
) -> list[FoundTrial]:
    """The trials that every part of an address fits."""
    for part in parts:
        fitting = [place for place in places if _fits(place, part)]
        if not fitting:
            raise UnknownName(
                f"{store.path}: no trial of {address!r} has {part!r}; there are:\n"
                f"{_listed(places[:LISTED], len(places))}"
            )
        places = fitting
    return places


def _fits(place: FoundTrial, part: str) -> bool:
    """Whether a part names a value, `path=value`, or a seed as a whole number."""
    path, equals, value = part.rpartition("=")
    labels = place.entry.details.labels
    if part.isdigit() or (equals and path == "seed"):
        return str(labels["seed"]) == value
    values = {**labels, **place.values}
    values.pop("seed", None)  # which is named by its digits, and would be found in 0.0
    if not equals:
        return any(_same(known, part) for known in values.values())
    return any(
        _same(known, value)
        for name, known in values.items()
        if (name == path or name.endswith(f".{path}"))
    )


def _same(known: Scalar, text: str) -> bool:
    if isinstance(known, bool) or not isinstance(known, int | float):
        return str(known) == text or number(known) == text
    try:
        return float(text) == known
    except ValueError:
        return False


def _extreme(places: list[FoundTrial], extreme: str) -> list[FoundTrial]:
    """The first to fall, or if none fell the one that walked least; or the opposite of that."""
    done = [place for place in places if place.entry.state == "DONE"]
    ordered = sorted(done, key=lambda place: (_merit(place), place.entry.trial_id))
    return ordered[:1] if extreme == "worst" else ordered[-1:]


def _merit(place: FoundTrial) -> tuple[bool, float]:
    metrics = place.entry.details.metrics
    key = "time_to_fall" if place.entry.fell else "distance"
    value = metrics.get(key)
    return not place.entry.fell, float(value) if isinstance(value, int | float) else 0.0


def _listed(places: Sequence[FoundTrial], count: int) -> str:
    rows = [
        [
            _short(place, places),
            place.experiment or "-",
            ", ".join(f"{_leaf(k)}={number(v)}" for k, v in place.values.items()),
            str(place.entry.details.labels["seed"]),
            _outcome(place.entry),
        ]
        for place in places
    ]
    more = f"\nand {count - len(places)} more" if count > len(places) else ""
    return columns(("trial", "experiment", "cell", "seed", "outcome"), rows) + more


def _short(place: FoundTrial, places: Sequence[FoundTrial]) -> str:
    """So many digits that no two of a list look alike."""
    name, others = place.entry.trial_id, {other.entry.trial_id for other in places}
    others.discard(name)
    return name[: max([SHOWN, *(_shared(name, other) + 1 for other in others)])]


def _leaf(path: str) -> str:
    return path.rpartition(".")[2]


def _outcome(entry: Entry) -> str:
    if entry.state != "DONE":
        return f"{entry.state}: {entry.reason}"
    metrics = entry.details.metrics
    if entry.fell:
        where = "fell standing" if metrics.get("fell_standing") else "fell"
        return f"{where} at {number(metrics.get('time_to_fall'))} s"
    return f"stayed up, {number(metrics.get('distance'))} m"
