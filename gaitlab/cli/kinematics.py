"""`gaitlab ik` and `fk`: where a limb ends, and how to get it somewhere."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

import typer

from gaitlab.cli.options import Settings, completed, names_of
from gaitlab.cli.printing import columns, say
from gaitlab.errors import UnknownName, UsageError, WrongValue

if TYPE_CHECKING:
    import numpy as np

    from gaitlab.model.limbs import Branch, Limb

LIMBS = ("left_leg", "right_leg", "left_arm", "right_arm", "head")
NUMBERS = {"ignore_unknown_options": True}  # else -0.2 would be an option

RobotName: TypeAlias = Annotated[
    str,
    typer.Argument(
        metavar="ROBOT",
        help="A name from `gaitlab list robots`, or a file.",
        autocompletion=completed(lambda: names_of("robot")),
    ),
]
LimbName: TypeAlias = Annotated[
    str,
    typer.Argument(
        metavar="LIMB",
        help=f"{', '.join(LIMBS[:-1])} or {LIMBS[-1]}.",
        autocompletion=completed(lambda: LIMBS),
    ),
]
More: TypeAlias = Annotated[list[str] | None, typer.Argument(metavar="NUMBER", hidden=True)]
AsJson: TypeAlias = Annotated[bool, typer.Option("--json", help="Print one JSON object.")]


def ik(
    robot: RobotName,
    limb: LimbName,
    more: More = None,
    target: Annotated[
        str | None,
        typer.Option("--target", metavar="X Y Z", help="Where the limb's end shall be, in m."),
    ] = None,
    heading: Annotated[
        float, typer.Option("--heading", metavar="RAD", help="Yaw of a foot, in rad.")
    ] = 0.0,
    settings: Settings = None,
    every: Annotated[
        bool, typer.Option("--all", help="Every branch, those beyond joint limits too.")
    ] = False,
    counts: Annotated[
        bool, typer.Option("--counts", help="Goal positions of the servos as well.")
    ] = False,
    as_json: AsJson = False,
) -> int:
    """Find the joint angles that put the end of a limb at a point.

    \b
    Example:
      gaitlab ik eros left_leg --target 0.02 0.05 -0.25 --json
    """
    from gaitlab.model.limbs import branches

    chain = _limb(robot, limb, settings or ())
    found = branches(chain, _numbers("--target", target, more), heading)
    if not every:
        if found[0].beyond:
            raise WrongValue(f"{limb}: {'; '.join(found[0].beyond)}; move the target, or see --all")
        found = found[:1]
    say(_solutions_json(chain, found, every, counts) if as_json else _table(chain, found, counts))
    return 0


def fk(
    robot: RobotName,
    limb: LimbName,
    more: More = None,
    joints: Annotated[
        str | None,
        typer.Option("--joints", metavar="Q1 Q2 ...", help="Joint angles along the limb, in rad."),
    ] = None,
    settings: Settings = None,
    as_json: AsJson = False,
) -> int:
    """Find where a limb ends, from its joint angles.

    \b
    Example:
      gaitlab fk eros left_leg --joints 0 0 -0.4 0.8 -0.4 0 --json
    """
    from gaitlab.model.limbs import end_pose

    chain = _limb(robot, limb, settings or ())
    angles = _numbers("--joints", joints, more)
    pose = end_pose(chain, angles)
    named = {joint.name: angle for joint, angle in zip(chain.joints, angles, strict=True)}
    say(json.dumps({"joints": named, **_pose(pose)}) if as_json else _pose_text(chain, pose))
    return 0


def _limb(robot: str, name: str, settings: Sequence[str]) -> Limb:
    """A limb of a robot, settings applied.

    Raises:
        UnknownName: If there is no such robot or limb.
        FileError: If a setting is wrong.
    """
    from gaitlab.model.limbs import Limbed
    from gaitlab.plugins import label, suggestion

    owner = _robot(robot, settings)
    if not isinstance(owner, Limbed):
        raise UnknownName(f"{label(robot)} has no limbs to ask; its file defines no `limbs`")
    known = owner.limbs()
    if name not in known:
        raise UnknownName(f"{label(robot)} has no limb {name!r}{suggestion(name, known)}")
    return known[name]


def _robot(name: str, settings: Sequence[str]) -> Any:
    """The robot with parameters of its own set, `leg.thigh=0.11` for instance."""
    from gaitlab.documents import Node, build
    from gaitlab.experiment.reading import apply_setting
    from gaitlab.plugins import load_class

    tree = Node(file=Path(name), value={})
    for setting in settings:
        tree = apply_setting(tree, setting)
    return build(load_class("robot", name), tree, skip=())


def _numbers(option: str, first: str | None, rest: Sequence[str] | None) -> list[float]:
    """Numbers after an option, parted by spaces or commas.

    Raises:
        UsageError: If there is none, or an option that does not exist among them.
        WrongValue: If one is no number.
    """
    if first is None:
        raise UsageError(f"{option} is missing; see --help")
    typed = " ".join([first, *(rest or ())]).split()
    commas = [word for word in typed if len(typed) > 1 and re.fullmatch(r"[-+]?\d*,\d+", word)]
    words = " ".join(typed).replace(",", " ").split()
    unknown = [word for word in words if word.startswith("--")]
    if unknown:
        raise UsageError(f"there is no option {unknown[0]}; see --help")
    try:
        if commas:
            raise ValueError
        return [float(word) for word in words]
    except ValueError:
        from gaitlab.documents import instead

        found, meant = " ".join(typed), next(filter(None, map(instead, typed)), "")
        hint = f"; {meant}" if meant else ""
        message = f"{option}: found {found!r}; give numbers parted by spaces{hint}"
        raise WrongValue(message) from None


def _named(limb: Limb, joints: np.ndarray) -> dict[str, float]:
    # Adding 0 makes a 0 of a -0.
    return {
        joint.name: float(angle) + 0.0 for joint, angle in zip(limb.joints, joints, strict=True)
    }


def _counts(limb: Limb, joints: np.ndarray) -> dict[str, int]:
    from gaitlab.servos.counts import limb_counts

    return limb_counts(limb, joints)


def _solution(limb: Limb, branch: Branch, counts: bool) -> dict[str, object]:
    found: dict[str, object] = {"joints": _named(limb, branch.joints)}
    if counts:
        found["counts"] = _counts(limb, branch.joints)
    return found


def _solutions_json(limb: Limb, found: Sequence[Branch], every: bool, counts: bool) -> str:
    shown: dict[str, object] = _solution(limb, found[0], counts)
    if every:
        shown["branches"] = [
            {**_solution(limb, branch, counts), "beyond": list(branch.beyond)} for branch in found
        ]
    return json.dumps(shown)


def _table(limb: Limb, found: Sequence[Branch], counts: bool) -> str:
    head = ["joint", "rad", "degrees", *(["counts"] if counts else [])]
    return "\n\n".join(
        "\n".join([columns(head, _rows(limb, branch, counts)), *branch.beyond]) for branch in found
    )


def _rows(limb: Limb, branch: Branch, counts: bool) -> list[list[str]]:
    from math import degrees

    named = _named(limb, branch.joints)
    steps: Mapping[str, int] = _counts(limb, branch.joints) if counts else {}
    return [
        [
            name,
            f"{round(angle, 6) + 0.0:.6f}",
            f"{round(degrees(angle), 3) + 0.0:.3f}",
            *([str(steps[name])] if counts else []),
        ]
        for name, angle in named.items()
    ]


def _pose(pose: np.ndarray) -> dict[str, list]:
    return {"position": pose[:3, 3].tolist(), "rotation": pose[:3, :3].tolist()}


def _pose_text(limb: Limb, pose: np.ndarray) -> str:
    rows = [
        [axis, *(f"{round(value, 6) + 0.0:.6f}" for value in row)]
        for axis, row in zip("xyz", pose, strict=False)
    ]
    head = ("", "x axis", "y axis", "z axis", "position [m]")
    return f"{limb.target}\n{columns(head, rows)}"
