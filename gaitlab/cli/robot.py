"""`gaitlab robot`: what was found in a URDF, and the files to go on with."""

from __future__ import annotations

import json
import os
import shlex
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from math import degrees
from pathlib import Path
from shutil import get_terminal_size
from textwrap import fill
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gaitlab.cli.options import written_to
from gaitlab.cli.printing import other_output_on_stderr, plural, say
from gaitlab.errors import UsageError

if TYPE_CHECKING:
    from gaitlab.documents import Node
    from gaitlab.model.foreign.findings import RobotFindings, ServoFindings
    from gaitlab.model.foreign.robot import ForeignRobot
    from gaitlab.model.foreign.robot_file import Loaded
    from gaitlab.model.gait import Gait
    from gaitlab.model.servo import Servo

PICTURE, ROBOT_FILE, EXPERIMENT = "stand.png", "my_robot.yaml", "my_first_walk.yaml"
LABEL = 8  # characters of a line's label
WIDTH = 100  # characters of a line that goes to no terminal
APART = 1e-3  # m by which the ankle axis and the drawn joint differ before both are told
NARROWEST = 40  # characters of a line in the narrowest terminal
LEVEL = 0.05  # degrees; less is none
ROUGHLY = " (slanted)"  # of an axis
ROLES = {"Y": "yaw", "R": "roll", "P": "pitch"}


def robot(
    file: Annotated[
        str, typer.Argument(metavar="FILE", help="A .urdf, a .xacro or a robot file (.yaml).")
    ],
    settings: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="PATH=VALUE",
            help="A line of the robot file, sole.length=0.15 for instance; may be repeated.",
        ),
    ] = None,
    output: Annotated[
        Path,
        typer.Option("--output", metavar="DIR", parser=written_to, help="Folder of its files."),
    ] = Path("."),
    as_json: Annotated[
        bool, typer.Option("--json", help="Print one JSON object, in m, rad, s, kg and N m.")
    ] = False,
    force: Annotated[
        bool, typer.Option("--force", help="Also replace files that are there and differ.")
    ] = False,
) -> int:
    """Tell the legs, soles, stance, reach and servos of a URDF, and draft the files to go on with.

    \b
    Example:
      gaitlab robot my.urdf
    """
    from gaitlab.experiment.reading import apply_setting
    from gaitlab.model.foreign.findings import findings_of
    from gaitlab.model.foreign.robot_file import is_urdf, node_of, robot_of
    from gaitlab.plugins import is_code, locate

    path = locate("robot", file)
    if is_code(path):
        raise UsageError(
            f"{file} is Python and no URDF; `gaitlab show {file}` tells its parameters"
        )
    said = node_of(path)
    for setting in settings or ():
        said = apply_setting(said, setting)
    with other_output_on_stderr():
        loaded = robot_of(path, said)
        found = findings_of(loaded, _servos(loaded), _default_walk)
        files = _write(path, said, loaded, found, output, force)
    if as_json:
        say(json.dumps({**_object(found), "files": {str(f): how for f, how in files.items()}}))
        return 0
    say("\n".join([_head(found), *_lines(found), *_files_lines(files)]))
    if settings and not is_urdf(path):
        say(_line("tried", f"{', '.join(settings)}: only here; {file} is as it was"))
    return 0


def _servos(loaded: Loaded) -> list[Servo]:
    """The servo of each joint."""
    from gaitlab.servos.files import load_servo

    made = loaded.cls()
    names = [str(joint.servo) for joint in made.tree.joints]
    return [made.own_servos.get(name) or load_servo(name) for name in names]


def _default_walk(made: ForeignRobot) -> Gait:
    """The walk that comes of a robot's size."""
    from gaitlab.gaits import walk

    values: dict[str, Any] = walk.Gait.suited_to(made)
    return walk.Gait(**values)


