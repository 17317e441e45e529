"""Walks what a program of the team's own writes, run once for every combination of its parameters.

    gait:
      type: program
      command: [./my_walk, --step, "{step_length}", --out, "{file}"]
      depends: [./walk.ini]
      period: 0.6
      parameters:
        step_length: {low: 0.0, high: 0.08, unit: m, default: 0.04}

Each `{name}` in the command becomes the number of a parameter, `{file}` the file to write: a
trajectory, see `gaitlab.motions.trajectory`. A parameter called like one of the gait's own, as
`step_length` here, is that one.
"""

from __future__ import annotations

import keyword
import re
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import MISSING, dataclass, fields, make_dataclass
from math import isfinite
from typing import Any, Literal

from gaitlab.documents import Node, build, plain
from gaitlab.errors import FileError
from gaitlab.model import Robot
from gaitlab.model.servo import Servo
from gaitlab.motions.joint_walk import JointWalk
from gaitlab.motions.program import FILE, Program, placeholders
from gaitlab.motions.trajectory import Trajectory, load_trajectory
from gaitlab.parameters import get_path, parameter
from gaitlab.plugins import suggestion

NAME = re.compile(r"[a-z][a-z0-9_]{0,59}")
OPTION = re.compile(r"[\w.+-]{1,60}")


@dataclass(frozen=True, kw_only=True)
class DeclaredParameter:
    """What the file says of a parameter of the program."""

    low: float = parameter(-1e9, unit="-", doc="smallest value")
    high: float = parameter(1e9, unit="-", doc="largest value")
    unit: str = parameter("-", unit="-", doc="SI unit, - for a ratio")
    default: Node | None = parameter(None, unit="-", doc="value if the experiment gives none")
    options: tuple[str, ...] = parameter((), unit="-", doc="words to choose from, for no number")
    doc: str = parameter("of the program", unit="-", doc="what it means")


