"""Robot, gait, grounds and servos that an experiment starts from, and how a path changes them."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal, TypeVar, cast
from warnings import catch_warnings, simplefilter

import numpy as np

from gaitlab.documents import Node, check, checked
from gaitlab.errors import WrongValue
from gaitlab.model import Robot
from gaitlab.model.balance import Balance, require_joints
from gaitlab.model.commands import feet_of, joint_commands, require_playable
from gaitlab.model.gait import Gait, require_walk
from gaitlab.model.imu import Attitude
from gaitlab.model.servo import Servo
from gaitlab.model.settings import SETTINGS, EngineSettings, Horizon, Push, Slope, Spread
from gaitlab.parameters import Parameter, get_path, parameter_table
from gaitlab.plugins import is_file_name, label, locate, names, nearest, suggestion
from gaitlab.servos.files import load_servo
from gaitlab.simulation.trial import Plugin, require_in_time
from gaitlab.surfaces import Surface

T = TypeVar("T")
Value = bool | int | float | str
GROUPS = ("gait", "balance", "surface", "servo", "robot", *SETTINGS)
ELSEWHERE = {  # what is varied in another way
    "surface": "list the grounds under `surfaces:`",
    "surfaces": "list the grounds under `surfaces:`",
    "surface.type": "list grounds of each type under `surfaces:`",
    "seed": "give `seeds:` a number or a list",
    "seeds": "give `seeds:` a number or a list",
    "gait.type": "write an experiment for each gait and give `gaitlab report` both",
    "robot.type": "write an experiment for each robot and give `gaitlab report` both",
}
SERVO_TYPE = Parameter(
    name="type",
    type=str,
    default="",
    unit="-",
    low=None,
    high=None,
    doc="name of a servo for every joint; the robot's own by default",
    source="",
)


REHEARSED = 50  # instants of a walk at which one's own code is watched
NO_BALANCE = "none"  # a balance controller that there is not


@dataclass(frozen=True, kw_only=True)
class Parts:
    """What a trial is made of, before anything is varied.

    Attributes:
        robot: The robot.
        robot_code: Its code.
        gait: The gait.
        gait_code: Its code.
        surfaces: Grounds by what the experiment calls them, in the order of the file.
        servo: Settings for every servo, by parameter; `type` replaces the robot's own choice.
        engine: How the engine integrates.
        horizon: When a trial ends.
        spread: How much replicates differ.
        slope: How the ground is tilted.
        push: What pushes the robot.
        balance: The balance controller; None without one.
        balance_code: Its code.
        metric_codes: Code of the user's own metrics.
    """

    robot: Robot
    robot_code: Plugin
    gait: Gait
    gait_code: Plugin
    surfaces: Mapping[str, Surface]
    servo: Mapping[str, Value]
    engine: EngineSettings
    horizon: Horizon
    spread: Spread
    slope: Slope = field(default_factory=Slope)
    push: Push = field(default_factory=Push)
    balance: Balance | None = None
    balance_code: Plugin | None = None
    metric_codes: tuple[Plugin, ...] = ()

    @property
    def codes(self) -> tuple[Plugin, ...]:
        """Code of everything that is code."""
        balance = () if self.balance_code is None else (self.balance_code,)
        return (self.robot_code, self.gait_code, *balance, *self.metric_codes)

    @property
    def balance_name(self) -> str:
        """What the balance controller is called; `none` without one."""
        return label(self.balance_code.name) if self.balance_code else NO_BALANCE

    def parameter(self, path: str, *, everywhere: bool = False) -> Parameter:
        """What is known of a dotted path.

        Args:
            path: The path.
            everywhere: Whether every ground has to have it, if it is one of grounds. Where one
                lacks it, varying it would walk the same trials again and again there.

        Raises:
            WrongValue: If there is no such path; names the nearest, and a surface that lacks it.
        """
        group, _, rest = path.partition(".")
        if path in ELSEWHERE:
            raise WrongValue(f"{path!r} cannot be varied here; {ELSEWHERE[path]}")
        if group not in GROUPS or not rest:
            starts = ", ".join(f"{name}." for name in GROUPS)
            raise WrongValue(
                f"{path!r} is no dotted path; it starts with one of: {starts}"
                f"{nearest(path, self._paths())}"
            )
        if group == "balance" and self.balance is None:
            shown = " or ".join(f"`balance: {name}`" for name in names("balance"))
            raise WrongValue(f"{path!r}: there is no balance controller; add a line {shown}")
        if group == "surface":
            return self._of_surfaces(path, rest, everywhere)
        table = self._table(group)
        if rest not in table:
            known = [f"{group}.{name}" for name in table]
            raise WrongValue(f"{path!r} is no parameter{suggestion(path, known)}")
        return table[rest]

    def _paths(self) -> list[str]:
        tables = {name: self._table(name) for name in GROUPS if name != "surface"}
        return [f"{group}.{name}" for group, table in tables.items() for name in table]

    def _table(self, group: str) -> Mapping[str, Parameter]:
        if group == "servo":
            return {"type": SERVO_TYPE, **parameter_table(Servo)}
        if group == "balance":
            return {} if self.balance is None else self._balance_table()
        return parameter_table(type(getattr(self, group)))

    def _balance_table(self) -> Mapping[str, Parameter]:
        """Gains, and the switch under `type`: the controller of the file or none."""
        switch = dataclasses.replace(
            SERVO_TYPE,
            type=Literal[NO_BALANCE, self.balance_name],
            doc="the balance controller, or none",
        )
        return {"type": switch, **parameter_table(type(self.balance))}

    def _of_surfaces(self, path: str, rest: str, everywhere: bool) -> Parameter:
        tables = [parameter_table(type(surface)) for surface in self.surfaces.values()]
        found = [table[rest] for table in tables if rest in table]
        for (name, surface), table in zip(self.surfaces.items(), tables, strict=True):
            if rest not in table and (everywhere or not found):
                known = [f"surface.{key}" for key in table]
                raise WrongValue(
                    f"{path!r} is no parameter of {name}, a surface of type {surface.type!r}"
                    f"{suggestion(path, known)}"
                )
        return found[0]

    def check(self, path: str, node: Node) -> Value:
        """Value of a dotted path from a node.

        Raises:
            FileError: If it has the wrong type or lies outside the range.
        """
        item = dataclasses.replace(self.parameter(path), name=path)
        value: Value = check(item, placed(node) if item.unit == "file" else node)
        return servo_type(node, str(value)) if path == "servo.type" else value

    def try_out(self, group: str, changes: Mapping[str, Value]) -> None:
        """Make the part that changes of full dotted paths ask for, and forget it.

        Raises:
            WrongValue, ValueError: If the part itself refuses the combination.
        """
        inner = changes_of(group, changes)
        if group == "balance":
            self.balanced(inner)
        elif group == "servo":
            self.servos(inner)
        elif group == "surface":
            for surface in self.surfaces.values():
                changed(surface, owned(surface, inner))
        else:
            made = changed(getattr(self, group), inner)
            try_out(group, made)
            if group == "gait":
                require_playable(made, self.robot, self.servos({}))
            elif group == "push":
                require_in_time(made, self.gait, self.horizon)

    def rehearse(self, changes: Mapping[str, Value]) -> None:
        """Let code of the user's own make a few targets of a walk, so that what it reads is seen.

        What goes wrong is left to the trial.
        """
        by_group = {group: changes_of(group, changes) for group in ("robot", "gait", "balance")}
        if changes and not any(by_group.values()):
            return
        with suppress(Exception, SystemExit), catch_warnings(), np.errstate(all="ignore"):
            simplefilter("ignore")
            made = self.varied(changes)
            end = made.gait.startup_time + made.walking_time
            feet = feet_of(made.gait, made.robot, np.linspace(0.0, end, REHEARSED))
            joint_commands(made.robot, feet)
            balance = self.balanced(by_group["balance"], made.robot)
            if balance is not None:
                upright = Attitude(pitch=0.0, roll=0.0, pitch_rate=0.0, roll_rate=0.0)
                balance.controller(feet, self.engine.dt).correction(0, upright)

    def varied(self, changes: Mapping[str, Value]) -> Parts:
        """The same with what changes of full dotted paths make of robot, gait and horizon.

        Raises:
            WrongValue, ValueError: If a part itself refuses the combination.
        """
        groups = ("robot", "gait", "horizon")
        made = {g: changed(getattr(self, g), changes_of(g, changes)) for g in groups}
        return dataclasses.replace(self, **made)

    @property
    def walking_time(self) -> float:
        """Longest time that is walked after the start-up, in [s]."""
        return min(self.horizon.cycles * self.gait.gait_period, self.horizon.time)

    def base_values(self, path: str) -> list[Value]:
        """Values of a dotted path before it is varied; several if surfaces or servos differ."""
        group, _, rest = path.partition(".")
        if path == "servo.type":
            found = [
                self.servo.get("type", joint.servo)
                for joint in self.robot.tree.joints
                if joint.servo
            ]
        elif path == "balance.type":
            found = [self.balance_name]
        elif group == "servo":
            found = [get_path(servo, rest) for servo in self.servos({})]
        elif group == "surface":
            found = [
                get_path(surface, rest)
                for surface in self.surfaces.values()
                if rest in parameter_table(type(surface))
            ]
        else:
            found = [get_path(getattr(self, group), rest)]
        return list(dict.fromkeys(found))

    def balanced(self, changes: Mapping[str, Value], robot: Robot | None = None) -> Balance | None:
        """The balance controller with gains changed; None when there is none or it is off.

        Raises:
            WrongValue: If the robot lacks a joint to balance with.
        """
        gains = {path: value for path, value in changes.items() if path != "type"}
        if self.balance is None or changes.get("type") == NO_BALANCE:
            return None
        made = changed(self.balance, gains)
        require_joints(made, robot or self.robot)
        return made

    def servos(self, changes: Mapping[str, Value], robot: Robot | None = None) -> tuple[Servo, ...]:
        """One servo a driven joint in the order of the tree, with all settings applied."""
        settings = {**self.servo, **changes}
        chosen = settings.pop("type", None)
        joints = (robot or self.robot).tree.joints
        wanted = [str(chosen or joint.servo) for joint in joints if joint.servo is not None]
        ready = {name: self._servo(name, settings) for name in dict.fromkeys(wanted)}
        return tuple(ready[name] for name in wanted)

    def _servo(self, name: str, settings: Mapping[str, Value]) -> Servo:
        own: Mapping[str, Servo] = getattr(self.robot, "own_servos", {})
        found = own.get(name) or load_servo(name, Path(self.robot_code.name).parent)
        return changed(found, settings)


def changes_of(group: str, changes: Mapping[str, Value]) -> dict[str, Value]:
    """Those of the changes that concern a part, by the path inside it."""
    start = f"{group}."
    return {p.removeprefix(start): value for p, value in changes.items() if p.startswith(start)}


def try_out(group: str, made: Any) -> None:
    """Ask a robot or gait for what planning needs of it.

    Raises:
        WrongValue: If a gait's lengths and durations make no walk.
    """
    if group == "gait":
        require_walk(made)
    elif group == "robot":
        _ = made.tree.joints, made.sole, made.hip_offset()


def owned(surface: Surface, changes: Mapping[str, Value]) -> dict[str, Value]:
    """Those of the changes to all grounds that this one has a parameter for."""
    table = parameter_table(type(surface))
    return {path: value for path, value in changes.items() if path in table}


def changed(owner: T, changes: Mapping[str, Value]) -> T:
    """Copy of a nested frozen dataclass with several dotted paths set at once."""
    groups: dict[str, Any] = {}
    for path, value in changes.items():
        head, _, rest = path.partition(".")
        if rest:
            groups.setdefault(head, {})[rest] = value
        else:
            groups[head] = value
    fresh = {
        head: changed(getattr(owner, head), value) if isinstance(value, dict) else value
        for head, value in groups.items()
    }
    for item in parameter_table(type(owner)).values():
        if not fresh.keys().isdisjoint(item.contents_of):
            fresh[item.name] = item.default
    return cast(T, dataclasses.replace(cast(Any, owner), **fresh))


def placed(node: Node) -> Node:
    """A file that a parameter names, found from the file that names it; a name stays as it is."""
    if not isinstance(node.value, str) or not is_file_name(node.value):
        return node
    return replace(node, value=str(node.folder / node.value))


def servo_type(node: Node, name: str) -> str:
    """A servo's name, or the absolute file of a user's own, once it has been read.

    Raises:
        FileError: If there is none or it is wrong.
    """
    checked(node, lambda: load_servo(name, node.folder))
    return str(locate("servo", name, node.folder)) if is_file_name(name) else name
