"""A push gives the robot its impulse and nothing else, and a slope is gravity that leans."""

from __future__ import annotations

import itertools
from dataclasses import replace
from math import atan, cos, degrees, radians, sin, tan

import numpy as np
import pytest

from gaitlab.balance.ankle_hip import Balance
from gaitlab.errors import WrongValue
from gaitlab.kinematics.transforms import rotation_of
from gaitlab.log import TrialLog
from gaitlab.log.course import Course
from gaitlab.model.imu import Imu, Readings
from gaitlab.model.settings import EngineName, Push, Slope
from gaitlab.parameters import values
from gaitlab.simulation.pushes import NOTHING, Pushes
from gaitlab.simulation.simulate import simulate
from gaitlab.simulation.tape import Tape
from gaitlab.simulation.trial import Trial, plugin
from tests.ground.bench import Bench, Sled, surface
from tests.trials import STILL, standing, trial

ENGINES: tuple[EngineName, ...] = ("bullet", "mujoco")
GRAVITY = 9.81
FAINT = 1e-200  # N s, far below the last digit of any force


@pytest.fixture(params=ENGINES)
def engine(request: pytest.FixtureRequest) -> EngineName:
    name: EngineName = request.param
    return name


def stood(engine: EngineName, seconds: float = 1.0, **parts: object) -> Trial:
    """EROS standing on a hard floor without any spread."""
    made = standing("hard_floor", seconds, spread=STILL, engine={"name": engine})
    return replace(made, **parts)


def same(one: TrialLog, other: TrialLog) -> bool:
    return all(np.array_equal(one[n], other[n], equal_nan=True) for n in one.arrays)


def pushed(log: TrialLog) -> np.ndarray:
    """Force on both soles, in [N]. Shape (n, 3)."""
    feet = ("left_foot", "right_foot")
    along = sum(log.vector(f"{foot}_force_", "xy") for foot in feet)
    return np.column_stack([along, sum(log[f"{foot}_normal_force"] for foot in feet)])


def middle(sled: Sled, tape: Tape) -> np.ndarray:
    """Centre of mass at the end of a tape, in [m]. Shape (3,)."""
    row, joints = tape.trunk[-1:], tape.joints[-1:, 0]
    poses = sled.tree.poses(row[:, :3], rotation_of(row[:, 3:7]), joints)
    found: np.ndarray = sled.tree.centre_of_mass(poses)[0]
    return found


# What nobody pushes, on level ground.


def test_nothing_set_leaves_a_trial_its_name_and_its_record() -> None:
    plain = trial()
    assert replace(plain, slope=Slope(), push=Push()).id == plain.id
    assert not {"slope", "push"} & plain.to_dict().keys()
    assert values(Slope()) == values(Push()) == {}


@pytest.mark.parametrize("part", [Slope(pitch=1.0), Slope(roll=-1.0)])
def test_every_slope_is_another_trial(part: Slope) -> None:
    leaning = replace(trial(), slope=part)
    assert leaning.id != trial().id
    assert Trial.from_dict(leaning.to_dict()) == leaning


@pytest.mark.parametrize("field", ["impulse", "direction", "cycle", "instant", "duration"])
def test_every_field_of_a_push_is_part_of_the_name(field: str) -> None:
    push = Push(impulse=1.0, direction=10.0, cycle=1)
    other = replace(push, **{field: getattr(push, field) * 2})
    one, two = (replace(trial(cycles=4.0), push=each) for each in (push, other))
    assert one.id != two.id
    assert Trial.from_dict(two.to_dict()) == two


def test_a_push_of_nothing_changes_no_bit(engine: EngineName) -> None:
    plain = trial(engine={"name": engine})
    idle = replace(plain, push=Push(direction=90.0, cycle=1))
    assert same(simulate(plain), simulate(idle))


@pytest.mark.parametrize("closed", [False, True])
def test_a_walk_in_pieces_is_the_walk_in_one(engine: EngineName, closed: bool) -> None:
    """The faintest push cuts the walk at odd ticks, and is lost in the first addition."""
    plain = trial(engine={"name": engine})
    if closed:
        plain = replace(plain, balance=Balance(), balance_code=plugin("balance", "ankle_hip"))
    faint = replace(plain, push=Push(impulse=FAINT, cycle=1, instant=0.3333, duration=0.033))
    assert same(simulate(plain), simulate(faint))


# The push.