def _object(value: Any) -> Any:
    """RobotFindings as JSON has them, by the names of their attributes."""
    if is_dataclass(value):
        return {item.name: _object(getattr(value, item.name)) for item in fields(value)}
    if hasattr(value, "_asdict"):
        value = value._asdict()
    if isinstance(value, Mapping):
        return {key: _object(each) for key, each in value.items()}
    return [_object(each) for each in value] if isinstance(value, tuple) else value


def _write(
    path: Path, said: Node, loaded: Loaded, found: RobotFindings, folder: Path, force: bool
) -> dict[Path, str]:
    """Write the picture and the drafts; a draft that is there and differs is kept.

    Returns:
        Whether each is `written` or `kept`.

    Raises:
        UsageError: If a picture is there that gaitlab did not write, or the folder is none.
        StoreError: If one cannot be written.
    """
    import numpy as np

    from gaitlab.documents.outputs import write_text
    from gaitlab.experiment.json_schema import put_beside
    from gaitlab.model.foreign.draft import experiment_draft, robot_draft
    from gaitlab.model.foreign.robot_file import is_urdf
    from gaitlab.render.standing import draw_standing

    if folder.exists() and not folder.is_dir():
        raise UsageError(f"--output {folder}: this is no folder; give one")
    own, texts = path, {}
    if is_urdf(path):
        own = folder / ROBOT_FILE
        texts[own] = robot_draft(own, loaded, found, said)
    first = folder / EXPERIMENT
    texts[first] = experiment_draft(first, own, found)
    draw_standing(
        loaded.cls(),
        np.array(list(found.stance.joints.values())),
        folder / PICTURE,
        hip_height=found.stance.hip_height,
        title=f"{found.name}, {found.mass:.2f} kg",
        force=force,
    )
    kinds = {own: "robot", first: "experiment"}
    texts = {file: f"{put_beside(kinds[file], file)}\n{text}" for file, text in texts.items()}
    files = {folder / PICTURE: "written"}
    for file, text in texts.items():
        files[file] = "kept" if not force and _differs(file, text) else "written"
        if files[file] == "written":
            write_text(file, text)
    return files


def _differs(file: Path, text: str) -> bool:
    """Whether something else is there already."""
    try:
        return os.path.lexists(file) and file.read_bytes() != text.encode()
    except OSError:
        return True


def _line(label: str, text: str, *, label_width: int = LABEL) -> str:
    """A label and a text, on as many lines as it needs."""
    width = get_terminal_size((WIDTH, 24)).columns
    text = text.replace(" %", "\N{NO-BREAK SPACE}%")
    whole = fill(
        f"{label.ljust(label_width)}{text}",
        max(width, NARROWEST),
        subsequent_indent=" " * LABEL,
        break_long_words=False,
        break_on_hyphens=False,
    )
    return whole.replace("\N{NO-BREAK SPACE}", " ")


def _head(found: RobotFindings) -> str:
    legs = found.legs
    return _line(
        found.name,
        f": {plural(found.links, 'link')}, {plural(found.joints, 'joint')}, {found.mass:.3f} kg; "
        f"hips {legs.hips_apart:.3f} m apart, leg {legs.thigh:.3f} + {legs.shank:.3f} + "
        f"{legs.ankle:.3f} = {legs.length:.3f} m",
        label_width=0,
    )


