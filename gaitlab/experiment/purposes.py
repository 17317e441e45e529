"""Whether a file is to be run as it stands or to be searched."""

from __future__ import annotations

from gaitlab.errors import UsageError
from gaitlab.experiment.experiment import Experiment
from gaitlab.experiment.study import Study


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
