"""Whether a file is to be run as it stands, to be searched, or to be reproduced from others."""

from __future__ import annotations

from pathlib import Path

from gaitlab.documents import load
from gaitlab.errors import UsageError
from gaitlab.experiment.experiment import REPRODUCTION, Experiment
from gaitlab.experiment.study import Study
from gaitlab.plugins import locate


def is_reproduction(name_or_path: str | Path) -> bool:
    """Whether a file sets several experiments on one page, instead of being one.

    Raises:
        UnknownName: If there is no such file.
        FileError: If it is no YAML.
    """
    return REPRODUCTION in load(locate("experiment", str(name_or_path))).mapping


def study_of(experiment: Experiment) -> Study:
    """What an experiment file asks to search.

    Raises:
        UsageError: If it is no study.
    """
    if experiment.study is None:
        raise UsageError(
            f"{experiment.name} is an experiment and no study: it has nothing to search. Walk it "
            "with `gaitlab run` in place of `gaitlab optimize`, or write a section `study:` "
            "instead of what it varies; `gaitlab list experiments` says which files are studies"
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
