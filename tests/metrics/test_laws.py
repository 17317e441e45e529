"""What holds for every metric: documented, total, pure, and blind to what it should not see."""

from __future__ import annotations

import ast
from math import isnan
from pathlib import Path

import numpy as np
import pytest

import gaitlab.metrics
from gaitlab import plugins
from gaitlab.errors import UnknownName
from gaitlab.log import TrialLog
from gaitlab.metrics import REQUISITES, Value, lookup, measure, names
from tests.synthetic import HEADER, fall, header, mirrored, sine, walk

ALL = pytest.mark.parametrize("name", names())
UNITS = {"-", "m", "m/s", "s", "rad", "N", "N m", "J"}


def busy(**courses) -> TrialLog:
    """A walk in which everything moves and nothing is symmetric."""
    return walk(**(BUSY | courses))


BUSY = {
    "pitch": sine(0.1, offset=0.05),
    "roll": sine(0.07, period=0.4),
    "yaw": lambda walked: 0.3 + 0.02 * walked,
    "trunk_y": lambda walked: 0.01 * walked,
    "zmp_margin": sine(0.03, offset=0.01),
    "left_foot_plough_force": sine(2.0),
    "left_knee_torque": sine(2.5),
    "left_knee_velocity": sine(3.0),
    "left_knee_target": sine(0.2),
    "right_hip_roll_torque": sine(1.0, offset=0.5),
    "right_hip_roll_velocity": 0.7,
    "left_foot_fsr_front_left": 9.0,
}


def in_flight() -> TrialLog:
    courses = {f"{side}_foot_normal_force": 0.0 for side in ("left", "right")}
    courses |= {f"{side}_foot_contact": False for side in ("left", "right")}
    return walk(**courses, support=0, zmp_margin=np.nan)