@pytest.mark.parametrize("duration", [0.05, 0.0133, 1e-4])
def test_the_force_adds_up_to_the_impulse(duration: float) -> None:
    made = trial(cycles=4.0)
    push = Push(impulse=1.7, direction=30.0, duration=duration)
    pushes = Pushes(replace(made, push=push), Course(ahead=0.1))
    dt = made.engine.dt
    ticks = [force for low, high, force in pushes.pieces(0, 5000) for _ in range(low, high)]
    total = dt * np.sum(ticks, axis=0)
    assert total == pytest.approx(1.7 * np.array([cos(radians(30)), sin(radians(30)), 0.0]))
    assert len(ticks) == 5000


def test_pieces_follow_each_other_and_cover_everything() -> None:
    pushes = Pushes(replace(trial(cycles=4.0), push=Push(impulse=1.0)), Course(ahead=0.1))
    for start in range(pushes.first - 3, pushes.end + 3):
        for stop in range(start + 1, pushes.end + 5):
            pieces = list(pushes.pieces(start, stop))
            assert (pieces[0][0], pieces[-1][1]) == (start, stop)
            assert all(a[1] == b[0] for a, b in itertools.pairwise(pieces))
            loud = {t for low, high, f in pieces if f != NOTHING for t in range(low, high)}
            assert loud == set(range(start, stop)) & set(range(pushes.first, pushes.end))


def test_it_begins_at_its_phase_of_its_cycle(engine: EngineName) -> None:
    made = trial(cycles=2.0, engine={"name": engine})
    push = Push(impulse=0.05, cycle=2, instant=0.25)
    plain, hit = simulate(made), simulate(replace(made, push=push))
    first = int(np.flatnonzero(plain["trunk_vx"] != hit["trunk_vx"])[0])
    gait = made.gait
    begun = (plain["time"][first] - made.engine.dt - gait.startup_time) / gait.gait_period
    assert begun == pytest.approx(1.25, abs=made.engine.dt / gait.gait_period)
    assert plain["gait_phase"][first] == pytest.approx(0.25, abs=0.01)


@pytest.mark.parametrize("direction", [0.0, 90.0, 180.0, -45.0])
def test_it_pushes_where_it_says(engine: EngineName, direction: float) -> None:
    made = stood(engine)
    push = Push(impulse=0.5, direction=direction, cycle=1, instant=0.0, duration=0.002)
    plain, hit = simulate(made), simulate(replace(made, push=push))
    first = int(np.flatnonzero(plain["trunk_vx"] != hit["trunk_vx"])[0])
    gained = hit.vector("trunk_v", "xy")[first] - plain.vector("trunk_v", "xy")[first]
    found = degrees(np.arctan2(gained[1], gained[0]))
    assert abs((found - direction + 180.0) % 360.0 - 180.0) < 10.0  # legs do not give way alike


def test_it_turns_with_the_robot_that_is_commanded_to_turn() -> None:
    made = replace(trial(cycles=4.0), push=Push(impulse=1.0, duration=0.002))
    rate = 0.3
    ahead = np.array(Pushes(made, Course(ahead=0.1)).force)
    turned = np.array(Pushes(made, Course(ahead=0.1, rate=rate)).force)
    angle = rate * 2.25 * made.gait.gait_period
    c, s = cos(angle), sin(angle)
    assert turned == pytest.approx(np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ ahead)


@pytest.mark.parametrize("direction", [0.0, 90.0, 240.0])
def test_a_robot_that_floats_takes_up_the_impulse(engine: EngineName, direction: float) -> None:
    """Away from ground and gravity; a faster turn costs the positions of a tick more digits."""
    impulse, sled = 0.05, Sled()
    push = Push(impulse=impulse, direction=direction, cycle=1, instant=0.1)
    pushes = Pushes(replace(stood(engine), push=push), Course(ahead=0.0))
    with Bench(surface("hard_floor"), sled, gap=5.0, engine=engine, gravity=NOTHING) as bench:
        for low, high, force in pushes.pieces(pushes.first - 5, pushes.end + 5):
            for _ in range(low, high):
                bench.tick(force)
        before = middle(sled, bench.last)
        bench.tick()
        momentum = sled.mass * (middle(sled, bench.last) - before) / bench.dt
    wanted = impulse * np.array([cos(radians(direction)), sin(radians(direction)), 0.0])
    assert momentum == pytest.approx(wanted, abs=1e-6 * impulse)


def test_pushes_to_both_sides_are_mirror_images(engine: EngineName) -> None:
    made = stood(engine)
    left, right = (
        simulate(replace(made, push=Push(impulse=0.3, direction=side, cycle=1, instant=0.0)))
        for side in (90.0, -90.0)
    )
    n = min(len(left), len(right))
    for name, sign in {"trunk_y": -1.0, "roll": -1.0, "trunk_x": 1.0, "pitch": 1.0}.items():
        assert left[name][:n] == pytest.approx(sign * right[name][:n], abs=2e-3)
    assert left["roll"].min() < -0.005  # rad, to the left


