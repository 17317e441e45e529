"""A program of a team's own that writes a trajectory: run once, its walk kept and never half.

What it writes is kept in `.gaitlab/programs` beside the file that names it, called by the command,
the numbers and the files that the program is made of. It runs in a scratch folder there, which is
also where its temporary files go, and is gone afterwards. A program may write where it likes; what
is noticed is a change of its own files, and a new file beside the experiment.
"""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import signal
import subprocess
import tempfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from gaitlab.documents.outputs import sync
from gaitlab.documents.printable import visible
from gaitlab.errors import FileError, WrongValue
from gaitlab.parameters import canonical_json
from gaitlab.plugins import is_file_name
from gaitlab.plugins.own_code import digest_of

FILE = "file"  # in braces in a command: what the program is to write
PLACE = re.compile(r"\{(\w+)\}")
KEPT = Path(".gaitlab", "programs")
SHOWN_LINES = 8  # of what a program said last
SHOWN_BYTES = 4000
KEY_LENGTH = 32  # hex digits

Number = bool | int | float | str


def placeholders(words: Iterable[str]) -> set[str]:
    """Names in braces in a command."""
    return {name for word in words for name in PLACE.findall(word)}


@dataclass(frozen=True, kw_only=True)
class Program:
    """A program and what it is given.

    Attributes:
        command: Program and arguments, names in braces.
        values: What the names stand for, but for the file to write.
        depends: Further files that it is made of.
        folder: Folder that relative files start from.
        timeout: After which it is ended, in [s].
        suffix: Of the file that it writes.
    """

    command: Sequence[str]
    values: Mapping[str, Number]
    depends: Sequence[str]
    folder: str
    timeout: float
    suffix: str

    @property
    def files(self) -> dict[str, Path]:
        """Files that it is made of, by what the experiment calls them.

        Raises:
            WrongValue: If one of `depends`, or the program itself, is not there.
        """
        if not self.command:
            raise WrongValue('command: an empty list; expected [./my_walk, --out, "{file}"]')
        first, *others = self.command
        found = {word: self._at(word) for word in others if self._at(word).is_file()}
        if is_file_name(first):
            if not os.access(self._at(first), os.X_OK) or not self._at(first).is_file():
                raise WrongValue(f"command: {self._at(first)} is no file that can be run")
            found[first] = self._at(first)
        elif shutil.which(first) is None:
            raise WrongValue(f"command: there is no program {first!r}; one beside is ./{first}")
        for name in self.depends:
            if not self._at(name).is_file():
                raise WrongValue(f"depends: there is no file {self._at(name)}")
            found[name] = self._at(name)
        return found

    @property
    def digest(self) -> str:
        """SHA-256 of its files. 64 hex digits.

        Raises:
            WrongValue: If one is not there.
        """
        held = {name: _digest(path) for name, path in self.files.items()}
        return hashlib.sha256(canonical_json(held).encode()).hexdigest()

    @property
    def output(self) -> Path:
        """Where its trajectory is kept."""
        asked = [list(self.command), dict(self.values), self.digest]
        key = hashlib.sha256(canonical_json(asked).encode()).hexdigest()[:KEY_LENGTH]
        return Path(self.folder).absolute() / KEPT / f"{key}{self.suffix}"

    def run(self, check: Callable[[Path], object]) -> None:
        """Run it, and keep what it writes if that is right.

        Args:
            check: Is given the file, and raises FileError if it is wrong.

        Raises:
            WrongValue: If it ends with an error, takes too long, writes nothing or something
                wrong, or writes where it should not.
        """
        output, files = self.output, self.files
        before, beside = self.digest, self._beside()
        with self._scratch(output.parent) as folder:
            file = Path(folder) / f"walk{self.suffix}"
            given = {**self.values, FILE: str(file)}
            words = [PLACE.sub(lambda name: _text(given[name[1]]), word) for word in self.command]
            words = [str(files.get(old, new)) for old, new in zip(self.command, words, strict=True)]
            said = self._ended(words, Path(folder))
            if not file.is_file() or file.stat().st_size == 0:
                raise self._wrong(f"wrote nothing to {{{FILE}}}", said)
            try:
                check(file)
            except FileError as error:
                what = "; ".join(problem.message for problem in error.problems)
                raise self._wrong(f"wrote no trajectory: {what}", said) from error
            if self.digest != before:
                raise self._wrong("changed its own files while it ran", said)
            new = sorted(self._beside() - beside)
            if new:
                raise self._wrong(f"wrote outside its folder: {', '.join(new)}", said)
            sync(file)
            os.replace(file, output)

    def _scratch(self, kept: Path) -> tempfile.TemporaryDirectory[str]:
        """A folder for one run, on the disk on which the result is kept."""
        try:
            kept.mkdir(parents=True, exist_ok=True)
            return tempfile.TemporaryDirectory(prefix=".run-", dir=kept, ignore_cleanup_errors=True)
        except OSError as error:
            raise WrongValue(
                f"{kept}: walks of programs are kept there, and it cannot be written "
                f"({error.strerror}); copy the experiment to a folder of your own"
            ) from error

    def _ended(self, words: Sequence[str], folder: Path) -> str:
        """Let it run to its end; what it said last.

        Raises:
            WrongValue: If it cannot be started, ends with an error or takes too long.
        """
        log = folder / ".said"
        with log.open("wb") as said:
            try:
                started = subprocess.Popen(
                    words,
                    cwd=folder,
                    env={**os.environ, "TMPDIR": str(folder)},
                    stdin=subprocess.DEVNULL,
                    stdout=said,
                    stderr=subprocess.STDOUT,
                    start_new_session=True,
                )
            except OSError as error:
                raise self._wrong(f"cannot be started ({error.strerror})", "") from error
            try:
                code = started.wait(self.timeout)
            except subprocess.TimeoutExpired as error:
                took = f"had not ended after {self.timeout:g} s; `timeout:` gives it longer"
                raise self._wrong(took, _last(log)) from error
            finally:
                with suppress(OSError):  # with all that it has started
                    os.killpg(started.pid, signal.SIGKILL)
                started.wait()
        if code != 0:
            how = f"with exit status {code}" if code > 0 else f"by signal {-code}"
            raise self._wrong(f"ended {how}", _last(log))
        return _last(log)

    @property
    def told(self) -> str:
        """What it is and what it is given, for a message."""
        given = ", ".join(f"{name} = {_text(value)}" for name, value in self.values.items())
        return f"the program {self.command[0]}{f' for {given}' if given else ''}"

    def _wrong(self, what: str, said: str) -> WrongValue:
        tail = f"; it said last:\n{said}" if said else "; it said nothing"
        return WrongValue(f"{self.told} {what}{tail}")

    def _beside(self) -> set[str]:
        """Names of the files beside the experiment."""
        with os.scandir(self.folder or ".") as entries:
            return {entry.name for entry in entries if entry.is_file(follow_symlinks=False)}

    def _at(self, name: str) -> Path:
        return Path(os.path.abspath(Path(self.folder) / os.path.expanduser(name)))


def _digest(path: Path) -> str:
    status = path.stat()
    return _digest_then(path, status.st_mtime_ns, status.st_size)


@lru_cache(maxsize=1024)
def _digest_then(path: Path, *_: int) -> str:
    """Of a file that has not changed since; engines may be large, and are asked for often."""
    return digest_of(path)


def _text(value: Number) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return value if isinstance(value, str) else repr(value)


def _last(log: Path) -> str:
    """The last lines of what a program said."""
    with log.open("rb") as said:
        said.seek(max(0, log.stat().st_size - SHOWN_BYTES))
        text = said.read().decode(errors="replace")
    return "\n".join(f"  {visible(line)[:300]}" for line in text.splitlines()[-SHOWN_LINES:])
