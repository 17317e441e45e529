"""A trial: everything one simulation depends on, as numbers, and what it is called by.

`Trial.id` hashes the numbers and never a name, so an edited surface never lets an old result
answer for the new ground, and a comment in it changes nothing.
"""

from __future__ import annotations

import dataclasses
import hashlib
import operator
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from math import hypot, inf
from pathlib import Path
from typing import Any

from gaitlab.errors import WrongValue
from gaitlab.metrics import take_in
from gaitlab.model import Robot
from gaitlab.model.balance import Balance
from gaitlab.model.gait import Gait
from gaitlab.model.servo import Servo
from gaitlab.model.settings import LATE, SETTINGS, EngineSettings, Horizon, Push, Slope, Spread
from gaitlab.parameters import Value, canonical_json, fragment, instance, values
from gaitlab.plugins import (
    CodeKind,
    Files,
    Kind,
    code_digest,
    is_code,
    is_shipped,
    label,
    load_class,
    locate,
    user_code,
)
from gaitlab.plugins.own_code import digest_of
from gaitlab.surfaces import SURFACE_TYPES, Surface

# Raise it when a change of the simulation, of a shipped gait or of a shipped robot gives other
# numbers for the same trial: every stored result is then simulated anew.
PHYSICS_VERSION = 2
CODED: tuple[CodeKind, ...] = ("robot", "gait", "balance")  # parts of a trial that are code
SHOWN_FILES = 5  # of what a file of code is made of, in a message
ID_LENGTH = 32  # hex digits, 128 bits: no collision in any store


@dataclass(frozen=True, kw_only=True)
class Names:
    """What the experiment calls its parts, `balance` if any; outside the identity."""

    robot: str
    gait: str
    surface: str
    balance: str | None = None

    def to_dict(self) -> dict[str, str]:
        """The names there are."""
        return {kind: name for kind, name in dataclasses.asdict(self).items() if name}


@dataclass(frozen=True, kw_only=True)
class Plugin:
    """Code of a robot, gait, balance controller or metric.

    Attributes:
        name: Name of a shipped one, the absolute file of a user's own.
        digest: SHA-256 of the text of a user's own; None for a shipped one.
        files: What else a user's own is made of: the modules that it imports and the files that it
            reads, each by its path from the folder of the file, with its SHA-256.
        declared: Whether the experiment says which files those are that nobody sees it read.
    """

    name: str
    digest: str | None
    files: Files = ()
    declared: bool = False

    @property
    def is_code(self) -> bool:
        """Whether it is Python of the user's own, which may read what nobody sees."""
        return self.digest is not None and is_code(self.name)

    @property
    def identity(self) -> str:
        """What tells it apart: its text and its files, or for a shipped one its name."""
        if not self.files:
            return self.name if self.digest is None else f"sha256:{self.digest}"
        whole = canonical_json([self.digest, *self.files])
        return f"sha256:{hashlib.sha256(whole.encode()).hexdigest()}"

    @property
    def told(self) -> str:
        """Its file, and in brackets what else it is made of."""
        names = [name for name, _ in self.files]
        more = [f"and {len(names) - SHOWN_FILES} more"] if len(names) > SHOWN_FILES else []
        return f"{self.name} ({', '.join([*names[:SHOWN_FILES], *more])})" if names else self.name

    def to_dict(self) -> dict[str, Any]:
        """It as JSON data; what it does not have is left out."""
        further = {"files": dict(self.files), "declared": self.declared}
        used = {key: value for key, value in further.items() if value}
        return {"name": self.name, "digest": self.digest, **used}

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Plugin:
        """What `to_dict` described."""
        return cls(**{**data, "files": tuple(sorted(data.get("files", {}).items()))})

    def file(self, name: str) -> Path:
        """Where one of its files is."""
        return Path(os.path.abspath(Path(self.name).parent / name))

    def completed(self, declared: Sequence[Path] | None) -> Plugin:
        """The same with every file that it has read since it was loaded, and those declared.

        Args:
            declared: What the experiment says that it depends on; None if it does not say.

        Raises:
            WrongValue: If it may have read what nobody saw, and nothing is declared.
        """
        if not self.is_code:
            return self
        own = user_code(Path(self.name))
        if own.unseen and declared is None:
            raise WrongValue(f"{own.path.name} {_unseen(own.unseen)}")
        found = {**own.read, **{path: digest_of(path) for path in declared or ()}}
        folder = own.path.parent
        files = {Path(os.path.relpath(path, folder)).as_posix(): d for path, d in found.items()}
        files.pop(own.path.name, None)
        return dataclasses.replace(
            self, files=tuple(sorted(files.items())), declared=declared is not None
        )

    def require_complete(self) -> None:
        """Refuse what was made with a file that planning did not know of.

        Raises:
            WrongValue: Names the file, and how to declare it.
        """
        if not self.is_code:
            return
        own = user_code(Path(self.name), self.files)
        if own.unseen and not self.declared:
            raise WrongValue(f"{own.path.name} {_unseen(own.unseen)}")
        known = {self.file(name): digest for name, digest in self.files}
        for path, digest in own.read.items():
            if path not in known:
                raise WrongValue(
                    f"{own.path.name} has read {path}, which it did not read when the trial was "
                    "planned, so that the trial is not named by it; write `depends: "
                    f"[{os.path.relpath(path)}]` into the experiment, relative to its file"
                )
            if digest != known[path]:
                raise WrongValue(f"{path} {_CHANGED}; run the experiment again")


