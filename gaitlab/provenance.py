"""Where a result comes from: versions, code, machine and time. No part of a trial's identity."""

from __future__ import annotations

import hashlib
import platform
import socket
import subprocess
import sys
from datetime import datetime, timezone
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

PACKAGE = Path(__file__).parent
# Parts of the package that no outcome of a trial depends on; whatever is not named here counts.
BESIDE_TRIALS = (
    *("audit", "cli", "dispatch", "documents", "executors", "experiment", "export", "optimize"),
    *("picture", "reference", "regression", "replay", "report", "shipped", "statistics", "store"),
    *("study", "errors.py", "objectives.py", "plan.py", "provenance.py", "__main__.py"),
)
CPUINFO = Path("/proc/cpuinfo")  # where Linux names the processor
GIT_TIMEOUT = 10.0  # s; a slow network disk must not hold up a trial


def provenance(wall_time: float) -> dict[str, str | float | None]:
    """What is worth knowing about a run that has just ended.

    Args:
        wall_time: How long it took, in [s].
    """
    return {
        **_unchanging(),
        "host": socket.gethostname(),
        "finished": datetime.now(timezone.utc).isoformat(timespec="seconds"),
        "wall_time": round(wall_time, 3),
    }


@cache
def _unchanging() -> dict[str, str | None]:
    return {
        "gaitlab_version": _version("gaitlab"),
        "python_version": platform.python_version(),
        "numpy_version": _version("numpy"),
        "pybullet_version": _version("pybullet"),
        "numba_version": _version("numba"),
        "platform": f"{sys.platform}-{platform.machine()}",
        "git_commit": _git_commit(PACKAGE),
        "processor": processor(),
        "code": code_digest(),
    }


@cache
def code_digest() -> str:
    """Digest of the files of this package that decide what a trial gives. 16 hex digits.

    Another digest need not give other numbers, but the same one does: with it, a result found in
    a store is known to be what this code would give.
    """
    digest = hashlib.sha256()
    for path in sorted(PACKAGE.rglob("*")):
        inside = path.relative_to(PACKAGE)
        if path.suffix in (".py", ".yaml") and inside.parts[0] not in BESIDE_TRIALS:
            digest.update(f"{inside.as_posix()}\0".encode() + path.read_bytes() + b"\0")
    return digest.hexdigest()[:16]


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
