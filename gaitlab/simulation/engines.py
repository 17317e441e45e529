"""The engines there are, each imported when a trial asks for it."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from typing import Any, NamedTuple

from gaitlab.errors import NoEngine
from gaitlab.model.settings import EngineName
from gaitlab.simulation.engine import Engine


class EngineKind(NamedTuple):
    """Where an engine is.

    Attributes:
        module: The module of its class.
        cls: The class, an `Engine`.
        package: What it imports, by the name it is imported by.
        version: How a version of that begins that is known; empty for any.
        install: How to get it.
    """

    module: str
    cls: str
    package: str
    version: str
    install: str


ENGINES: dict[EngineName, EngineKind] = {
    "bullet": EngineKind(
        "gaitlab.simulation.bullet.engine",
        "BulletEngine",
        "pybullet",
        "",
        "`pip install pybullet` has wheels for Linux on x86-64 up to Python 3.11; elsewhere "
        "`pip install 'gaitlab[mujoco]'` brings the engine mujoco, the default then",
    ),
    "mujoco": EngineKind(
        "gaitlab.simulation.mujoco.engine",
        "MujocoEngine",
        "mujoco",
        "4.0.",
        "`pip install 'gaitlab[mujoco]'`",
    ),
}


REFERENCE: EngineName = "bullet"


def engine_of(trial: Mapping[str, Any]) -> EngineName:
    """What simulates a trial in plain data."""
    name: EngineName = trial["engine"].get("name", "bullet")
    return name


def default_engine() -> EngineName:
    """What simulates a trial whose file names no engine.

    The reference where it is installed, else the first that is; the reference where none is.
    """
    installed = (name for name, kind in ENGINES.items() if find_spec(kind.package))
    return next(installed, REFERENCE)


def require_engine(name: EngineName) -> None:
    """Refuse an engine whose package is not installed, or is not of the version that is known.

    Raises:
        NoEngine: Says how to install it.
    """
    kind = ENGINES[name]
    if find_spec(kind.package) is None:
        raise NoEngine(
            f"engine {name} needs {kind.package}, which is not installed: {kind.install}"
        )
    if not (found := _version(kind.package)).startswith(kind.version):
        raise NoEngine(
            f"engine {name} needs {kind.package} {kind.version}x, found {found}: {kind.install}"
        )


@cache
def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "an unknown version"


def engine_named(name: EngineName) -> type[Engine]:
    """The engine of that name.

    Raises:
        NoEngine: If its package is not installed; says how to get it.
    """
    require_engine(name)
    kind = ENGINES[name]
    found: type[Engine] = getattr(import_module(kind.module), kind.cls)
    return found
