"""A user's own Python file at work: what it imports and what it reads belongs to what it is.

Whatever such a file imports from outside the installed packages is loaded for it alone, straight
from the source, so that no bytecode, no earlier load and no file of the same name beside another
experiment answers in its place. Whatever is opened for reading while a line of it runs is noted,
with what it held. What happens where Python cannot see it, in a library that reads by itself or in
another process, is noted as unseen.
"""

from __future__ import annotations

import builtins
import hashlib
import importlib.abc
import importlib.util
import os
import site
import stat
import sys
import sysconfig
import threading
from collections.abc import Mapping, Sequence
from contextlib import suppress
from functools import lru_cache
from importlib.machinery import (
    ExtensionFileLoader,
    ModuleSpec,
    PathFinder,
    SourceFileLoader,
    SourcelessFileLoader,
)
from itertools import count
from pathlib import Path
from types import CodeType, FrameType, ModuleType
from typing import Any

PACKAGE = Path(__file__).parent.parent
START = "gaitlab_user_"  # of the names of the modules of users' files
READERS = {  # libraries that open files in machine code
    *("cv2", "duckdb", "fastparquet", "h5py", "lmdb", "netCDF4", "polars", "pyarrow"),
    *("rasterio", "tables", "vaex", "xarray", "zarr"),
}
THREADS = {"_thread", "concurrent", "joblib", "multiprocessing", "threading"}
UNSEEN = {  # events of Python after which nobody knows what was read
    **dict.fromkeys(("subprocess.Popen", "os.system", "os.exec"), "starts another program"),
    **dict.fromkeys(("os.posix_spawn", "os.fork", "os.forkpty"), "starts another process"),
    "ctypes.dlopen": "calls machine code",
    "socket.connect": "asks the network",
}
SHIPPED = ("surfaces", "motions")  # beside the package in a checkout
MACHINE = ("/proc", "/sys", "/dev", "/etc", "/usr/lib", "/usr/share", "/usr/lib64", "/lib")
HEARD = {"open", "sqlite3.connect", *UNSEEN}
BOOTSTRAP = "<frozen importlib._bootstrap"  # start of the files that Python's import runs in
PIECE = 1 << 20  # bytes that are hashed at a time

_numbers = count()
_at_work = threading.local()  # of a thread: whether it looks into a file on our own account
_packages: dict[str, OwnCode] = {}  # by the first part of the names of their modules
_sources: set[str] = set()  # of modules that users' files have loaded by other means than `import`


