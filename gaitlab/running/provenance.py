"""Where a result comes from: versions, code, machine and time. No part of a trial's identity."""

from __future__ import annotations

import ast
import hashlib
import platform
import socket
import subprocess
import sys
from collections.abc import Iterator
from datetime import datetime, timezone
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from gaitlab.model.settings import EngineName
from gaitlab.plugins import IN_PACKAGE, SUFFIXES
from gaitlab.simulation.engines import ENGINES

PACKAGE = Path(__file__).parent.parent
NUMBERS = (
    "simulation.simulate",
    "metrics",
)  # what makes numbers, with all they import
TABLE = ".csv"  # numbers that a robot, gait or servo reads from beside its file
CPUINFO = Path("/proc/cpuinfo")  # where Linux names the processor
GIT_TIMEOUT = 10.0  # s; a slow network disk must not hold up a trial


def provenance(
    wall_time: float, engine: EngineName, processor_time: float | None = None
) -> dict[str, str | float | None]:
    """What is worth knowing about a run that has just ended.

    Args:
        wall_time: How long it took, in [s].
        engine: What simulated it.
        processor_time: How much of that it had a processor, in [s]; None if that is not known.
    """
    return {
        **_unchanging(engine),
        "host": socket.gethostname(),
        "finished": datetime.now(timezone.utc).isoformat(timespec="seconds"),
        "wall_time": round(wall_time, 3),
        **({} if processor_time is None else {"processor_time": round(processor_time, 3)}),
    }


@cache
def _unchanging(engine: EngineName) -> dict[str, str | None]:
    return {
        "gaitlab_version": _version("gaitlab"),
        "python_version": platform.python_version(),
        "numpy_version": _version("numpy"),
        "engine": engine,
        "engine_version": _version(ENGINES[engine].package),
        "numba_version": _version("numba"),
        "platform": f"{sys.platform}-{platform.machine()}",
        "git_commit": _git_commit(PACKAGE),
        "processor": processor(),
        "code": code_digest(engine),
    }


@cache
def code_digest(engine: EngineName = "bullet", package: Path = PACKAGE) -> str:
    """Digest of all that decides what a trial gives: code, shipped data, libraries. 16 hex digits.

    Another digest need not give other numbers, but the same one does: with it, a result found in
    a store is known to be what this code would give. It follows the imports, so a page or a
    command is no part of it.

    Args:
        engine: What simulates the trial.
        package: Folder of the package.
    """
    files, libraries = makers(engine, package)
    digest = hashlib.sha256()
    for path in sorted(files):
        inside = path.relative_to(package).as_posix()
        digest.update(f"{inside}\0".encode() + path.read_bytes() + b"\0")
    for library in sorted(libraries):
        digest.update(f"{library} {_version(library)}\0".encode())
    return digest.hexdigest()[:16]


def makers(engine: EngineName = "bullet", package: Path = PACKAGE) -> tuple[set[Path], set[str]]:
    """Files of the package that a trial's numbers follow from, and the libraries these import.

    Folders of which a trial loads files by name count whole, of the engines that of the trial.
    """
    files = {
        path
        for kind, folder in IN_PACKAGE.items()
        for path in (package / folder).rglob("*")
        if path.suffix in (*SUFFIXES[kind], TABLE)
    }
    todo = [ENGINES[engine].module, *(f"{package.name}.{part}" for part in NUMBERS)]
    todo += [name for path in files if path.suffix == ".py" for name in _imports(path)]
    libraries, seen = set[str](), set[str]()
    while todo:
        module = todo.pop()
        if module in seen or module == package.name:  # whose own file is for users alone
            continue
        seen.add(module)
        parent, _, name = module.rpartition(".")
        if module.partition(".")[0] != package.name:
            libraries.add(module.partition(".")[0])
            continue
        todo += [parent] if parent else []
        path = package.parent.joinpath(*module.split("."))
        found = [path / "__init__.py", path.with_suffix(".py")]
        for file in (file for file in found if name and file.is_file()):
            files.add(file)
            todo += _imports(file)
    return files, libraries - sys.stdlib_module_names


def _imports(path: Path) -> Iterator[str]:
    """Names of modules that a file imports anywhere, and of what it takes from them."""
    for node in ast.walk(ast.parse(path.read_bytes())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


@cache
def processor() -> str:
    """Model of the processor, on which the last bits of a simulation depend; never fails."""
    try:
        lines = CPUINFO.read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        lines = []
    models = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(models, "") or platform.processor() or platform.machine()


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None


def _git_commit(folder: Path) -> str | None:
    """Commit of the checkout that gaitlab runs from, `+` when files differ; None outside one."""
    commit = _git(folder, "rev-parse", "--short=12", "HEAD")
    tracked = _git(folder, "ls-files", "--error-unmatch", str(Path(__file__)))
    if not commit or tracked is None:
        return None
    return commit + ("+" if _git(folder, "status", "--porcelain", "--", ".") else "")


def _git(folder: Path, *arguments: str) -> str | None:
    command = ["git", "-C", str(folder), *arguments]
    try:
        done = subprocess.run(
            command,
            capture_output=True,
            text=True,
            timeout=GIT_TIMEOUT,
            check=True,
            stdin=subprocess.DEVNULL,
        )
    except (OSError, subprocess.SubprocessError):
        return None
    return done.stdout.strip()