def _lines(found: RobotFindings) -> list[str]:
    """What was found, a label a line."""
    legs, stance = found.legs, found.stance
    roles = ", ".join(ROLES[letter.upper()] + ROUGHLY * letter.islower() for letter in legs.roles)
    lines = [
        _line(
            "legs",
            f"left {legs.feet[0]}, right {legs.feet[1]} ({legs.names_agree} of "
            f"{legs.names_with_side} names agree), on {legs.pelvis}: {roles}; "
            f"mirror to {1e3 * legs.mirror_misfit:.1f} mm",
        ),
        _line("soles", _sole_text(found)),
        _line(
            "stands",
            f"hips at {stance.hip_height:.3f} m, CoM at {stance.com_height:.3f} m over mid-sole; "
            f"natural period {stance.natural_period:.2f} s; both knees bend {stance.knees}",
        ),
        _line("reach", _reach_text(found)),
        *(_line("servos" * (not k), _servo_text(each)) for k, each in enumerate(found.servos)),
    ]
    lines += [
        _line(
            "error",
            f"cannot stand: {each.standing_joint} needs {each.standing_torque:.3g} N m, has "
            f"{each.torque:.3g}; a stronger servo, or other numbers under `servos:`",
        )
        for each in found.too_weak
    ]
    if found.no_walk:
        lines.append(_line("error", f"the default walk cannot be commanded: {found.no_walk}"))
    warnings = [
        f"the default walk asks {each.walk_joint} for {each.walk_speed:.3g} rad/s, its servo has "
        f"{each.speed:.3g} without load: it will lag; walk slower or with smaller steps"
        for each in found.servos
        if each.walk_speed is not None and each.walk_speed > each.speed
    ]
    warnings += found.warnings
    return lines + [_line("warns" * (not k), text) for k, text in enumerate(warnings)]


def _sole_text(found: RobotFindings) -> str:
    sole = found.sole
    heel = f"heel {1e3 * sole.heel:.0f} mm behind the ankle axis"
    if abs(sole.heel_behind_joint - sole.heel) > APART:
        heel += f", {1e3 * sole.heel_behind_joint:.0f} mm behind where the foot's joint is drawn"
    level = degrees(sole.tilt) < LEVEL
    tilt = "level" if level else f"tilted {degrees(sole.tilt):.1f} degrees"
    shapes = [plural(count, kind) for kind, count in sole.shapes.items()]
    shapes = [text.replace("meshs", "meshes").replace("boxs", "boxes") for text in shapes]
    source = f"from {', '.join(shapes)}" if shapes else "from no geometry"
    if sole.stated:
        source = f"{', '.join(sole.stated)} from the robot file"
    return f"{sole.length:.3f} x {sole.width:.3f} m, {heel}; {tilt} at zero pose; {source}"


def _reach_text(found: RobotFindings) -> str:
    """Each direction, those that one thing ends together."""
    from gaitlab.model.foreign.findings import FOLDED, STRAIGHT

    said = {STRAIGHT: "the leg is straight", FOLDED: "the leg is folded"}
    ends: dict[str, list[str]] = {}
    for name, reach in found.reach.items():
        ends.setdefault(reach.ends, []).append(f"{reach.distance:.3f} m {name}")
    parts = [f"{', '.join(ways)} ({said.get(end, f'{end} ends')})" for end, ways in ends.items()]
    return f"left foot {', '.join(parts)}"


def _servo_text(found: ServoFindings) -> str:
    by = {"assumed": "ASSUMED", "servo file": found.servo}.get(
        found.stated_by, f"from the {found.stated_by}"
    )
    text = (
        f"{found.torque:.3g} N m, {found.speed:.3g} rad/s, {by}: "
        f"{plural(len(found.joints), 'joint')}; standing uses {_percent(found.standing_share)} of "
        f"the torque ({found.standing_joint})"
    )
    if found.walk_speed:
        text += f", the default walk {_percent(found.walk_speed / found.speed)} of the speed"
        text += f" ({found.walk_joint})"
    return text


def _percent(share: float) -> str:
    return f"{100.0 * share:.0f} %"


def _files_lines(files: Mapping[Path, str]) -> list[str]:
    """What was written, what was kept, and the next command."""
    lines = []
    for how, why in (("written", ""), ("kept", ": there already, and not this; see --force")):
        named = [str(file) for file, done in files.items() if done == how]
        if named:
            lines.append(_line({"written": "wrote"}.get(how, how), f"{', '.join(named)}{why}"))
    experiment = next(file for file in files if file.name == EXPERIMENT)
    return [*lines, _line("next", f"gaitlab run {shlex.quote(str(experiment))}")]