def blown_up() -> TrialLog:
    log = busy()
    arrays = {name: np.array(array) for name, array in log.arrays.items()}
    for i, (name, array) in enumerate(sorted(arrays.items())):
        if array.dtype == np.float32 and name != "time":
            array[len(log) // 2 :] = [np.nan, np.inf, -np.inf][i % 3]
    return TrialLog(header=log.header, arrays=arrays)


BELTED = header(
    joints=("left_knee", "left_ankle", "right_knee", "right_ankle", "gantry_pitch"),
    torque_limits=(2.5, 0.0, 2.5, 0.0, 0.0),
)
LOGS = {
    "a walk": busy(),
    "a backward walk": walk(header(step_length=-0.04)),
    "stepping on the spot": walk(header(step_length=0.0)),
    "marking time": walk(speed=0.0),
    "toes first": walk(left_foot_fsr_front_left=9.0, left_foot_sink=-0.05),
    "heel against toe": walk(left_foot_fsr_rear_left=40.0, left_foot_fsr_rear_right=40.0),
    "a fall": fall("left", pitch=sine(0.1)),
    "a fall forward": fall(at=4.0),
    "a squat": walk(trunk_z=lambda walked: np.where(walked > 2.0, 0.1, 0.3)),
    "a fall in the start-up": fall(at=-0.9),
    "one tick": walk(header(startup_time=0.0), cycles=HEADER.dt / HEADER.gait_period),
    "one tick of the start-up": walk(header(startup_time=HEADER.dt), cycles=0.0),
    "one tick of one gait period": walk(header(startup_time=0.0, dt=0.8), cycles=1.0),
    "a flight": in_flight(),
    "a simulation that blew up": blown_up(),
    "a walk on belts and a gantry": walk(BELTED),
    "belts that give way": walk(
        BELTED, left_ankle_position=0.1, gantry_pitch_torque=3.0, left_foot_sink=0.04
    ),
}


def same(a: Value, b: Value, tolerance: float = 0.0) -> bool:
    if isinstance(a, float) and isinstance(b, float):
        return (isnan(a) and isnan(b)) or abs(a - b) <= tolerance
    return type(a) is type(b) and a == b


def assert_same(
    a: TrialLog, b: TrialLog, tolerance: float = 0.0, but: tuple[str, ...] = ()
) -> None:
    one, other = measure(a), measure(b)
    differing = {n: (one[n], other[n]) for n in one if not same(one[n], other[n], tolerance)}
    assert {name: values for name, values in differing.items() if name not in but} == {}


def test_every_function_of_the_families_is_a_metric_that_can_be_named() -> None:
    defined = {
        node.name
        for file in Path(gaitlab.metrics.__file__).parent.glob("*.py")
        for node in ast.parse(file.read_text()).body
        if isinstance(node, ast.FunctionDef) and "log: TrialLog) -> " in file.read_text()
        if not node.name.startswith("_") and file.stem not in ("__init__", "metric")
    }
    assert set(measure(walk())) == set(names()) == defined == set(plugins.names("metric"))


def test_metrics_are_measured_in_the_order_of_their_names():
    assert list(measure(walk())) == sorted(names())


@ALL
def test_a_metric_that_takes_sides_is_a_number_or_a_flag(name: str) -> None:
    assert lookup(name).better in ("higher", "lower", "neither")
    if lookup(name).better != "neither":
        assert isinstance(lookup(name)(busy()), (bool, int, float))


def test_what_is_better_follows_the_words() -> None:
    assert (lookup("stable").better, lookup("fell").better) == ("higher", "lower")
    assert lookup("fall_direction").better == "neither"


@ALL
def test_metric_has_a_unit_and_says_what_it_is(name):
    found = lookup(name)
    assert found.unit in UNITS
    assert found.doc.split("\n")[0].endswith((".", ":"))
    assert found.kind in (float, int, bool, str)
    assert set(found.needs) <= set(REQUISITES)
    if found.unit != "-":
        assert f"[{found.unit}]" in found.doc


def test_a_misspelt_metric_lists_the_known_ones():
    with pytest.raises(UnknownName, match=r"'distanse'.*distance.*zmp_margin_min"):
        lookup("distanse")


@ALL
@pytest.mark.parametrize("log", LOGS.values(), ids=LOGS.keys())
def test_metric_is_a_plain_value_for_any_log(name, log):
    with np.errstate(all="ignore"):
        value = lookup(name)(log)
    assert value is None or type(value) in (float, bool, int, str)


@pytest.mark.parametrize("case", sorted(set(LOGS) - {"a simulation that blew up"}))
def test_no_metric_is_infinite(case):
    values = [v for v in measure(LOGS[case]).values() if isinstance(v, float)]
    assert not any(np.isinf(values))


@ALL
def test_metric_tells_some_logs_apart(name):
    values = {repr(lookup(name)(LOGS[case])) for case in LOGS if "blew" not in case}
    assert len(values - {"nan", "None"}) >= 2


@pytest.mark.parametrize("case", ["a walk", "a fall", "a flight", "a fall in the start-up"])
def test_measuring_twice_gives_the_same(case):
    assert_same(LOGS[case], LOGS[case])


def test_a_log_rebuilt_from_its_columns_measures_the_same():
    log = LOGS["a fall"]
    copies = {name: np.frombuffer(a.tobytes(), a.dtype) for name, a in log.arrays.items()}
    assert_same(TrialLog(header=log.header, arrays=copies), log)


@pytest.mark.parametrize("make", [busy, fall], ids=["walk", "fall"])
def test_a_longer_start_up_changes_nothing(make):
    log = make()
    later = header(startup_time=HEADER.startup_time + 0.37)
    courses = BUSY if make is busy else {"pitch": lambda w: 3.0 * np.maximum(w - 3.0, 0.0)}
    # The time column is float32: instants of seconds hold to a microsecond.
    assert_same(walk(later, **courses), log, tolerance=1e-5)


def test_what_happens_in_the_start_up_is_not_measured():
    log = busy()
    arrays = {name: np.array(array) for name, array in log.arrays.items()}
    for name, array in arrays.items():
        if name not in ("time", "fall_cause", "step_index"):
            array[: log.walking.start - 1] = 7
    assert_same(TrialLog(header=log.header, arrays=arrays), log)


@pytest.mark.parametrize("turn", [1.0, np.pi / 2, -3.0])
def test_no_metric_knows_where_north_is(turn):
    log = walk(pitch=sine(0.1), trunk_z=0.29)
    turned = walk(pitch=sine(0.1), trunk_z=0.29, heading=turn)
    assert_same(turned, log, tolerance=1e-5)  # float32 of half a metre


@pytest.mark.parametrize("make", [busy, lambda: fall("left"), fall])
def test_a_mirror_changes_only_the_sides(make):
    log, sides = make(), ("lateral_drift", "heading_drift", "heading_error", "fall_direction")
    assert_same(mirrored(log), log, tolerance=1e-9, but=sides)
    there, back = measure(log), measure(mirrored(log))
    assert back["lateral_drift"] == pytest.approx(-there["lateral_drift"], abs=1e-6)
    assert back["heading_drift"] == pytest.approx(-there["heading_drift"], abs=1e-6)
    swap = {"left": "right", "right": "left"}
    assert back["fall_direction"] == swap.get(there["fall_direction"], there["fall_direction"])


def test_mirroring_twice_gives_the_log_back():
    log = busy()
    again = mirrored(mirrored(log))
    assert all(np.array_equal(again[n], log[n], equal_nan=n == "gait_phase") for n in log.arrays)


def test_a_simulation_that_blew_up_is_measured_without_a_warning():
    found = measure(LOGS["a simulation that blew up"])
    assert isnan(found["peak_torque"])
    assert isnan(found["heading_drift"])


@pytest.mark.parametrize("log", LOGS.values(), ids=LOGS)
def test_a_fall_in_standing_is_a_fall_and_comes_before_the_first_step(log: TrialLog) -> None:
    found = measure(log)
    if found["fell_standing"]:
        assert found["fell"]
        assert not found["stable"]
        assert log["time"][log.fall_index] < log.header.first_step_time + log.header.dt
