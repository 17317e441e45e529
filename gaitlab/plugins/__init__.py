"""Names in YAML are names of files: where they are, and the classes inside them.

`gait: eros` is `gaitlab/gaits/eros.py`; `grass_50mm` is `surfaces/grass_50mm.yaml`, looked for
in the working directory first and among the shipped files second. A value with a suffix is a
file of the user's own, relative to the file that names it. Python is loaded only when named.
"""

from __future__ import annotations

import ast
import dataclasses
import difflib
import hashlib
import importlib
import os
import re
import stat
import traceback
from collections.abc import Iterable
from functools import cache
from os.path import expanduser
from pathlib import Path
from typing import Literal

from gaitlab.errors import FileError, Problem, UnknownName
from gaitlab.parameters import parameter_table
from gaitlab.plugins.own_code import OwnCode

Kind = Literal["gait", "robot", "balance", "metric", "servo", "surface", "motion", "experiment"]
CodeKind = Literal["gait", "robot", "balance"]  # kinds whose file holds a dataclass
KINDS: tuple[Kind, ...] = (
    *("gait", "robot", "balance", "metric", "servo", "surface", "motion", "experiment"),
)

PACKAGE = Path(__file__).parent.parent
IN_PACKAGE: dict[str, str] = {
    "gait": "gaits",
    "robot": "robots",
    "balance": "balance",
    "metric": "metrics",
    "servo": "servos",
}
MOVED = {  # what files of users imported before the package had rooms, and its present name
    "gaitlab.body": "gaitlab.model",
    "gaitlab.imu": "gaitlab.model.imu",
    "gaitlab.kinematics.leg": "gaitlab.robots.eros",
    "gaitlab.limbs": "gaitlab.model.limbs",
    "gaitlab.motion": "gaitlab.model.gait",
    "gaitlab.soles": "gaitlab.model.soles",
}
BESIDE_PACKAGE: dict[str, str] = {
    "surface": "surfaces",
    "motion": "motions",
    "experiment": "experiments",
}
WITHIN: dict[str, tuple[str, ...]] = {  # folders that names reach into
    "experiment": ("studies", "reproduction"),
}
SUFFIXES: dict[str, tuple[str, ...]] = {
    "gait": (".py",),
    "robot": (".py", ".yaml", ".yml", ".urdf", ".xacro"),
    "balance": (".py",),
    "metric": (".py",),
    "servo": (".yaml", ".yml"),
    "surface": (".yaml", ".yml"),
    "motion": (".yaml", ".yml"),
    "experiment": (".yaml", ".yml"),
}
READERS: dict[str, str] = {"robot": "gaitlab.model.foreign.robot_file"}  # of files without code
MEMBERS: dict[str, tuple[str, ...]] = {  # of their protocols
    "gait": ("step_length", "hip_height", "gait_period", "startup_time", "feet"),
    "robot": ("name", "feet", "tree", "sole", "joint_targets", "hip_offset"),
    "balance": ("imu", "joints", "controller"),
}
INSTEAD = {"feet": "feet_on"}  # members that another one stands in for
Files = tuple[tuple[str, str], ...]  # names beside a file, each with the SHA-256 of what it holds
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,99}")


_loaded: dict[tuple[Path, Files], OwnCode] = {}


def nearest(name: str, known: Iterable[str]) -> str:
    """`; did you mean ...?` for a misspelt name, empty when nothing is near."""
    near = difflib.get_close_matches(name, list(known), n=1, cutoff=0.6)
    return f"; did you mean {near[0]!r}?" if near else ""


def suggestion(name: str, known: Iterable[str]) -> str:
    """The nearest known name and all of them, as the end of a message."""
    names = list(known)
    return f"{nearest(name, names) or '.'} Known: {', '.join(names) if names else 'none'}"


def folders(kind: Kind) -> list[Path]:
    """Folders that names of a kind are looked for in, the first wins."""
    if kind in IN_PACKAGE:
        return [PACKAGE / IN_PACKAGE[kind]]
    folder = BESIDE_PACKAGE[kind]
    wheel = PACKAGE / "shipped" / folder
    places = [Path.cwd() / folder, wheel if wheel.is_dir() else PACKAGE.parent / folder]
    return [found for place in places for found in (place, *_within(kind, place))]


