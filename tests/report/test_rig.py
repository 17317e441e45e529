"""A report says so when its robot hangs on a gantry."""

from __future__ import annotations

import pytest

from gaitlab.report.provenance import DescribedPart, gantry_note
from gaitlab.robots.biped import Robot as Biped
from gaitlab.robots.eros import Robot as Eros


def part(robot: object, *varied: str) -> DescribedPart:
    return DescribedPart(title="robot", path="robot", value=robot, varied=frozenset(varied))


def test_a_robot_on_its_own_needs_no_note() -> None:
    assert gantry_note([]) == ""
    assert gantry_note([part(Eros()), part(Biped(gantry="none"))]) == ""


@pytest.mark.parametrize(("gantry", "held"), [("level", "pitch"), ("planar", "roll and yaw")])
def test_a_robot_on_a_gantry_is_declared_with_what_it_holds(gantry: str, held: str) -> None:
    note = gantry_note([part(Eros()), part(Biped(gantry=gantry))])
    assert "does not balance by itself" in note
    assert held in note.split(";")[0]


def test_a_gantry_that_is_varied_is_declared_as_such() -> None:
    assert "is varied" in gantry_note([part(Biped(gantry="none"), "robot.gantry")])