_CHANGED = "has changed since the trial was planned"


def _unseen(ways: Mapping[str, object]) -> str:
    return (
        f"{' and '.join(ways)}; what it reads there belongs to every trial and cannot be seen. Say "
        "what it is: `depends: [table.csv]` in the experiment lists files or folders, "
        "`depends: []` says that there are none"
    )


def plugin(kind: Kind, name: str, relative_to: Path | None = None) -> Plugin:
    """Reference to the code that a name in a file stands for.

    Raises:
        UnknownName: If there is no such file.
    """
    path = locate(kind, name, relative_to)
    called = path.stem if is_shipped(kind, path) else str(path)
    return Plugin(name=called, digest=code_digest(kind, name, relative_to))


class _Same(tuple[Any, ...]):
    """Parts of a trial, equal when they are the same objects: the seeds of a cell share them all.

    Comparing their numbers instead takes most of the time in which a large plan is named.
    """

    __slots__ = ()

    def __hash__(self) -> int:
        return hash(tuple(map(id, self)))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Same) and all(map(operator.is_, self, other))


@lru_cache(maxsize=64)
def _around_seed(parts: _Same, physics_version: int) -> tuple[bytes, bytes]:
    """What an identity hashes before and after the seed; its names stand in alphabetic order."""
    codes, (metrics, engine, horizon, *late), walker = parts[:3], parts[3:8], parts[8:]
    gait, robot, balance, servos, spread, surface = walker
    pairs = zip(CODED, codes, strict=True)
    code: dict[str, object] = {kind: each.identity for kind, each in pairs if each}
    if metrics:
        code["metrics"] = {label(each.name): each.identity for each in metrics}
    before = {
        **({} if balance is None else {"balance": fragment(balance)}),
        "code": canonical_json(code),
        "engine": fragment(engine),
        "gait": fragment(gait),
        "horizon": fragment(horizon),
        "physics_version": str(physics_version),
        **({"push": fragment(late[1])} if values(late[1]) else {}),
        "robot": fragment(robot),
    }
    after = {
        **({"slope": fragment(late[0])} if values(late[0]) else {}),
        "servos": f"[{','.join(fragment(servo) for servo in servos)}]",
        "spread": fragment(spread),
        "surface": fragment(surface),
        "surface_type": canonical_json(surface.type),
    }
    return f'{{{_members(before)},"seed":'.encode(), f",{_members(after)}}}".encode()