class OwnCode:
    """A user's file, loaded, and what it has touched since.

    Attributes:
        path: The file.
        text: What it held when it was loaded.
        module: Its module; empty until `execute`.
        read: SHA-256 of what other files held when it imported or last read them.
        unseen: Ways in which it may have read what nobody saw, in words.
    """

    def __init__(self, path: Path) -> None:
        self.path, self.text = path, path.read_bytes()
        self.read: dict[Path, str] = {}
        self.unseen: dict[str, None] = {}
        self.threaded = False  # whether it may let libraries read in threads of their own
        self._written: set[Path] = set()
        name = hashlib.sha256(str(path).encode() + b":" + self.text).hexdigest()[:16]
        self._package = ModuleType(f"{START}{name}_{next(_numbers)}")
        self._package.__path__ = [str(path.parent)]
        self.builtins = {**vars(builtins), "__import__": self._import}
        self.module = ModuleType(f"{self._package.__name__}.{path.stem}")
        self.module.__file__ = str(path)
        self.module.__package__ = self._package.__name__
        self.module.__builtins__ = self.builtins  # type: ignore[attr-defined]

    def execute(self) -> None:
        """Run the file from its text.

        Raises:
            Exception: Whatever the file raises.
        """
        _watch()
        _packages[self._package.__name__] = self
        sys.modules[self._package.__name__] = self._package
        sys.modules[self.module.__name__] = self.module
        importlib.invalidate_caches()
        for name, module in list(sys.modules.items()):
            if (
                getattr(module, "__file__", None) in _sources
                and name.partition(".")[0] not in _packages
            ):
                del sys.modules[name]  # or this file would be given what an earlier one loaded
        try:
            exec(compile(self.text, str(self.path), "exec"), self.module.__dict__)
        except BaseException:
            self._forget()
            raise

    def _forget(self) -> None:
        del _packages[self._package.__name__]
        for name in [name for name in sys.modules if self.owns(name)]:
            del sys.modules[name]

    def owns(self, module: str) -> bool:
        """Whether a module of this name was loaded for this file."""
        return module.partition(".")[0] == self._package.__name__

    @property
    def unchanged(self) -> bool:
        """Whether it and everything that it has read hold what they held then."""
        with suppress(OSError):
            return self.path.read_bytes() == self.text and all(
                digest_of(path) == known for path, known in self.read.items()
            )
        return False

    def note(self, path: Path) -> None:
        """Take a file that is being read into what the code is made of."""
        path = Path(os.path.abspath(path))
        if path == self.path or path in self._written or "__pycache__" in path.parts:
            return
        beside = path.is_relative_to(self.path.parent)  # and yet no environment or checkout there
        if is_installed(str(path), code=beside):
            return
        try:
            regular = stat.S_ISREG(path.stat().st_mode)
            if regular:
                self.read[path] = digest_of(path)
            elif not path.is_dir():
                self.unseen[f"reads {path}, which is no ordinary file"] = None
        except FileNotFoundError:
            return
        except OSError as error:
            self.unseen[f"reads {path}, which cannot be looked into ({error.strerror})"] = None

    def note_written(self, path: Path) -> None:
        """What it has written itself is no part of it, should it read that again."""
        self._written.add(Path(os.path.abspath(path)))

    def _import(
        self,
        name: str,
        globals: Mapping[str, Any] | None = None,
        locals: Mapping[str, Any] | None = None,
        fromlist: Sequence[str] = (),
        level: int = 0,
    ) -> ModuleType:
        """`import` of the file and of what is loaded for it."""
        first = name.partition(".")[0]
        if level == 0 and first in READERS:
            self.unseen[f"imports {first}, which reads files by itself"] = None
        self.threaded = self.threaded or first in THREADS
        try:
            if level == 0 and self._is_beside(first):
                place = {"__package__": self._package.__name__}
                return builtins.__import__(name, place, None, fromlist, 1)
            return builtins.__import__(name, globals, locals, fromlist, level)
        except ImportError as error:
            error.msg = str(error.msg).replace(f"{self._package.__name__}.", "")
            raise

    def _is_beside(self, name: str) -> bool:
        """Whether a module is the user's: beside the file, or where its path reaches.

        A folder without code of its own counts only if nothing else is called like it.
        """
        if name in ("gaitlab", "__main__") or name in sys.stdlib_module_names:
            return False
        private = f"{self._package.__name__}.{name}"
        if private in sys.modules:
            return True
        # A program's own folders are on Python's path too, and a file may have added some.
        further = [entry or os.getcwd() for entry in sys.path]
        places = [str(self.path.parent), *(p for p in further if not is_installed(p))]
        self._package.__path__ = list(dict.fromkeys(map(os.path.abspath, places)))
        found = PathFinder.find_spec(private, self._package.__path__)
        if found is None:
            return False
        return found.loader is not None or importlib.util.find_spec(name) is None


class _Loader(SourceFileLoader):
    """Loads a module for one user's file, from its source and never from bytecode."""

    def __init__(self, fullname: str, path: str, own: OwnCode) -> None:
        super().__init__(fullname, path)
        self._own = own

    def get_code(self, fullname: str) -> CodeType:
        self._own.note(Path(self.path))
        return self.source_to_code(self.get_data(self.path), self.path)

    def exec_module(self, module: ModuleType) -> None:
        module.__builtins__ = self._own.builtins  # type: ignore[attr-defined]
        super().exec_module(module)


