"""What the cells of an experiment share, as digests: tells why a trial's identity has changed."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping, Sequence

import gaitlab.simulation.trial
from gaitlab.experiment import Experiment, Parts
from gaitlab.model.settings import LATE, SETTINGS
from gaitlab.parameters import canonical_json, values
from gaitlab.store import Listed, TrialList

DIGEST_LENGTH = 16  # hex digits; only ever compared with the digest of the same part
_SURFACE = "surface "  # start of a ground's name among the parts
_BALANCE = "balance"  # a part only where there is a controller
_OPTIONAL = (_BALANCE, *LATE)


def basis(experiment: Experiment) -> dict[str, str]:
    """Digest of each part that an experiment starts from, without what it varies."""
    parts, varied = experiment.parts, frozenset(experiment.varied)
    walkers = [_walker(each, varied) for each in experiment.walkers.values() or [parts]]
    owners = {
        **_shared(walkers),
        **{
            name: fixed
            for name in SETTINGS
            if (fixed := _fixed(name, getattr(parts, name), varied)) or name not in LATE
        },
        **{
            f"{_SURFACE}{name}": [ground.type, _fixed("surface", ground, varied)]
            for name, ground in parts.surfaces.items()
        },
    }
    digests = {name: _digest(content) for name, content in owners.items()}
    return {**digests, "physics version": str(gaitlab.simulation.trial.PHYSICS_VERSION)}


def _shared(walkers: Sequence[Mapping[str, object]]) -> dict[str, object]:
    """Parts of all walkers under one name each, so that one name may blame another walker's."""
    if len(walkers) == 1:
        return dict(walkers[0])
    known = dict.fromkeys(name for walker in walkers for name in walker)
    return {name: [walker.get(name) for walker in walkers] for name in known}


def _walker(parts: Parts, varied: frozenset[str]) -> dict[str, object]:
    """What a robot with its gait brings along."""
    return {
        "robot": [parts.robot_code.identity, _fixed("robot", parts.robot, varied)],
        "gait": [parts.gait_code.identity, _fixed("gait", parts.gait, varied)],
        "servo": [_fixed("servo", servo, varied) for servo in parts.servos({})],
        **_balance(parts, varied),
        **({"metrics": [c.identity for c in parts.metric_codes]} if parts.metric_codes else {}),
    }


def _balance(parts: Parts, varied: frozenset[str]) -> dict[str, object]:
    if parts.balance is None or parts.balance_code is None:
        return {}
    gains = _fixed(_BALANCE, parts.balance, varied)
    return {_BALANCE: [parts.balance_code.identity, gains]}


class Past:
    """Why trials are not those that the same experiment asked for before."""

    def __init__(self, now: Mapping[str, str], earlier: Iterable[TrialList]) -> None:
        self._now = now
        self._known = [
            (found.basis, {_place(listed): listed.trial_id for listed in found.trials})
            for found in earlier
        ]

    def reason(self, wanted: Listed) -> str:
        """`surface changed` for instance; empty if nothing like this trial was asked for."""
        place = _place(wanted)
        for before, ids in self._known:
            if ids.get(place, wanted.trial_id) != wanted.trial_id:
                surface = f"{_SURFACE}{wanted.values['surface']}"
                known = {**self._now, **{n: self._now.get(n, "") for n in _OPTIONAL}}
                names = [name for name in known if not name.startswith(_SURFACE) or name == surface]
                different = [name for name in names if _before(before, name, known) != known[name]]
                shown = [name.partition(" ")[0] if name == surface else name for name in different]
                return f"{' and '.join(shown)} changed" if shown else ""
        return ""


def _before(before: Mapping[str, str], name: str, now: Mapping[str, str]) -> str:
    """A part's digest then; what an older list does not name has not changed."""
    return before.get(name, "" if name in _OPTIONAL else now[name])


def _place(listed: Listed) -> str:
    """The cell and the replicate, by their values."""
    return canonical_json([listed.values, listed.seed])


def _fixed(group: str, owner: object, varied: frozenset[str]) -> dict[str, object]:
    return {path: v for path, v in values(owner).items() if f"{group}.{path}" not in varied}


def _digest(content: object) -> str:
    return hashlib.sha256(canonical_json(content).encode()).hexdigest()[:DIGEST_LENGTH]