def _members(parts: Mapping[str, str]) -> str:
    return ",".join(f'"{name}":{part}' for name, part in parts.items())


def duration(gait: Gait, horizon: Horizon) -> float:
    """Simulated time of a trial in which the robot stays up and walks as commanded, in [s]."""
    step = hypot(gait.step_length, getattr(gait, "side_step", 0.0))
    speed = 2.0 * step / gait.gait_period
    distance_time = horizon.distance / speed if speed else inf
    walking = min(horizon.cycles * gait.gait_period, horizon.time, distance_time)
    return gait.startup_time + walking


def require_in_time(push: Push, gait: Gait, horizon: Horizon) -> None:
    """Refuse a push that has not ended when the trial does.

    Raises:
        WrongValue: Says when both end, and what to change.
    """
    if not push.impulse:
        return
    begin, last = push.begin(gait.startup_time, gait.gait_period), duration(gait, horizon)
    if begin + push.duration > last + 1e-9:
        raise WrongValue(
            f"the push of cycle {push.cycle}, instant {push.instant:g}, takes from {begin:.3f} to "
            f"{begin + push.duration:.3f} s, but the trial is over after {last:.3f} s; lower "
            "push.cycle, or raise horizon.cycles, horizon.time and horizon.distance"
        )


@dataclass(frozen=True, kw_only=True)
class Trial:
    """One simulation, resolved to numbers.

    Attributes:
        robot: The robot.
        gait: Its gait.
        surface: The ground.
        servos: One servo a driven joint, in the order of the robot's tree.
        engine: How the engine integrates.
        horizon: When the trial ends.
        spread: How much replicates differ.
        slope: How the ground is tilted.
        push: What pushes the robot.
        seed: Replicate number; all random streams start from it.
        names: What robot, gait and surface are called; outside the identity.
        robot_code: Code of the robot.
        gait_code: Code of the gait.
        balance: Its balance controller; None for a gait that is walked as it is.
        balance_code: Code of that; None without one.
        metric_codes: Code of the user's own metrics.
    """

    robot: Robot
    gait: Gait
    surface: Surface
    servos: tuple[Servo, ...]
    engine: EngineSettings = field(default_factory=EngineSettings)
    horizon: Horizon = field(default_factory=Horizon)
    spread: Spread = field(default_factory=Spread)
    slope: Slope = field(default_factory=Slope)
    push: Push = field(default_factory=Push)
    seed: int
    names: Names
    robot_code: Plugin
    gait_code: Plugin
    balance: Balance | None = None
    balance_code: Plugin | None = None
    metric_codes: tuple[Plugin, ...] = ()

    def __post_init__(self) -> None:
        if (self.balance is None) != (self.balance_code is None):
            raise ValueError("a balance controller and its code come together")
        require_in_time(self.push, self.gait, self.horizon)

    @cached_property
    def id(self) -> str:
        """Identity: hash of every value the simulation depends on, of no name. 32 hex digits."""
        codes = (getattr(self, f"{kind}_code") for kind in CODED)
        walker = (self.gait, self.robot, self.balance, self.servos, self.spread, self.surface)
        settings = (self.engine, self.horizon, self.slope, self.push)
        parts = _Same((*codes, self.metric_codes, *settings, *walker))
        before, after = _around_seed(parts, PHYSICS_VERSION)
        text = before + str(int(self.seed)).encode() + after
        return hashlib.sha256(text).hexdigest()[:ID_LENGTH]

    def to_dict(self) -> dict[str, Any]:
        """The whole trial as JSON data, from which another process rebuilds it."""
        metrics = [code.to_dict() for code in self.metric_codes]
        return {
            "physics_version": PHYSICS_VERSION,
            "names": self.names.to_dict(),
            **{
                kind: {"code": code.to_dict(), "values": values(getattr(self, kind))}
                for kind in CODED
                if (code := getattr(self, f"{kind}_code")) is not None
            },
            **({"metrics": metrics} if metrics else {}),
            "surface": {"type": self.surface.type, "values": values(self.surface)},
            "servos": [values(servo) for servo in self.servos],
            "engine": values(self.engine),
            "horizon": values(self.horizon),
            "spread": values(self.spread),
            **{name: found for name in LATE if (found := values(getattr(self, name)))},
            "seed": self.seed,
        }

    def require_complete(self) -> None:
        """Refuse a result that rests on a file of which the identity knows nothing.

        Raises:
            WrongValue: Names the file of the user's own and what it has read.
        """
        parts: list[Plugin | None] = [getattr(self, f"{kind}_code") for kind in CODED]
        for code in (*parts, *self.metric_codes):
            if code is not None:
                code.require_complete()

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Trial:
        """The trial that `to_dict` described.

        Raises:
            UnknownName: If the file of a user's own robot or gait is gone.
            WrongValue: If that file has changed since, or another version or somebody else wrote
                the data.
        """
        try:
            return cls._made(data)
        except (KeyError, TypeError, AttributeError, ValueError) as error:
            raise WrongValue(
                f"the trial cannot be made from its record ({type(error).__name__}: {error}): "
                "another version of gaitlab wrote it, or somebody else"
            ) from error

    @classmethod
    def _made(cls, data: Mapping[str, Any]) -> Trial:
        codes = {kind: Plugin.from_dict(data[kind]["code"]) for kind in CODED if kind in data}
        made = {kind: _unpacked(kind, codes[kind], data[kind]["values"]) for kind in codes}
        metrics = tuple(Plugin.from_dict(code) for code in data.get("metrics", ()))
        for code in metrics:
            _require_unchanged("metric", code)
            take_in(Path(code.name), code.files)
        return cls(
            robot=made["robot"],
            gait=made["gait"],
            balance=made.get("balance"),
            surface=instance(SURFACE_TYPES[data["surface"]["type"]], data["surface"]["values"]),
            servos=tuple(instance(Servo, servo) for servo in data["servos"]),
            **{
                n: instance(cls, data[n])
                for n, cls in SETTINGS.items()
                if n in data or n not in LATE
            },
            seed=operator.index(data["seed"]),
            names=Names(**data["names"]),
            robot_code=codes["robot"],
            gait_code=codes["gait"],
            balance_code=codes.get("balance"),
            metric_codes=metrics,
        )


