"""`gaitlab` in a process of its own, forked from one that has loaded everything it needs.

A command is as it is for a user, but for the seconds in which Python loads libraries.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from multiprocessing import get_context
from pathlib import Path

from gaitlab.__main__ import main

_context = get_context("forkserver")
_context.set_forkserver_preload(
    ["gaitlab.cli", "gaitlab.running", "gaitlab.report.study.gathering", "gaitlab.regression",
     "gaitlab.report", "gaitlab.papers.reproduction", "gaitlab.store.tables", "gaitlab.render"]
)  # fmt: skip


def gaitlab(*words: str, folder: Path, timeout: float = 300.0) -> subprocess.CompletedProcess[str]:
    """A command run in a folder, with what it printed.

    Raises:
        subprocess.TimeoutExpired: If it has not ended in time, in [s]; it is killed.
    """
    with tempfile.TemporaryDirectory() as place:
        out, err = Path(place, "out"), Path(place, "err")
        process = _context.Process(target=_run, args=(words, folder, out, err))
        process.start()
        process.join(timeout)
        if process.exitcode is None:
            process.kill()
            raise subprocess.TimeoutExpired(list(words), timeout)
        printed = (file.read_text() if file.exists() else "" for file in (out, err))
        return subprocess.CompletedProcess(list(words), process.exitcode, *printed)


def _run(words: tuple[str, ...], folder: Path, out: Path, err: Path) -> None:
    for descriptor, file in ((1, out), (2, err)):
        os.dup2(os.open(file, os.O_WRONLY | os.O_CREAT), descriptor)
    os.chdir(folder)
    os.environ["COLUMNS"] = "200"
    sys.argv = ["gaitlab", *words]
    main()
