"""The storage of a search: a file of the store, or a database server that machines share."""

from __future__ import annotations

import re
import sqlite3
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple
from urllib.parse import quote, quote_plus

from optuna.exceptions import StorageInternalError
from optuna.storages import RDBStorage
from sqlalchemy import URL, make_url
from sqlalchemy.exc import ArgumentError, IntegrityError, ProgrammingError, SQLAlchemyError
from sqlalchemy.pool import NullPool

from gaitlab.errors import StoreError
from gaitlab.search.sampling import unlogged
from gaitlab.store import Store
from gaitlab.store.durable import NotAFile, open_to_read, refuse_links

PATIENCE = 60.0  # s to wait while another program, a dashboard for instance, reads the file
HIGHEST_PORT = 65535
CONNECT_TIME = 10  # s to wait for a server
MAKERS, PAUSE = 4, 1.0  # attempts to make the tables of a new database, s between two
FOLDER, FILE = "studies", "study.db"  # of a store
DRIVERS = {  # modules of each kind of server, of which the first that is installed is taken
    "postgresql": ("psycopg", "psycopg2"),
    "mysql": ("pymysql", "mysqldb"),
}
HIDDEN = "***"  # as SQLAlchemy writes it in place of a password
_SCHEME = re.compile(r"[A-Za-z][A-Za-z0-9+.]{0,30}")
_SECRET = re.compile(r"pass|pwd|secret|token|credential", re.IGNORECASE)  # name of a parameter
_ASSIGNED = re.compile(
    r"""(\b\w*(?:pass|pwd|secret|token|credential)\w*['"]?\s*[=:]\s*)('[^']*'|"[^"]*"|[^\s&,;]+)""",
    re.IGNORECASE,
)
_BEFORE_HOST = re.compile(r"(://[^\s/:@]*:)\S*@")
_FILE = (sqlite3.Error, OSError, NotAFile)  # what a file of its own refuses
INSTALL = {"postgresql": "psycopg2-binary", "mysql": "PyMySQL"}


def database_file(store: Store, name: str) -> Path:
    """The default database of a search."""
    return store.path / FOLDER / name / FILE


def file_storage(path: Path) -> RDBStorage:
    """The database in a file, which is made if need be.

    Raises:
        StoreError: If it cannot be opened.
    """
    with understood(str(path), path):
        _require_plain(path)
        path.parent.mkdir(parents=True, exist_ok=True)
        # By a creator, because a path with a `%` or `{` in it makes no address.
        return RDBStorage(
            "sqlite://",
            engine_kwargs={
                "creator": lambda: sqlite3.connect(path, timeout=PATIENCE),
                "poolclass": NullPool,
            },
        )


def _require_plain(path: Path) -> None:
    """SQLite opens what is there for writing, and its journals beside it, whatever they are.

    Raises:
        StoreError: If one is a link or no file.
    """
    refuse_links(path, path.parents[2])
    for file in (path.with_name(path.name + ending) for ending in ("", "-journal", "-wal", "-shm")):
        with suppress(FileNotFoundError):
            open_to_read(file).close()


def server_storage(address: str) -> RDBStorage:
    """The database that an address names.

    Raises:
        StoreError: If it cannot be reached.
    """
    with understood(shown(address), address=address):
        url = _with_driver(_parsed(address))
        for _ in range(MAKERS - 1):
            with suppress(IntegrityError, ProgrammingError):
                return _connected(url)
            time.sleep(PAUSE)  # another process was making the same tables
        return _connected(url)


class Opened(NamedTuple):
    """A storage that is open.

    Attributes:
        storage: Optuna's.
        place: Where it is, for messages; without a password.
        file: Its file, if it is the store's own.
    """

    storage: RDBStorage
    place: str
    file: Path | None


@contextmanager
def storage_at(name: str, store: Store, address: str | None) -> Iterator[Opened]:
    """The storage of a search of this name, open as long as the context lasts.

    Raises:
        StoreError: If it cannot be used.
    """
    with unlogged():
        if address is None:
            file = database_file(store, name)
            opened = Opened(file_storage(file), str(file), file)
        else:
            opened = Opened(server_storage(address), shown(address), None)
        try:
            yield opened
        finally:
            opened.storage.remove_session()
            opened.storage.engine.dispose()