def own_code(data: Mapping[str, Any]) -> list[Plugin]:
    """Code of the user's own that a trial in plain data runs when it is made."""
    parts = (data.get(kind) for kind in CODED)
    codes = [part.get("code") for part in parts if isinstance(part, Mapping)]
    metrics = data.get("metrics", ())
    codes += metrics if isinstance(metrics, list | tuple) else ()
    found = [
        Plugin(name=str(code.get("name")), digest=code.get("digest"))
        for code in codes
        if isinstance(code, Mapping)
    ]
    return [code for code in found if code.is_code]


def _unpacked(kind: CodeKind, code: Plugin, given: Mapping[str, Value]) -> Any:
    _require_unchanged(kind, code)
    return instance(load_class(kind, code.name, files=code.files), given)


def _require_unchanged(kind: Kind, code: Plugin) -> None:
    found = code_digest(kind, code.name)
    if found != code.digest:
        raise WrongValue(
            f"{code.name} {_CHANGED} (SHA-256 {code.digest} then, {found} now); "
            "plan the experiment again"
        )
    for name, digest in code.files:
        path = code.file(name)
        if not path.is_file() or digest_of(path) != digest:
            what = _CHANGED if path.is_file() else "is gone since the trial was planned"
            raise WrongValue(
                f"{path} {what}, and {Path(code.name).name} is made of it; "
                "plan the experiment again"
            )
