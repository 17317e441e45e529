"""What to type next: the commands that messages and pages suggest, right when they are pasted."""

from __future__ import annotations

import os
import shlex
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from gaitlab.errors import GaitlabError
from gaitlab.experiment import Experiment
from gaitlab.plugins import locate

STORE_VARIABLE = "GAITLAB_STORE"  # of the environment: the store where no --store is given
DEFAULT_STORE = Path("data")
SETTING = "# --set "  # begins a line of an experiment's text that notes an option


def command(verb: str, experiments: Sequence[Experiment], store: Path, *more: str) -> str:
    """The line that does something with experiments as they were asked for: file, options, store.

    Args:
        verb: Name of the command, `run` for instance.
        experiments: As they were loaded.
        store: Folder of the store.
        more: Further options; `--seeds` takes the place of a setting of seeds.
    """
    names = [called(experiment.path) for experiment in experiments]
    settings = dict.fromkeys(one for experiment in experiments for one in _settings(experiment))
    kept = [one for one in settings if not ("--seeds" in more and one.startswith("seeds="))]
    options = [word for setting in kept for word in ("--set", setting)]
    return shlex.join(["gaitlab", verb, *names, *options, *store_option(store), *more])


def called(path: Path) -> str:
    """What the command line calls an experiment: its name if that means the file, else the file."""
    with suppress(GaitlabError, OSError):
        if locate("experiment", path.stem).samefile(path):
            return path.stem
    with suppress(ValueError, OSError):
        relative = path.relative_to(Path.cwd())
        return str(relative) if not str(relative).startswith("-") else f"./{relative}"
    return str(path)


def store_option(store: Path) -> list[str]:
    """What a command needs to find the store; nothing for the usual one."""
    usual = store == DEFAULT_STORE and os.environ.get(STORE_VARIABLE, "") in ("", str(store))
    return [] if usual else ["--store", str(store)]


def _settings(experiment: Experiment) -> list[str]:
    """Options with which the file was read, as its text notes them at its head."""
    lines = experiment.text.splitlines()
    return [line.removeprefix(SETTING) for line in lines if line.startswith(SETTING)]