def test_a_push_after_the_end_is_refused() -> None:
    with pytest.raises(WrongValue, match=r"push\.cycle"):
        replace(trial(cycles=2.0), push=Push(impulse=1.0, cycle=3))


# The slope.


@pytest.mark.parametrize(("pitch", "roll"), [(5.0, 0.0), (0.0, 5.0), (-7.0, 3.0), (30.0, -30.0)])
def test_gravity_leans_by_the_slope(pitch: float, roll: float) -> None:
    slope = Slope(pitch=pitch, roll=roll)
    up = np.array(slope.up)
    assert np.linalg.norm(up) == pytest.approx(1.0)
    assert up[:2] == pytest.approx([sin(radians(pitch)), sin(radians(roll))])
    assert np.array(slope.gravity) == pytest.approx(-GRAVITY * up)


@pytest.mark.parametrize(("pitch", "roll"), [(5.0, 0.0), (0.0, 5.0), (-7.0, 3.0), (30.0, -30.0)])
def test_an_imu_feels_gravity(pitch: float, roll: float) -> None:
    """Facing uphill, who stands at a right angle to the slope leans back."""
    slope = Slope(pitch=pitch, roll=roll)
    true = Imu(rate_noise=0.0, rate_bias=0.0, attitude_noise=0.0, attitude_bias=0.0)
    imu = Readings(true, 0.002, np.random.default_rng(0), slope.level)
    imu.see((0.0, 0.0, 0.0, 1.0), (0.1, 0.2, 0.3))
    felt = imu.read()
    assert degrees(felt.pitch) == pytest.approx(-pitch)
    assert sin(felt.roll) * cos(felt.pitch) == pytest.approx(sin(radians(roll)))
    assert (felt.roll_rate, felt.pitch_rate) == pytest.approx((0.1, 0.2))


def test_on_the_level_nothing_is_turned() -> None:
    assert Slope().level is None
    assert Slope().gravity == (0.0, 0.0, -GRAVITY)


@pytest.mark.parametrize("axis", ["pitch", "roll"])
@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize("share", [0.85, 1.15])
def test_a_block_slides_where_the_slope_is_steeper_than_its_friction(
    engine: EngineName, axis: str, side: float, share: float
) -> None:
    friction, seconds = 0.3, 0.5
    angle = degrees(atan(share * friction))
    slope = Slope(**{axis: side * angle})
    ground = surface("hard_floor", friction=friction, friction_scale=1.0)
    with Bench(ground, Sled(), gap=0.0, engine=engine, gravity=slope.gravity) as bench:
        bench.run(0.1)
        before = bench.engine.trunk[:2].copy()
        speed = bench.engine.trunk[7:9].copy()
        bench.run(seconds)
        gone = bench.engine.trunk[:2] - before - speed * seconds
    down = -side * gone[{"pitch": 0, "roll": 1}[axis]]
    steep = radians(angle)
    if share < 1.0:
        assert abs(down) < 1e-3  # m, the creep of friction
    else:
        wanted = 0.5 * GRAVITY * (sin(steep) - friction * cos(steep)) * seconds**2
        assert down == pytest.approx(wanted, rel=0.03)


@pytest.mark.parametrize("slope", [Slope(pitch=6.0), Slope(pitch=-4.0), Slope(roll=6.0)])
def test_the_ground_carries_the_weight_along_gravity(engine: EngineName, slope: Slope) -> None:
    log = simulate(stood(engine, slope=slope))
    assert log.fall_index is None
    force = pushed(log)[-200:].mean(axis=0)
    assert force == pytest.approx(log.header.weight * np.array(slope.up), abs=0.3)
    leaning = slope.pitch or slope.roll
    assert np.hypot(*force[:2]) / force[2] == pytest.approx(tan(radians(abs(leaning))), rel=0.02)


def test_slopes_to_both_sides_are_mirror_images(engine: EngineName) -> None:
    left, right = (simulate(stood(engine, slope=Slope(roll=s))) for s in (5.0, -5.0))
    for name, sign in {"trunk_y": -1.0, "roll": -1.0, "trunk_x": 1.0, "pitch": 1.0}.items():
        assert left[name] == pytest.approx(sign * right[name], abs=2e-3)


def test_a_robot_that_stands_at_a_right_angle_to_a_slope_has_not_fallen(
    engine: EngineName,
) -> None:
    log = simulate(stood(engine, slope=Slope(pitch=10.0)))
    assert log.fall_index is None
    assert abs(float(log["pitch"][-1])) < radians(5.0)
