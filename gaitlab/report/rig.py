"""What a report says of a robot that does not stand on its own."""

from __future__ import annotations

from collections.abc import Sequence

from gaitlab.body import gantry_of
from gaitlab.report.markdown import escape
from gaitlab.report.provenance import Part

HELD = {
    "level": "holds its lateral motion, roll, yaw and pitch",
    "planar": "holds its lateral motion, roll and yaw",
}


def gantry_note(parts: Sequence[Part]) -> str:
    """A bold line for every robot on a gantry; empty when all stand on their own."""
    robots = [part for part in parts if part.path == "robot"]
    return " ".join(note for note in map(_note, robots) if note)


def _note(part: Part) -> str:
    if "robot.gantry" in part.varied:
        return (
            f"**On a gantry: the gantry of {escape(part.title)} is varied; only where it is `none` "
            "does the robot balance by itself.**"
        )
    kind = gantry_of(part.value)
    if kind == "none":
        return ""
    return (
        f"**On a gantry: a rig {HELD[kind]}; {escape(part.title)} does not balance by itself, and "
        "staying up says that its legs carried it.**"
    )
