"""What a worker of a Dask cluster does with a trial.

It first makes sure that it is the driver's like: the same gaitlab, down to the code that makes
numbers, on the same Python, and where results go through a shared folder, with that folder in
sight. One trial at a time, however many threads Dask gives the process: an engine's state is the
process's. Whatever hangs or eats memory ends the process, and Dask gives its trial to another.
"""

from __future__ import annotations

import faulthandler
import os
import pickle
import platform
import socket
import sys
import threading
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

from gaitlab.errors import GaitlabError, StoreError, WrongValue
from gaitlab.model.settings import EngineName
from gaitlab.running.provenance import code_digest
from gaitlab.running.worker import answer, limit_memory, write_to
from gaitlab.simulation.engines import engine_of
from gaitlab.store import TrialRecord

SIGHT_TIME = 10.0  # s in which a folder on the network must show a file that was written before
INSTALL_ALIKE = "install the same gaitlab and the same Python on both"

Result: TypeAlias = TrialRecord | tuple[TrialRecord, bytes]


class Versions(NamedTuple):
    """What must be alike on driver and worker for numbers to be alike.

    Attributes:
        gaitlab: Version of the package; empty if it is not installed.
        python: Version of Python.
        code: Digest of all that makes numbers in the engine of the trial.
    """

    gaitlab: str
    python: str
    code: str

    def __str__(self) -> str:
        return f"gaitlab {self.gaitlab or 'missing'} (code {self.code}) on Python {self.python}"

    def alike(self, other: Versions) -> bool:
        """Whether they are; the last digit of Python's version does not matter."""
        mine, others = (found.python.split(".")[:2] for found in (self, other))
        return (self.gaitlab, self.code, mine) == (other.gaitlab, other.code, others)


def versions(engine: EngineName) -> Versions:
    """Those of this process."""
    try:
        package = version("gaitlab")
    except PackageNotFoundError:
        package = ""
    return Versions(package, platform.python_version(), code_digest(engine))


class Token(NamedTuple):
    """A file that the driver has written into the store, so that who reads it sees that store."""

    path: Path
    content: str


@dataclass(frozen=True, kw_only=True)
class Order:
    """A trial on its way to a worker.

    Attributes:
        trial_id: Identity of the trial.
        trial: The trial as plain data.
        timeout: Longest time it may take, in [s].
        task: What to do with it: commit it and give the record, or give its file as well.
        versions: Those of the driver.
        token: Where results go through a shared store, the proof that it is in sight.
        output: Folder for what a worker prints that would else write to the driver's terminal.
        memory: What the worker may allocate, in [byte]; None for as much as there is.
    """

    trial_id: str
    trial: Mapping[str, Any]
    timeout: float
    task: Callable[[str, Mapping[str, Any]], Result]
    versions: Versions
    token: Token | None
    output: Path | None = None
    memory: int | None = None


class Reply(NamedTuple):
    """What a worker says of a trial.

    Attributes:
        host: Its machine.
        result: What the task gave, or the error that ends the run.
    """

    host: str
    result: Result | Exception


_alone = threading.Lock()
_prepared: list[Order] = []  # the first order of this process
_seen: set[Token] = set()


CALL = "__import__('gaitlab.running.dask_worker', fromlist=['perform']).perform(order)"
"""A trial on its way as an expression of `order`: so the scheduler, which takes apart what it is
given, needs no gaitlab."""


def perform(pickled: bytes) -> Reply:
    """Carry out an order; errors are part of the reply, for Dask would say less of them."""
    order: Order = pickle.loads(pickled)
    with _alone:
        host = socket.gethostname()
        try:
            _require_alike(order, host)
            _require_sight(order.token, host)
        except GaitlabError as error:
            return Reply(host, error)
        _prepare(order)
        faulthandler.dump_traceback_later(order.timeout, exit=True)
        try:
            return Reply(host, _placed(answer(order.task, order.trial_id, order.trial), host))
        finally:
            faulthandler.cancel_dump_traceback_later()


def _require_alike(order: Order, host: str) -> None:
    own = versions(engine_of(order.trial))
    if not own.alike(order.versions):
        raise unlike(host, str(own), order.versions)


def unlike(host: str, there: str, here: Versions) -> WrongValue:
    """The error of a worker that is none of the driver's like."""
    return WrongValue(f"a worker on {host} has {there}, here is {here}: {INSTALL_ALIKE}")


def _require_sight(token: Token | None, host: str) -> None:
    """A folder of the network may show what is new in it only after a while."""
    if token is None or token in _seen:
        return
    end = time.monotonic() + SIGHT_TIME
    while not _sees(token):
        if time.monotonic() >= end:
            raise StoreError(
                f"{token.path.parent}: a worker on {host} does not see this folder, or another one "
                "in its place. Choose a folder that all machines share with --store DIR, or let "
                "results travel through Dask with --no-shared-store."
            )
        time.sleep(0.2)
    _seen.add(token)


def _sees(token: Token) -> bool:
    with suppress(OSError):
        os.listdir(token.path.parent)  # makes a network's folder look anew
        return token.path.read_text() == token.content
    return False


def _prepare(order: Order) -> None:
    """What is done once in a worker."""
    if _prepared:
        return
    _prepared.append(order)
    if order.output is not None:
        write_to(order.output / str(os.getpid()))
    elif not faulthandler.is_enabled():
        with suppress(OSError, ValueError):  # its output may be closed
            faulthandler.enable(file=sys.stderr)
    limit_memory(order.memory)


def _placed(result: Result | Exception, host: str) -> Result | Exception:
    """An error says on which machine it was raised."""
    if isinstance(result, Exception) and result.args and isinstance(result.args[0], str):
        result.args = (f"on {host}: {result.args[0]}", *result.args[1:])
    return result


PROBE = """
import platform, socket
from importlib.metadata import PackageNotFoundError, version
try:
    package = version("gaitlab")
except PackageNotFoundError:
    package = ""
try:
    from gaitlab.running.provenance import code_digest
    code = code_digest(engine)
except Exception as error:
    code = f"cannot be read: {type(error).__name__}"
found = socket.gethostname(), package, platform.python_version(), code
"""
"""Asks a worker for its versions, as text: one that has another gaitlab may know none of this."""


def probe(engine: EngineName) -> str:
    """The same as an expression."""
    return f"(lambda names: exec({PROBE!r}, names) or names['found'])({{'engine': {engine!r}}})"
