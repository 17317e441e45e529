"""Whether a file is to be run as it stands, to be searched, or to be reproduced from others."""

from __future__ import annotations

import re
from pathlib import Path

from gaitlab.documents import load
from gaitlab.errors import UsageError
from gaitlab.experiment.experiment import REPRODUCTION, Experiment
from gaitlab.experiment.reading import DEEPEST_INCLUDE
from gaitlab.experiment.study import Study
from gaitlab.plugins import locate, names

STUDY = re.compile(r"^study\s*:", re.MULTILINE)
INCLUDE = re.compile(r"""^include\s*:\s*["']?([^\s"'#]+)""", re.MULTILINE)


def is_reproduction(name_or_path: str | Path) -> bool:
    """Whether a file sets several experiments on one page, instead of being one.

    Raises:
        UnknownName: If there is no such file.
        FileError: If it is no YAML.
    """
    return REPRODUCTION in load(locate("experiment", str(name_or_path))).mapping


def studies() -> list[str]:
    """Names of the experiments that are to be searched, sorted; told by the texts of the files."""
    return [name for name in names("experiment") if _is_study(locate("experiment", name))]


def _is_study(path: Path) -> bool:
    """Whether a file has a section `study:`, itself or from the files that it includes."""
    for _ in range(DEEPEST_INCLUDE):
        if not path.is_file():
            return False
        text = path.read_text(encoding="utf-8", errors="replace")
        include = INCLUDE.search(text)
        if STUDY.search(text) or include is None:
            return bool(STUDY.search(text))
        path = path.parent / include[1]
    return False


def study_of(experiment: Experiment) -> Study:
    """What an experiment file asks to search.

    Raises:
        UsageError: If it is no study.
    """
    if experiment.study is None:
        raise UsageError(
            f"{experiment.name} is an experiment and no study: it has nothing to search. Walk it "
            "with `gaitlab run` in place of `gaitlab optimize`, or write a section `study:` "
            "instead of what it varies; `gaitlab list studies` names some"
        )
    return experiment.study


def refuse_study(experiment: Experiment) -> None:
    """Refuse a study where all trials have to be known beforehand.

    Raises:
        UsageError: If the experiment is a study.
    """
    if experiment.study is not None:
        raise UsageError(
            f"{experiment.name} is a study: its parameters are searched, not varied. Search with "
            "`gaitlab optimize` in place of `gaitlab run`; its `--export best.yaml` writes an "
            "experiment that `gaitlab run` walks"
        )