class _Finder(importlib.abc.MetaPathFinder):
    """Finds the modules of users' files."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        own = _packages.get(fullname.partition(".")[0])
        found = PathFinder.find_spec(fullname, path) if own else None
        if own is None or found is None or found.origin is None:
            return found
        if isinstance(found.loader, SourceFileLoader):
            found.loader = _Loader(fullname, found.origin, own)
        elif isinstance(found.loader, ExtensionFileLoader | SourcelessFileLoader):
            own.note(Path(found.origin))
            own.unseen[f"imports {Path(found.origin).name}, which is no source"] = None
        return found


def digest_of(path: Path) -> str:
    """SHA-256 of what a file holds. 64 hex digits.

    Raises:
        OSError: If it cannot be read.
    """
    before, _at_work.looking = getattr(_at_work, "looking", False), True
    digest = hashlib.sha256()
    try:
        with path.open("rb") as content:
            while piece := content.read(PIECE):
                digest.update(piece)
    finally:
        _at_work.looking = before
    return digest.hexdigest()


@lru_cache(maxsize=1)
def _watch() -> None:
    """From now on, take note of what users' files do; a hook of Python's cannot be taken back."""
    sys.meta_path.insert(0, _Finder())
    sys.addaudithook(_heard)


def _heard(event: str, details: tuple[Any, ...]) -> None:
    if event not in HEARD or getattr(_at_work, "looking", False):
        return
    own, by_own_lines = _who(sys._getframe(1), at_once=event == "ctypes.dlopen")
    owners = [own] if own else [each for each in _packages.values() if each.threaded]
    if own is None and threading.current_thread() is threading.main_thread():
        return
    for owner in owners:
        if event in UNSEEN and by_own_lines:
            owner.unseen[UNSEEN[event]] = None
        elif event not in UNSEEN:
            with suppress(TypeError, ValueError, UnicodeError):  # no path, but an open file
                path, mode, flags = (*details, "r", 0)[:3]
                _opened(owner, Path(os.fsdecode(path)), mode, flags, own is None or by_own_lines)


def _opened(own: OwnCode, path: Path, mode: str | None, flags: int, by_own_lines: bool) -> None:
    how = mode if isinstance(mode, str) else ""
    if set(how) & set("wx") or (flags & (os.O_TRUNC | os.O_EXCL)):
        own.note_written(path)
    elif ("a" in how and "+" not in how) or flags & os.O_ACCMODE == os.O_WRONLY:
        return
    else:
        if path.suffix == ".pyc":
            with suppress(ValueError, NotImplementedError):
                path = Path(importlib.util.source_from_cache(str(path)))
        if path.suffix == ".py" and not is_installed(str(path)):
            _sources.add(str(path))
        inside = Path(os.path.abspath(path)).is_relative_to(own.path.parent)
        if by_own_lines or inside or path.suffix == ".py":
            own.note(path)


def _who(frame: FrameType | None, *, at_once: bool = False) -> tuple[OwnCode | None, bool]:
    """Whose code runs, and whether it does the thing, rather than a library that it imports.

    `at_once`: what a library that it calls does, the compiler of a function say, is not its own.
    """
    importing, by_own_lines = False, False
    while frame is not None:
        own = _packages.get(str(frame.f_globals.get("__name__", "")).partition(".")[0])
        if own is not None:
            return own, by_own_lines or not importing
        file = frame.f_code.co_filename
        importing = importing or file.startswith(BOOTSTRAP) or (at_once and _is_package(file))
        if not importing and file[:1] != "<" and not is_installed(file):
            by_own_lines = True
        frame = frame.f_back
    return None, False


@lru_cache(maxsize=4096)
def is_installed(path: str, code: bool = False) -> bool:
    """Whether a file came with Python, a package, gaitlab or the machine.

    Args:
        path: The file.
        code: Ask for Python, packages and gaitlab alone.
    """
    further = () if code else (*MACHINE, *(str(PACKAGE.parent / name) for name in SHIPPED))
    return any(
        path == place or path.startswith(f"{place}{os.sep}")
        for place in (*_python(), str(PACKAGE), *further)
    )


def _is_package(file: str) -> bool:
    standard = sysconfig.get_path("stdlib")
    return is_installed(file) and (not file.startswith(standard) or "site-packages" in file)


@lru_cache(maxsize=1)
def _python() -> tuple[str, ...]:
    names = ("stdlib", "platstdlib", "purelib", "platlib", "scripts")
    found = [sysconfig.get_path(name) for name in names]
    found += [*site.getsitepackages(), site.getusersitepackages(), os.path.dirname(os.__file__)]
    folders = ("bin", "etc", "include", "lib", "lib64", "share")  # a project may lie beside them
    prefixes = [p for p in (sys.prefix, sys.base_prefix) if p not in ("/", "/usr", "/usr/local")]
    found += [os.path.join(prefix, folder) for prefix in prefixes for folder in folders]
    return tuple({os.path.abspath(path) for path in found if path})
