"""The engines there are, each imported when a trial asks for it."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from importlib.util import find_spec
from typing import Any, NamedTuple

from gaitlab.errors import WrongValue
from gaitlab.model.settings import EngineName
from gaitlab.simulation.engine import Engine


class EngineKind(NamedTuple):
    """Where an engine is.

    Attributes:
        module: The module of its class.
        cls: The class, an `Engine`.
        package: What it imports, by the name it is imported by.
        install: How to get that.
    """

    module: str
    cls: str
    package: str
    install: str


ENGINES: dict[EngineName, EngineKind] = {
    "bullet": EngineKind(
        "gaitlab.simulation.bullet.engine",
        "BulletEngine",
        "pybullet",
        "`pip install pybullet`, which has wheels for Python 3.11 and older on Linux x86-64 alone",
    ),
    "mujoco": EngineKind(
        "gaitlab.simulation.mujoco.engine",
        "MujocoEngine",
        "mujoco",
        "`pip install 'gaitlab[mujoco]'`",
    ),
}


def engine_of(trial: Mapping[str, Any]) -> EngineName:
    """What simulates a trial in plain data."""
    name: EngineName = trial["engine"].get("name", "bullet")
    return name


def require_engine(name: EngineName) -> None:
    """Refuse an engine whose package is not installed.

    Raises:
        WrongValue: Says how to install it.
    """
    kind = ENGINES[name]
    if find_spec(kind.package) is None:
        raise WrongValue(
            f"engine {name} needs {kind.package}, which is not installed: {kind.install}"
        )


def engine_named(name: EngineName) -> type[Engine]:
    """The engine of that name.

    Raises:
        WrongValue: If its package is not installed; says how to get it.
    """
    require_engine(name)
    kind = ENGINES[name]
    found: type[Engine] = getattr(import_module(kind.module), kind.cls)
    return found