def _within(kind: Kind, folder: Path) -> list[Path]:
    return [folder / name for name in WITHIN.get(kind, ())]


def names(kind: Kind) -> list[str]:
    """All names of a kind that can be asked for, sorted."""
    if kind == "metric":
        return sorted(_metrics())
    files = (file for folder in folders(kind) for file in _files(folder, SUFFIXES[kind][0]))
    return sorted({file.stem for file in files if not file.stem.startswith("_")})


@cache
def _metrics() -> dict[str, Path]:
    """The family's file of each metric, read without loading it: a list of names shall be quick."""
    return {
        node.name: file
        for folder in folders("metric")
        for file in _files(folder, ".py")
        for node in ast.parse(file.read_bytes()).body
        if isinstance(node, ast.FunctionDef) and node.decorator_list
    }


def _files(folder: Path, suffix: str) -> list[Path]:
    return sorted(folder.glob(f"*{suffix}")) if folder.is_dir() else []


def is_file_name(name: str) -> bool:
    """Whether a value in YAML means a file of the user's own rather than a name."""
    return "/" in name or "\\" in name or Path(name).suffix != ""


def label(name: str) -> str:
    """What a name or a file is called in tables: the stem of the file."""
    return Path(name).stem if is_file_name(name) else name


def shown(value: str) -> str:
    """A file of the user's own by its name, as tables have it; any other text as it is."""
    return Path(value).name if Path(value).is_absolute() else value


def locate(kind: Kind, name: str, relative_to: Path | None = None) -> Path:
    """File that a name stands for.

    Args:
        kind: What is looked for.
        name: A name, or a file with its suffix.
        relative_to: Folder that a relative file starts from; the working directory by default.

    Raises:
        UnknownName: If nothing of that name or no such file is there.
    """
    _refuse_dangerous(kind, name)
    if is_file_name(name):
        return _own_file(kind, name, relative_to or Path.cwd())
    if kind == "metric" and name in _metrics():
        return _metrics()[name]
    for folder in folders(kind):
        file = folder / f"{name}{SUFFIXES[kind][0]}"
        if kind != "metric" and NAME.fullmatch(name) and file.is_file():
            return file
    example = name if NAME.fullmatch(name) else f"my_{kind}"
    own = f"a file of your own is written with its suffix, ./{example[:40]}{SUFFIXES[kind][0]}"
    raise UnknownName(f"no {kind} is called {name!r}{suggestion(name, names(kind))}; {own}")


def _refuse_dangerous(kind: Kind, name: str) -> None:
    if not name.isprintable() or len(name) > 1000:
        raise UnknownName(
            f"{name[:60]!r} is no name of any {kind}: "
            f"at most 1000 printable characters are allowed{suggestion('', names(kind))}"
        )


def _own_file(kind: Kind, name: str, folder: Path) -> Path:
    allowed, what = SUFFIXES[kind], _what_is_there(folder, name)
    known = suggestion(label(name), names(kind))
    if what == "a directory":
        raise UnknownName(f"{name!r} is a directory; give a {allowed[0]} file in it{known}")
    if Path(name).suffix.lower() not in allowed:
        raise UnknownName(
            f"{name!r} names no {kind}: a file of your own ends in {' or '.join(allowed)}, "
            f"a shipped {kind} is named without a folder{known}"
        )
    file = folder / expanduser(name)
    if what != "a file":
        beside = [found.name for found in _files(file.parent, allowed[0])]
        near = nearest(file.name, beside) or known
        kinds = " or ".join(allowed)
        raise UnknownName(f"{name!r}: there is {what} {file}; give a {kinds} file{near}")
    # The folder is resolved but a link keeps its own name, which is what the results are called.
    return file.parent.resolve() / file.name


def _what_is_there(folder: Path, name: str) -> str:
    """`a file`, `a directory` or in words why it is neither."""
    try:
        file = os.path.realpath(folder / expanduser(name))
        mode = os.stat(file).st_mode
        if stat.S_ISDIR(mode):
            return "a directory"
        return "a file" if stat.S_ISREG(mode) else "no file"
    except (FileNotFoundError, NotADirectoryError):
        return "no file"
    except OSError as error:
        return f"no way ({error.strerror}) to"


def is_shipped(kind: Kind, path: Path) -> bool:
    """Whether a Python plug-in belongs to the package and is identified by its name."""
    return kind in IN_PACKAGE and path.parent == PACKAGE / IN_PACKAGE[kind]


