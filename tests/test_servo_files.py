"""The shipped servos: the maker's figures in SI units, each with its source."""

from __future__ import annotations

from math import pi, radians

import pytest

from gaitlab.documents import load
from gaitlab.errors import FileError, UnknownName
from gaitlab.model.servo import Servo
from gaitlab.parameters import parameter_table
from gaitlab.plugins import locate, names
from gaitlab.servos.files import load_servo

# Stall torque [N m], no-load speed [rev/min], resolution [deg] and mass [g] at 12 V.
SHEETS = [
    ("mx_28", 2.5, 55, 0.088, 72),
    ("mx_64", 6.0, 63, 0.088, 126),
    ("ax_12", 1.5, 59, 0.29, 54.6),
]


@pytest.mark.parametrize(("name", "torque", "speed", "resolution", "mass"), SHEETS)
def test_a_servo_has_the_figures_of_its_data_sheet(name, torque, speed, resolution, mass) -> None:
    servo = load_servo(name)
    assert servo.stall_torque == torque
    assert servo.no_load_speed == pytest.approx(speed * pi / 30.0, rel=1e-3)
    assert servo.resolution == pytest.approx(radians(resolution), rel=1e-3)
    assert servo.mass == pytest.approx(mass / 1000.0)
    assert servo.voltage == 12.0


def test_the_ax_12_reaches_full_duty_at_its_compliance_slope() -> None:
    servo = load_servo("ax_12")
    assert servo.no_load_speed / servo.position_gain == pytest.approx(radians(32 * 0.29), rel=2e-3)


@pytest.mark.parametrize("name", ["mx_28", "mx_64"])
def test_the_gain_of_an_mx_lies_between_its_factory_value_and_its_largest(name: str) -> None:
    servo = load_servo(name)
    factory = servo.no_load_speed / radians(256 * 0.088)
    assert factory < servo.position_gain < factory * 254 / 32


SOURCES = ("ROBOTIS", "Aldebaran", "naoV40 URDF", "assumption", "derived")  # makers, or ours


@pytest.mark.parametrize("name", names("servo"))
def test_every_number_of_a_shipped_servo_has_unit_and_source(name: str) -> None:
    root, table = load(locate("servo", name)), parameter_table(Servo)
    numbers = root.without("description").mapping
    assert set(numbers) == set(table)
    for key, node in numbers.items():
        assert node.mapping["unit"].value == table[key].unit
        assert str(node.mapping["source"].value).startswith(SOURCES)


def test_an_unknown_or_wrong_servo_is_refused(tmp_path) -> None:
    with pytest.raises(UnknownName, match="did you mean 'mx_28'"):
        load_servo("mx28")
    (tmp_path / "ours.yaml").write_text("stall_torque: 2.5\nlatency: fast\n")
    with pytest.raises(FileError) as caught:
        load_servo("./ours.yaml", tmp_path)
    assert "ours.yaml:2:10: latency: found the text 'fast'; allowed is a number" in str(
        caught.value
    )


@pytest.mark.parametrize(
    ("written", "place"),
    [
        ("2", "1:10"),
        ('{value: 2, unit: "-", source: bus}', "1:27"),
        ("{value: 2, unit: s}", "1:18"),
    ],
)
def test_a_servo_file_with_ticks_is_told_the_seconds(tmp_path, written: str, place: str) -> None:
    rest = (line for line in locate("servo", "mx_28").read_text().splitlines())
    others = "\n".join(line for line in rest if not line.startswith("latency"))
    (tmp_path / "ours.yaml").write_text(f"latency: {written}\n{others}\n")
    with pytest.raises(FileError) as caught:
        load_servo("./ours.yaml", tmp_path)
    (problem,) = caught.value.problems
    assert f"ours.yaml:{place}: latency" in str(problem)
    assert "seconds" in problem.message
    assert "2 ticks of 2 ms are written 0.004" in problem.message


def test_a_latency_that_never_was_ticks_is_told_its_range_alone(tmp_path) -> None:
    (tmp_path / "ours.yaml").write_text("latency: 200\n")
    with pytest.raises(FileError) as caught:
        load_servo("./ours.yaml", tmp_path)
    assert "0 to 0.2 s" in str(caught.value)
    assert "ticks" not in str(caught.value)