def _connected(url: URL) -> RDBStorage:
    waiting = {"connect_timeout": CONNECT_TIME} if url.get_backend_name() in DRIVERS else {}
    return RDBStorage(
        url.render_as_string(hide_password=False),
        engine_kwargs={"connect_args": waiting, "pool_pre_ping": True},
    )


def _parsed(address: str) -> URL:
    """The address in its parts.

    Raises:
        ArgumentError: If it is none, also where SQLAlchemy trips over its host or port.
    """
    try:
        url = make_url(address)
    except ValueError:
        url = None
    if url is None or not (url.port is None or 0 < url.port <= HIGHEST_PORT):
        raise ArgumentError(f"a port is a number from 1 to {HIGHEST_PORT}, an IPv6 host in [...]")
    return url


def _with_driver(url: URL) -> URL:
    """The address with a driver that is installed, if it names none itself."""
    installed = [name for name in DRIVERS.get(url.drivername, ()) if find_spec(name)]
    return url.set(drivername=f"{url.drivername}+{installed[0]}") if installed else url


def shown(address: str) -> str:
    """An address without the passwords in it; of what is no address, the scheme alone."""
    try:
        url = make_url(address)
    except (SQLAlchemyError, ValueError):
        scheme, parted, _ = address.partition("://")
        return f"{scheme}://{HIDDEN}" if parted and _SCHEME.fullmatch(scheme) else HIDDEN
    secret = {name: HIDDEN for name in url.query if _SECRET.search(name)}
    return url.update_query_dict(secret).render_as_string(hide_password=True)


def without_secrets(text: str, address: str | None = None) -> str:
    """What a driver says, without the passwords that it repeats.

    Args:
        text: Its words.
        address: The address that they are about, if it is known.
    """
    for secret in sorted(_secrets(address or ""), key=len, reverse=True):
        text = text.replace(secret, HIDDEN)
    return _ASSIGNED.sub(rf"\1{HIDDEN}", _BEFORE_HOST.sub(rf"\1{HIDDEN}@", text))


def _secrets(address: str) -> set[str]:
    """The address itself and every password in it, as it is written and as it is meant."""
    whole = {address, address.partition("://")[2]}
    try:
        url = make_url(address)
    except (SQLAlchemyError, ValueError):
        return whole - {""}
    given = [str(url.password or "")]
    for name, value in url.query.items():
        if _SECRET.search(name):
            given += [value] if isinstance(value, str) else value
    return {*whole, *given, *map(quote, given), *map(quote_plus, given)} - {""}


@contextmanager
def understood(where: str, file: Path | None = None, address: str | None = None) -> Iterator[None]:
    """What a database refuses, in the user's words and without passwords.

    Args:
        where: The database, for the message.
        file: Its file, if it is the store's own.
        address: Its address as it was given.

    Raises:
        StoreError: If it refuses.
    """
    try:
        yield
    except (SQLAlchemyError, StorageInternalError, ImportError, *_FILE) as error:
        advice = _advice(error, file, address)
        raise StoreError(f"{where}: {advice}") from error
    except (RuntimeError, ValueError, TypeError) as error:  # another version's tables, a port "x"
        if address is None and not isinstance(error, RuntimeError):
            raise
        raise StoreError(f"{where}: {without_secrets(str(error), address)}") from error


def _advice(error: Exception, file: Path | None, address: str | None) -> str:
    cause = error.__cause__ or error
    text = str(cause).partition("[SQL:")[0].partition("(Background")[0]
    reason = " ".join(without_secrets(text, address).split())
    if isinstance(error, ImportError):
        how = ", ".join(f"`pip install {name}` for {kind}" for kind, name in INSTALL.items())
        return f"its driver is not installed ({reason}): {how}"
    if file is not None:
        return (
            f"the database of the search cannot be used ({reason}). Put the file right, or move it "
            "away: `gaitlab optimize` makes it anew from the trials of the store, which are safe"
        )
    return (
        f"the database cannot be used ({reason}). An address looks like "
        "postgresql://user:password@host/name, mysql://user:password@host/name or "
        "sqlite:///file.db; is the server running, and may you use it? What is committed is safe; "
        "the same command goes on from there"
    )