@dataclass(frozen=True, kw_only=True)
class Gait(JointWalk):
    """A walk that a program writes; further parameters are those that the file declares for it."""

    command: tuple[str, ...] = parameter(
        unit="-", doc='program and arguments: [./my_walk, --out, "{file}"]'
    )
    depends: tuple[str, ...] = parameter(
        (), unit="-", doc="files that the program reads, by which its walks are told apart"
    )
    timeout: float = parameter(
        60.0, unit="s", low=0.1, high=86400.0, doc="after which a run of the program is ended"
    )
    form: Literal["csv", "npz", "parquet"] = parameter(
        "csv", unit="-", doc="of the file that it writes"
    )
    folder: str = parameter("", unit="-", doc="of the experiment's file; filled in")
    files: str = parameter(
        "", unit="-", doc="digest of the program's files; filled in", contents_of="folder"
    )

    def __post_init__(self) -> None:
        if not self.files:
            object.__setattr__(self, "files", self.program.digest)

    @classmethod
    def declared(cls, node: Node) -> tuple[type, Node]:
        """The gait with the parameters that a section declares, and the rest of the section.

        Raises:
            FileError: All that is wrong in `parameters` and with the command's `{names}`.
        """
        section = node.mapping.get("parameters")
        given = {} if section is None else section.mapping
        if section is not None and not given and section.value is not None:
            expected = "expected lines `step_length: {low: 0, high: 0.1, unit: m}`"
            raise FileError([section.problem(f"parameters: found {section.found()}; {expected}")])
        own = {item.name for item in fields(cls)} - {item.name for item in fields(JointWalk)}
        problems, made = [], []
        for name, one in given.items():
            key = section.keys[name] if section is not None else node
            if not NAME.fullmatch(name) or keyword.iskeyword(name) or name in {*own, FILE, "type"}:
                message = f"parameters: {name!r} is no name for one; small letters, digits and _"
                problems.append(key.problem(f"{message}, none of {', '.join(sorted(own))}"))
                continue
            try:
                made.append(_field(name, one))
            except FileError as error:
                problems += error.problems
        command = node.mapping.get("command")
        words = plain(command) if command is not None else None
        if command is not None and isinstance(words, tuple):
            known = {*given, *(item.name for item in fields(JointWalk)), FILE}
            used = placeholders(map(str, words))
            problems += [
                command.problem(f"command: {{{name}}} is no parameter{suggestion(name, known)}")
                for name in used
                if name not in known
            ]
            if FILE not in used:
                message = f"command: {{{FILE}}} is missing, the file that the program is to write"
                problems.append(command.problem(message))
            walked = {item.name for item in fields(JointWalk)}
            for name in given:
                if name not in used and name not in walked and section is not None:
                    message = f"parameters: {name} is not in the command; write {{{name}}} there"
                    problems.append(section.keys[name].problem(message))
        if problems:
            raise FileError(problems)
        folder = Node(file=node.file, value=str(node.folder))
        declared = make_dataclass("Gait", made, bases=(cls,), frozen=True, kw_only=True)
        declared.__doc__ = cls.__doc__
        return declared, node.without("parameters").replaced(folder=folder)

    @property
    def program(self) -> Program:
        """The program with the numbers of this gait."""
        used = sorted(placeholders(self.command) - {FILE})
        return Program(
            command=self.command,
            values={name: get_path(self, name) for name in used},
            depends=self.depends,
            folder=self.folder,
            timeout=self.timeout,
            suffix=f".{self.form}",
        )

    @property
    def told(self) -> str:
        """The program and what it is given."""
        return self.program.told

    @property
    def runs(self) -> str:
        """The command as it is written."""
        return shlex.join(self.command)

    @property
    def gait_period(self) -> float:
        """A whole cycle of two steps, in [s]; before the program has run, of one not known, 1."""
        return super().gait_period if self.program.output.is_file() else self.period or 1.0

    @property
    def trajectory(self) -> Trajectory:
        """What the program has written.

        Raises:
            FileError: If it has not run yet.
        """
        return load_trajectory(self.program.output, self.unit)

    def require_playable(self, robot: Robot, servos: Sequence[Servo]) -> None:
        """Refuse a robot that cannot be sent what the program has written, if it has.

        Raises:
            GaitlabError: What stands in the way.
        """
        if self.program.output.is_file():
            super().require_playable(robot, servos)

    def walked(self, *, run: bool) -> Mapping[str, Any] | None:
        """Parameters of the gait `trajectory` that walks what the program writes.

        Args:
            run: Whether the program may run for it.

        Returns:
            None if it has not run yet and may not.

        Raises:
            WrongValue: If it does not write a trajectory; says what it was given and what it said.
        """
        program = self.program
        if not program.output.is_file():
            if not run:
                return None
            program.run(lambda file: load_trajectory(file, self.unit))
        shared = {item.name: getattr(self, item.name) for item in fields(JointWalk)}
        return {**shared, "file": str(program.output)}


def _field(name: str, node: Node) -> tuple[str, Any, Any]:
    """A field of the gait's dataclass from its declaration."""
    if not node.mapping:
        expected = "expected {low: 0, high: 0.1, unit: m, default: 0.04} or {options: [a, b]}"
        raise FileError([node.problem(f"{name}: found {node.found()}; {expected}")])
    found = build(DeclaredParameter, node, skip=())
    given: Any = MISSING if found.default is None else plain(found.default)
    if found.options:
        wrong = [option for option in found.options if not OPTION.fullmatch(option)]
        if wrong or not (given is MISSING or given in found.options):
            said = f"{wrong[0]!r} is no word" if wrong else f"default {given!r} is no option"
            raise FileError([node.problem(f"{name}: {said}; options are words of letters")])
        hint: Any = Literal[found.options]
        return name, hint, parameter(given, unit="-", doc=found.doc)
    number = isinstance(given, int | float) and not isinstance(given, bool)
    if not (isfinite(found.low) and isfinite(found.high) and found.low < found.high):
        raise FileError([node.problem(f"{name}: low has to be below high")])
    if given is not MISSING and not (number and found.low <= given <= found.high):
        message = f"{name}: default is {given!r}; expected a number from low to high"
        raise FileError([node.problem(message)])
    value = given if given is MISSING else float(given)
    return (
        name,
        float,
        parameter(value, unit=found.unit, low=found.low, high=found.high, doc=found.doc),
    )
