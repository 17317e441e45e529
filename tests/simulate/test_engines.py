"""The contract of all engines: what a robot on its ground does, whoever simulates it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from gaitlab.experiment import load_experiment
from gaitlab.experiment.plan import plan
from gaitlab.kinematics.transforms import rotation_of
from gaitlab.log import GRAVITY, TrialLog
from gaitlab.model import Robot, Start
from gaitlab.model.commands import joint_commands
from gaitlab.model.gait import first_step
from gaitlab.model.settings import EngineName, Spread
from gaitlab.model.tree import Tree
from gaitlab.model.urdf import urdf
from gaitlab.robots import eros, flow
from gaitlab.servos.files import load_servo
from gaitlab.simulation.engine import Engine
from gaitlab.simulation.engines import engine_named
from gaitlab.simulation.simulate import engine_for, simulate, start_of
from gaitlab.simulation.tape import Tape
from gaitlab.simulation.trial import Trial
from tests.data.make_golden_logs import trials
from tests.driven import INSTALLED, drive, each_engine, endless
from tests.ground.bench import STILL, Bench, Sled, surface

GROUNDS = ("hard_floor", "carpet_4mm", "grass_10mm", "grass_30mm", "grass_50mm", "webots_grass")
ROBOTS = ("eros", "nao", "flow", "bioloid", "biped", "geared", "foreign")
GEARED = flow.Robot(parallelogram="geared")
each_robot = pytest.mark.parametrize("robot", ROBOTS)
both = pytest.mark.skipif(len(INSTALLED) < 2, reason="needs two engines")


@cache
def shipped() -> dict[str, Trial]:
    return trials()


@pytest.fixture(scope="session")
def foreign(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Trial]:
    """EROS as a team would bring it, from a URDF and with the general walk, by the ground."""
    folder, theirs = tmp_path_factory.mktemp("foreign"), eros.Robot()
    (folder / "theirs.urdf").write_text(urdf(theirs.tree, theirs.sole, theirs.feet))
    file = folder / "theirs.yaml"
    file.write_text(
        f"robot: ./theirs.urdf\ngait: walk\nsurfaces: [{', '.join(GROUNDS)}]\nseeds: 1\n"
    )
    planned = plan(load_experiment(file)).trials()
    return {item.trial.names.surface: item.trial for item in planned}


@pytest.fixture
def trial_of(foreign: dict[str, Trial]) -> Callable[..., Trial]:
    def made(robot: str, ground: str, engine: EngineName, **changes: object) -> Trial:
        """A trial of a robot on a ground, in an engine."""
        if robot == "foreign":
            trial = foreign[ground]
        elif robot == "geared":
            trial = shipped()[f"flow on {ground}"]
            joints = [joint for joint in GEARED.tree.joints if joint.servo is not None]
            servos = tuple(load_servo(joint.servo) for joint in joints)
            trial = replace(trial, robot=GEARED, servos=servos)
        else:
            trial = shipped()[f"{robot} on {ground}"]
        iterations = 200 if (robot, engine) == ("geared", "bullet") else 50
        settings = replace(trial.engine, name=engine, solver_iterations=iterations)
        return replace(trial, engine=settings, **changes)

    return made


def standing(trial: Trial, seconds: float) -> tuple[Tape, Trial]:
    """What happens to a robot that is commanded to stand as it stands first."""
    feet = trial.gait.feet(np.arange(2) * trial.engine.dt)
    pose = joint_commands(trial.robot, feet.at(0))[0]
    hung = getattr(trial.robot, "gantry", "none") != "none"
    with engine_for(trial, feet) as engine:
        return drive(engine, np.tile(pose, (round(seconds / trial.engine.dt), 1)), hung), trial


def loads(tape: Tape, trial: Trial) -> float:
    """Mean force up on all soles over weight, once the robot has settled."""
    half = tape.length // 2
    contacts = tape.contacts
    late = contacts.tick >= half
    total = contacts.force[late, 2].sum() / (tape.length - half)
    return float(total / (trial.robot.tree.mass * GRAVITY))


def lowest(tape: Tape, robot: Robot, side: int) -> np.ndarray:
    """Height of the lowest corner of a sole at each tick, in [m]."""
    count = len(robot.tree.joints)
    poses = robot.tree.poses(
        tape.trunk[:, 0:3], rotation_of(tape.trunk[:, 3:7]), tape.joints[:, 0, :count]
    )
    k = robot.tree.index(robot.feet[side])
    turned = robot.sole.corners(side) @ np.swapaxes(poses.rotation[:, k], 1, 2)
    return (poses.position[:, k, None, 2] + turned[..., 2]).min(axis=1)


@each_engine
@each_robot
@pytest.mark.parametrize("ground", ["hard_floor", "grass_30mm"])
def test_the_ground_carries_a_standing_robot(trial_of, robot, ground, engine) -> None:
    tape, trial = standing(trial_of(robot, ground, engine, spread=STILL), 0.4)
    assert loads(tape, trial) == pytest.approx(1.0, abs=0.01)
    assert not tape.body_touches.any()
    assert set(np.unique(tape.contacts.side)) == {0, 1}


@both
@each_robot
@pytest.mark.parametrize("ground", ["carpet_4mm", "grass_10mm", "grass_30mm"])
def test_a_robot_sinks_as_deep_in_every_engine(trial_of, robot, ground) -> None:
    """Its own lawn too: the seed draws the same ground for all."""
    found = []
    for engine in INSTALLED:
        tape, trial = standing(trial_of(robot, ground, engine), 0.3)
        found.append([lowest(tape, trial.robot, side)[-50:].mean() for side in range(2)])
    np.testing.assert_allclose(found[0], found[1], atol=1e-4)


@both
@each_robot
def test_a_seed_is_the_same_replicate_in_every_engine(trial_of, robot) -> None:
    spread = Spread(tilt=0.01, position=0.005)
    starts = {}
    for engine in INSTALLED:
        for seed in (1, 2):
            trial = replace(trial_of(robot, "hard_floor", engine, spread=spread), seed=seed)
            with engine_for(trial, trial.gait.feet(np.zeros(1))) as made:
                starts[engine, seed] = made.trunk
    first, second = INSTALLED
    for seed in (1, 2):
        np.testing.assert_allclose(starts[first, seed], starts[second, seed], atol=2e-5)
    assert np.abs(starts[first, 1][:7] - starts[first, 2][:7]).max() > 1e-4


def sliding(engine: EngineName, spread: Spread, seed: int) -> float:
    """Friction that a sled meets on the hard floor."""
    ground = surface("hard_floor", friction=0.5)
    with Bench(
        ground, Sled(kind="flat"), gap=0.0, spread=spread, seed=seed, engine=engine
    ) as bench:
        bench.run(0.2)
        return float(np.mean([bench.pull(0.1) for _ in range(200)][100:])) / (3.5 * GRAVITY)


@both
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_seed_is_as_slippery_in_every_engine(seed: int) -> None:
    spread = replace(STILL, friction=0.4)
    met = [sliding(engine, spread, seed) for engine in INSTALLED]
    assert met[0] == pytest.approx(met[1], rel=0.02)
    assert met[0] != pytest.approx(0.5, rel=0.02)


@each_engine
@pytest.mark.parametrize("kind", ["studs", "flat"])
@pytest.mark.parametrize("name", GROUNDS)
def test_a_sole_that_is_pushed_by_less_than_its_friction_stays(name, kind, engine) -> None:
    ground = surface(name)
    push = 0.8 * ground.friction * 3.5 * GRAVITY
    with Bench(ground, Sled(kind=kind), gap=ground.height, engine=engine) as bench:
        bench.run(0.6)
        bench.run(0.3, (push, 0.0, 0.0))
        before = bench.engine.trunk[0]
        bench.run(0.2, (push, 0.0, 0.0))
        assert abs(bench.engine.trunk[0] - before) / 0.2 < 2e-3


@each_engine
@pytest.mark.parametrize("kind", ["studs", "flat"])
@pytest.mark.parametrize("name", ["hard_floor", "carpet_4mm", "webots_grass"])
def test_a_sole_that_is_pulled_over_the_ground_meets_its_friction(name, kind, engine) -> None:
    changes = {"toe_catch": 0.0} if name == "carpet_4mm" else {}
    ground = surface(name, **changes)
    with Bench(ground, Sled(kind=kind), gap=ground.height, engine=engine) as bench:
        bench.run(0.6)
        at_rest = bench.gap
        met = np.mean([bench.pull(0.2) for _ in range(300)][150:]) / (3.5 * GRAVITY)
        assert met == pytest.approx(ground.friction, rel=0.02)
        assert bench.gap == pytest.approx(at_rest, abs=1e-4)  # nor does it ride up


def limp(trial: Trial) -> Trial:
    """With servos that are too weak for anything."""
    servo = replace(trial.servos[0], stall_torque=0.01, torque_limit=0.05)
    return replace(trial, servos=(servo,) * len(trial.servos))


@each_engine
@pytest.mark.parametrize("robot", ["eros", "bioloid", "foreign"])
@pytest.mark.parametrize("ground", GROUNDS)
def test_a_limp_robot_gains_no_energy_from_what_it_falls_on(
    trial_of, robot, ground, engine
) -> None:
    trial = limp(trial_of(robot, ground, engine, spread=replace(STILL, tilt=0.05)))
    feet = trial.gait.feet(np.zeros(1))
    start = start_of(trial, feet)
    with dropped(trial, start, 0.3) as made:
        first = energy(trial.robot.tree, made.trunk[None], start.joints[None], 0 * start.joints)
        tape = drive(made, np.tile(start.targets, (600, 1)))
    found = energy(trial.robot.tree, tape.trunk, tape.joints[:, 0], tape.joints[:, 1])
    assert found.max() <= 1.001 * first[0]
    assert found[-1] < 0.6 * first[0]
    if ground == "hard_floor":  # which keeps none to give back
        assert np.diff(found).max() < 2e-3 * first[0]


def dropped(trial: Trial, start: Start, height: float) -> Engine:
    """The engine of a trial, its robot so many [m] above where it would stand.

    A pile lifts it to where that carries it, by 0.1 m at most.
    """
    lifted = start._replace(position=start.position + np.array([0.0, 0.0, height]))
    return engine_named(trial.engine.name)(
        trial.robot,
        trial.surface,
        trial.servos,
        start=lifted,
        settings=trial.engine,
        spread=trial.spread,
        seed=trial.seed,
    )


def energy(tree: Tree, trunk: np.ndarray, angles: np.ndarray, speeds: np.ndarray) -> np.ndarray:
    """Kinetic and potential energy of all links, in [J]. Shape (n,).

    Velocities of links are those of their poses a moment before and after.
    """
    moment = 1e-5
    spin, turned = trunk[:, 10:13], rotation_of(trunk[:, 3:7])
    offset = np.array(tree.links[0].centre)
    centre = trunk[:, 0:3] + turned @ offset
    poses = []
    for t in (-moment, moment):
        rotation = _turned(spin, t) @ turned
        at = centre + t * trunk[:, 7:10] - rotation @ offset
        poses.append(tree.poses(at, rotation, angles + t * speeds))
    before, after = poses
    total = np.zeros(len(trunk))
    for k, link in enumerate(tree.links):
        local = np.array(link.centre)
        a, b = (pose.position[:, k] + pose.rotation[:, k] @ local for pose in (before, after))
        velocity = (b - a) / (2.0 * moment)
        turn = np.swapaxes(before.rotation[:, k], 1, 2) @ after.rotation[:, k]
        rate = np.stack([turn[:, 2, 1], turn[:, 0, 2], turn[:, 1, 0]], axis=1) / (2.0 * moment)
        xx, yy, zz, xy, xz, yz = link.moments
        inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        total += 0.5 * link.mass * (velocity**2).sum(axis=1)
        total += 0.5 * np.einsum("ni,ij,nj->n", rate, inertia, rate)
        total += link.mass * GRAVITY * 0.5 * (a + b)[:, 2]
    return total


def _turned(spin: np.ndarray, t: float) -> np.ndarray:
    x, y, z = spin.T * t
    one = np.ones_like(x)
    return np.array([[one, -z, y], [z, one, -x], [-y, x, one]]).transpose(2, 0, 1)


def pieces(trial: Trial, cuts: Sequence[int]) -> Tape:
    """A walk in calls of so many ticks."""
    feet = trial.gait.feet(np.arange(sum(cuts)) * trial.engine.dt)
    targets = joint_commands(trial.robot, feet)
    hung = getattr(trial.robot, "gantry", "none") != "none"
    tape, ending, first = Tape(len(targets), targets.shape[1] + hung), endless(), 0
    with engine_for(trial, feet) as engine:
        for ticks in cuts:
            engine.advance(targets[first : first + ticks], tape, ending)
            first += ticks
    return tape


def bits(tape: Tape) -> list[bytes]:
    written = tape.points[: tape.contacts_used]
    arrays = (tape.trunk, tape.joints, tape.plough, tape.push, tape.body_touches, written)
    return [array.tobytes() for array in arrays]


@each_engine
@each_robot
def test_a_walk_is_the_same_in_one_call_and_in_many_and_when_run_again(
    trial_of, robot, engine
) -> None:
    trial = trial_of(robot, "grass_30mm", engine)
    whole = bits(pieces(trial, [120]))
    assert bits(pieces(trial, [120])) == whole
    assert bits(pieces(trial, [1] * 40 + [7] * 11 + [3])) == whole


@each_engine
@pytest.mark.parametrize("dt", [0.001, 0.003, 0.004])
def test_so_it_is_at_other_steps_of_time(trial_of, dt, engine) -> None:
    trial = trial_of("eros", "grass_10mm", engine)
    trial = replace(trial, engine=replace(trial.engine, dt=dt))
    whole = pieces(trial, [60])
    assert bits(pieces(trial, [1] * 60)) == bits(whole)
    limits = np.array([servo.largest_torque for servo in trial.servos])
    assert (np.abs(whole.joints[:, 2]) <= limits * (1.0 + 1e-6)).all()


COMPARED = ("pitch", "roll", "trunk_z")


@both
@pytest.mark.parametrize("ground", ["hard_floor", "grass_30mm"])
def test_a_step_is_much_alike_in_every_engine(trial_of, ground) -> None:
    """The first cycle of EROS' steps, before small differences have grown."""
    logs: list[TrialLog] = []
    for engine in INSTALLED:
        trial = trial_of("eros", ground, engine)
        logs.append(simulate(replace(trial, horizon=replace(trial.horizon, time=0.4))))
    instants = np.arange(len(logs[0])) * logs[0].header.dt
    begins = first_step(trial.gait.feet(instants)) * logs[0].header.dt
    rows = slice(int(np.searchsorted(instants, begins + trial.gait.gait_period)))
    assert rows.stop < len(instants)
    first, second = ({name: log[name][rows] for name in COMPARED} for log in logs)
    assert np.abs(first["pitch"] - second["pitch"]).max() < 0.01
    assert np.abs(first["roll"] - second["roll"]).max() < 0.01
    assert np.abs(first["trunk_z"] - second["trunk_z"]).max() < 1e-3
