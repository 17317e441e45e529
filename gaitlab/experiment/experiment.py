"""An experiment that was read and found right: the one thing that planning starts from.

A candidate of a study is an experiment of its own too, whose trials are ordinary ones.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import cast

from gaitlab.documents import Node
from gaitlab.errors import FileError, UsageError, WrongValue
from gaitlab.experiment.axes import Axis, refusals
from gaitlab.experiment.design import Design
from gaitlab.experiment.parts import Parts, Value
from gaitlab.experiment.schema import ReportSettings
from gaitlab.experiment.study import Study
from gaitlab.model.settings import LATE, SETTINGS, EngineName
from gaitlab.parameters import canonical_json, values
from gaitlab.plugins import label

ENGINE = "engine.name"  # the dotted path that chooses the engine
WALKER = "robot"  # what the walkers vary, as the values of a cell call it
LONGEST_NAME = 100  # characters of a folder of the store
LONGEST_FORM = 50  # characters that tell of options
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,99}")  # it becomes a folder of the store
PROPOSED = Path("candidate")  # what the values of a candidate stand in, for a message
USUAL = "foot_travel"  # reading of a file that names none, as digests have always called it
DRAWN = ("metrics", "maps", "label")  # keys of the report that no number depends on


@dataclass(frozen=True, kw_only=True)
class Experiment:
    """A validated experiment.

    Attributes:
        name: Name of its results.
        form: What the command line has made of the file, in letters that a folder may have; empty
            for the file as it stands. A form has its own list of trials and its own page.
        title: What is asked, one line; empty if the file does not say.
        description: A paragraph; empty if the file does not say.
        path: File it was read from.
        text: The file as read; with `include` or settings, the file that they amount to.
        digest: SHA-256 of everything it resolves to, names and comments apart. 64 hex digits.
        parts: Robot, gait, surfaces, servos and settings before anything is varied; with
            walkers, the first one's.
        walkers: The same of every walker by what it is called; empty unless the file lists them.
        axes: What is varied; axes multiply.
        seeds: Seeds of the replicates of every cell.
        report: How the results are laid out.
        study: What is searched for; None for an experiment that only varies.
        design: The box that its first axis fills with points; None if the file has none.
    """

    name: str
    title: str
    description: str
    path: Path
    text: str
    digest: str
    parts: Parts
    walkers: Mapping[str, Parts]
    axes: tuple[Axis, ...]
    seeds: Sequence[int]
    report: ReportSettings
    study: Study | None = None
    design: Design | None = None
    form: str = ""

    @property
    def listed_as(self) -> str:
        """What its list of trials and its page are called: its name, and its form if it has one."""
        return in_form(self.name, self.form)

    def parts_of(self, values: Mapping[str, Value]) -> Parts:
        """Parts that a cell of these values starts from."""
        return self.walkers[str(values[WALKER])] if self.walkers else self.parts

    @property
    def engines(self) -> set[EngineName]:
        """Every engine that its trials ask for."""
        walkers = self.walkers.values() or [self.parts]
        varied = {
            row[axis.paths.index(ENGINE)]
            for axis in self.axes
            for row in axis.rows
            if ENGINE in axis.paths
        }
        return cast("set[EngineName]", varied) or {parts.engine.name for parts in walkers}

    @property
    def varied(self) -> tuple[str, ...]:
        """Every varied dotted path, in the order of the axes."""
        return tuple(path for axis in self.axes for path in axis.paths)


def form_of(options: Sequence[str]) -> str:
    """What tells the form of a file apart that options of the command line make of it.

    `seeds=5` is `seeds-5`; where other letters are lost, or too many, a digest follows.
    """
    shown = [re.sub(r"[^A-Za-z0-9_.]+", "-", option).strip("-.") for option in options]
    whole, lossless = "+".join(shown), all(re.fullmatch(r"[\w.]+=[\w.]+", o) for o in options)
    if lossless and len(whole) <= LONGEST_FORM:
        return whole
    digest = hashlib.sha256("\n".join(options).encode()).hexdigest()[:8]
    return f"{whole[:LONGEST_FORM].rstrip('+-.')}+{digest}"


def in_form(name: str, form: str) -> str:
    """Name of a form's list and page, as long as a folder of the store may be."""
    room = LONGEST_NAME - len(form) - 1
    return f"{name[:room]}+{form}" if form else name


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
            "`gaitlab optimize` in place of `gaitlab run`, with --storage or --dask on several "
            "machines; its `--export best.yaml` writes an experiment that `gaitlab run` walks"
        )


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


def digest(
    walkers: Mapping[str, Parts],
    axes: Sequence[Axis],
    seeds: Sequence[int],
    report: ReportSettings,
    study: Study | None,
) -> str:
    """SHA-256 of everything that an experiment resolves to. 64 hex digits."""
    parts, *others = walkers.values()
    layout = values(replace(report, title="", distance_reading=report.distance_reading or USUAL))
    content = {
        **_walker_content(parts),
        "surfaces": [[name, s.type, values(s)] for name, s in parts.surfaces.items()],
        "settings": _settings(parts),
        "axes": [[axis.paths, axis.rows] for axis in axes],
        "seeds": len(seeds) if isinstance(seeds, range) else seeds,
        "report": {key: value for key, value in layout.items() if key not in DRAWN},
        **({"walkers": [_other_content(other) for other in others]} if others else {}),
        **({} if study is None else {"study": _study_content(study)}),
    }
    return hashlib.sha256(canonical_json(content).encode()).hexdigest()


def _settings(parts: Parts) -> list[object]:
    given = {name: values(getattr(parts, name)) for name in SETTINGS}
    return [found for name, found in given.items() if name not in LATE] + [
        {name: given[name]} for name in LATE if given[name]
    ]


def _study_content(study: Study) -> dict[str, object]:
    asked = asdict(study)
    if study.confirm is None:  # came when studies had digests already
        del asked["confirm"]
    return asked


def _walker_content(parts: Parts) -> dict[str, object]:
    return {
        "robot": [parts.robot_code.identity, values(parts.robot)],
        "gait": [parts.gait_code.identity, values(parts.gait)],
        "servos": [values(servo) for servo in parts.servos({})],
        **_balance_content(parts),
        **_metrics_content(parts),
    }


def _metrics_content(parts: Parts) -> dict[str, object]:
    codes = parts.metric_codes
    return {"metrics": {label(code.name): code.identity for code in codes}} if codes else {}


def _balance_content(parts: Parts) -> dict[str, object]:
    if parts.balance is None or parts.balance_code is None:
        return {}
    return {"balance": [parts.balance_code.identity, values(parts.balance)]}


def _other_content(parts: Parts) -> dict[str, object]:
    return {**_walker_content(parts), "engine": values(parts.engine)}
