"""A candidate of a study as an experiment of its own, whose trials are ordinary ones."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from gaitlab.documents import Node
from gaitlab.errors import FileError, WrongValue
from gaitlab.experiment.axes import Axis, refusals
from gaitlab.experiment.digest import digest
from gaitlab.experiment.experiment import Experiment
from gaitlab.experiment.parts import Parts, Value
from gaitlab.experiment.schema import ReportSettings

PROPOSED = Path("candidate")  # what the values of a candidate stand in, for a message


def candidate(experiment: Experiment, values: Mapping[str, Value]) -> Experiment:
    """The experiment with these values as all that is varied: one cell on every surface.

    Its trials are those that a grid of one cell would ask for, under the same ids. Parameters that
    a condition left out are left out of the values and keep the experiment's.

    Args:
        experiment: A study, or an experiment that varies nothing of the same path.
        values: Value by dotted path, in SI units.

    Raises:
        WrongValue: If a value lies outside its parameter's limits, or if robot, gait, ground or
            servos refuse the combination. Such a candidate cannot walk; nothing is wrong with the
            study.
    """
    parts = experiment.parts
    checked = {path: _checked(parts, path, value) for path, value in values.items()}
    axes = (Axis(paths=tuple(checked), rows=(tuple(checked.values()),)),) if checked else ()
    refused = [reason for _, reason in refusals(parts, axes)]
    if refused:
        raise WrongValue("; ".join(refused))
    report = ReportSettings(title=experiment.report.title)
    return replace(
        experiment,
        axes=axes,
        report=report,
        study=None,
        digest=digest({"": parts}, axes, experiment.seeds, report, None),
    )


def _checked(parts: Parts, path: str, value: Value) -> Value:
    try:
        return parts.check(path, Node(file=PROPOSED, value=value))
    except FileError as error:
        raise WrongValue("; ".join(problem.message for problem in error.problems)) from error