def code_digest(kind: Kind, name: str, relative_to: Path | None = None) -> str | None:
    """SHA-256 of a user's own plug-in, its text or the numbers it describes; None for a shipped."""
    path = locate(kind, name, relative_to)
    if not is_code(path) and kind in READERS:
        digest: str = importlib.import_module(READERS[kind]).load_robot(path).digest
        return digest
    return None if is_shipped(kind, path) else hashlib.sha256(path.read_bytes()).hexdigest()


def is_code(file: str | Path) -> bool:
    """Whether a file of the user's own is Python that runs, and no description that is read."""
    return Path(file).suffix.lower() == ".py"


def load_class(
    kind: CodeKind, name: str, relative_to: Path | None = None, files: Files = ()
) -> type:
    """Class `Gait`, `Robot` or `Balance` of the file that a name stands for.

    Args:
        kind: What it is.
        name: A name, or a file with its suffix.
        relative_to: Folder that a relative file starts from; the working directory by default.
        files: Further files that the code is made of, as far as known; others, other code.

    Raises:
        UnknownName: If there is no such file.
        FileError: If the file does not load or holds no dataclass of that name.
    """
    path = locate(kind, name, relative_to)
    if not is_code(path) and kind in READERS:
        cls: type = importlib.import_module(READERS[kind]).load_robot(path).cls
        return cls
    if is_shipped(kind, path):
        module = importlib.import_module(f"gaitlab.{IN_PACKAGE[kind]}.{path.stem}")
    else:
        module = user_code(path, files).module
    found = getattr(module, kind.capitalize(), None)
    if not (isinstance(found, type) and dataclasses.is_dataclass(found)):
        raise wrong_file(
            path,
            None,
            f"holds no dataclass called {kind.capitalize()}; a {kind} file defines "
            f"`@dataclass(frozen=True, kw_only=True) class {kind.capitalize()}`",
        )
    _require_members(kind, path, found)
    return found


def _require_members(kind: CodeKind, path: Path, cls: type) -> None:
    """Refuse a class that the simulation would trip over later."""
    try:
        fields = {name.partition(".")[0] for name in parameter_table(cls)}
    except (NameError, TypeError) as error:
        message = f"has a field whose type cannot be read: {error}; mend its annotation"
        raise wrong_file(path, None, message) from error
    fields |= {item.name for item in dataclasses.fields(cls)}
    fields |= {member for member, other in INSTEAD.items() if hasattr(cls, other)}
    lacking = [name for name in MEMBERS[kind] if name not in fields and not hasattr(cls, name)]
    if lacking:
        needs = f"a {kind} has {', '.join(MEMBERS[kind])}"
        raise wrong_file(path, None, f"the class lacks {', '.join(lacking)}; {needs}")


def user_code(path: Path, files: Files = ()) -> OwnCode:
    """A file of the user's own, loaded; the same text with the same files gives the same module.

    Raises:
        FileError: If it does not load.
    """
    known = _loaded.get((path, files))
    if known is None or not known.unchanged:
        known = OwnCode(path)
        try:
            known.execute()
        except (Exception, SystemExit) as error:
            raise blamed(path, "does not load", error) from error
        _loaded[path, files] = known
    return known


def forget_user_code() -> None:
    """Load files of the user's own anew when next asked for, so that what they read is seen."""
    for path, files in [key for key in _loaded if not key[1]]:
        del _loaded[path, files]


def blamed(path: Path, what: str, error: BaseException) -> FileError:
    """A mistake in a user's own Python file, at the innermost line of it that was running."""
    moved = MOVED.get(error.name or "") if isinstance(error, ImportError) else None
    hint = f"it is {moved} now; " if moved else ""
    message = f"{what}: {type(error).__name__}: {error}; {hint}mend the file and run again"
    return wrong_file(path, _line_of(path, error), message)


def _line_of(path: Path, error: BaseException) -> int | None:
    if isinstance(error, SyntaxError):
        return error.lineno
    frames = traceback.extract_tb(error.__traceback__)
    return next((f.lineno for f in reversed(frames) if f.filename == str(path)), None)


def wrong_file(path: Path, line: int | None, message: str) -> FileError:
    """A mistake in a user's own Python file."""
    return FileError([Problem(file=path, line=line, column=None, message=message)])
