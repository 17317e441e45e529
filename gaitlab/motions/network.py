"""Networks from ONNX files, run in onnxruntime: one input row, one output row, one thread."""

from __future__ import annotations

import os
from collections.abc import Mapping
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from gaitlab.errors import FileError, Problem, WrongValue

LARGEST = 200_000_000  # byte
EXTERNAL = b"\x0a\x08location\x12"  # the entry of a weight that says in which other file it is
FLOATS: dict[str, type[np.floating[Any]]] = {
    "tensor(float)": np.float32,
    "tensor(double)": np.float64,
}
FOREIGN_OPERATOR = ("not a registered function/op", "No Op registered for")


class Network:
    """One network, loaded.

    Attributes:
        inputs: Size of its input; None if the file leaves it open.
        outputs: Size of its output, likewise.
        metadata: What its exporter wrote beside the weights.
    """

    def __init__(self, path: Path, session: Any) -> None:
        self._session = session
        self._input, self.inputs, self._type = _row(path, "input", session.get_inputs())
        self._output, self.outputs, _ = _row(path, "output", session.get_outputs())
        self.metadata: Mapping[str, str] = session.get_modelmeta().custom_metadata_map

    def run(self, row: np.ndarray) -> np.ndarray:
        """What it gives for an input. Shapes (inputs,) to (outputs,)."""
        given = row.astype(self._type).reshape(1, -1)
        found: np.ndarray = self._session.run([self._output], {self._input: given})[0]
        return found.reshape(-1)


def read_network(path: Path) -> bytes:
    """What an ONNX file holds; all of it, so that its digest says what walks.

    Raises:
        FileError: If there is none, or its weights are elsewhere.
    """
    try:
        found = path.stat()
    except OSError as error:
        raise _wrong(path, "there is no such file; give a .onnx file") from error
    if path.suffix.lower() != ".onnx" or not path.is_file():
        raise _wrong(path, "is no policy; export it as a .onnx file")
    if found.st_size > LARGEST:
        raise _wrong(path, f"has {found.st_size} byte; at most {LARGEST} are read")
    raw = path.read_bytes()
    if EXTERNAL in raw:
        raise _wrong(
            path,
            "keeps weights in another file (external data); save it as one file: "
            "`onnx.save_model(onnx.load(...), ..., save_as_external_data=False)`",
        )
    return raw


def load_network(path: Path) -> Network:
    """The network of an ONNX file.

    Raises:
        FileError: If it is none that can be run.
        WrongValue: If onnxruntime is not installed.
    """
    found = path.stat() if path.is_file() else None
    changed = (0, 0) if found is None else (found.st_mtime_ns, found.st_size)
    return _loaded(path, os.getpid(), *changed)


@lru_cache(maxsize=16)
def _loaded(path: Path, process: int, *_: int) -> Network:
    """A process loads it for itself: what a session holds does not survive a fork for certain."""
    raw = read_network(path)
    if find_spec("onnxruntime") is None:
        raise WrongValue(
            f"{path.name} is run by onnxruntime, which is not installed: "
            "`pip install 'gaitlab[policy]'`"
        )
    import onnxruntime  # slow to load, and seldom needed

    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    options.log_severity_level = 4
    try:
        session = onnxruntime.InferenceSession(raw, options, providers=["CPUExecutionProvider"])
    except Exception as error:  # onnxruntime raises classes of its own, all of them plain
        said = str(error).strip().splitlines()[0][:300]
        if any(sign in said for sign in FOREIGN_OPERATOR):
            message = f"has a custom operator, which onnxruntime alone cannot run ({said})"
            raise _wrong(path, message) from error
        raise _wrong(path, f"is no network that onnxruntime can run ({said})") from error
    return Network(path, session)


def _row(path: Path, what: str, found: list[Any]) -> tuple[str, int | None, type[np.floating[Any]]]:
    """Name, size and type of the one input or output that there is to be."""
    if len(found) != 1:
        names = ", ".join(part.name for part in found)
        raise _wrong(
            path,
            f"has {len(found)} {what}s, {names}; a policy has one, and what it remembers is fed to "
            "it as history",
        )
    (part,) = found
    if part.type not in FLOATS:
        raise _wrong(path, f"its {what} {part.name} is {part.type}; floats are expected")
    sizes = [size for size in part.shape if isinstance(size, int) and size != 1]
    if len(sizes) > 1 or len(part.shape) > 2:
        shape = " x ".join(map(str, part.shape))
        raise _wrong(path, f"its {what} {part.name} has the shape {shape}; a row is expected")
    last = part.shape[-1] if part.shape else 1
    return part.name, last if isinstance(last, int) else None, FLOATS[part.type]


def _wrong(path: Path, message: str) -> FileError:
    return FileError([Problem(file=path, line=None, column=None, message=message)])
