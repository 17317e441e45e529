"""Results and logs of a small experiment, made by hand, for the tests of the report."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cache

import numpy as np
import pandas as pd

from gaitlab.experiment.reference import ReferenceTable, load_reference
from gaitlab.log import LogHeader, TrialLog
from gaitlab.log.columns import columns
from gaitlab.model import Box, Joint, Link, Tree
from gaitlab.model.gait import FeetPoses
from gaitlab.model.soles import Sole
from gaitlab.report.results import Results
from gaitlab.report.variants import PLAIN, Variant, find_variants
from gaitlab.simulation.trial import Names, Plugin, Trial
from gaitlab.surfaces import TuftedPile

SURFACES = ("grass_50mm", "grass_30mm", "grass_10mm", "carpet_4mm")
STEPS = (0.0, 0.04, 0.08, -0.04)
GRASS = TuftedPile(
    friction=0.4,
    height=0.05,
    modulus=5e8,
    spacing=0.01,
    yarn=1.1e-3,
    blades=16,
    blade_width=1.2e-3,
    blade_thickness=125e-6,
)
SOLE = Sole(length=0.12, width=0.08, heel=0.05, height=0.03, kind="flat")
JOINTS = ("left_knee", "right_knee")


def walk_log(
    *,
    amplitude: float = 0.1,
    fall_at: float | None = None,
    seed: int = 0,
    joints: tuple[str, ...] = JOINTS,
) -> TrialLog:
    """Pitch swings with an amplitude in [rad]; at `fall_at` in [s] the robot tips over forward."""
    dt, end = 0.01, 6.0 if fall_at is None else fall_at + 0.5
    time = np.arange(1, round(end / dt) + 1) * dt
    arrays = {c.name: np.zeros(len(time), dtype=c.dtype) for c in columns(joints)}
    walking = time - 1.0
    arrays["time"] = time
    arrays["gait_phase"] = np.where(walking > 0, (walking / 0.8) % 1.0, np.nan)
    arrays["step_index"] = np.where(walking > 0, np.floor(walking / 0.4), -1)
    noise = 0.01 * np.random.default_rng(seed).standard_normal(len(time))
    arrays["pitch"] = amplitude * np.sin(2 * np.pi * walking / 0.8) + noise
    arrays["trunk_qw"] = np.ones(len(time))
    arrays["trunk_x"], arrays["trunk_z"] = 0.1 * np.clip(walking, 0, None), np.full(len(time), 0.3)
    if fall_at is not None:
        falling = np.clip((time - fall_at) / 0.3, 0.0, 1.0)
        arrays["pitch"] = arrays["pitch"] + 1.4 * falling**2
        arrays["fall_cause"] = (time >= fall_at + 0.3).astype(int)
    header = LogHeader(
        joints=joints,
        dt=dt,
        mass=3.5,
        standing_height=0.3,
        startup_time=1.0,
        gait_period=0.8,
        step_length=0.04,
        horizon_time=5.0,
        pile_height=0.05,
        sole_length=0.125,
        sole_width=0.08,
        torque_limits=(3.0,) * len(joints),
    )
    return TrialLog(header=header, arrays=arrays)


def trial(
    row: float, surface: str, heel: str, seed: int, *, state: str = "DONE", up: bool = True
) -> dict[str, object]:
    """One row of the store's table."""
    name = f"{heel}-{surface}-{row}-{seed}"
    done = state == "DONE"
    return {
        "trial_id": name,
        "experiment": "toy",
        "surface": surface,
        "seed": seed,
        "state": state,
        "reason": "" if done else "left_leg at tick 3: reach 0.23 m, at most 0.21 m",
        "gait.step_length": row,
        "gait.heel_strike": heel,
        "gait.landing_deceleration": "none" if heel == "none" else "log_tail",
        "stable": up if done else None,
        "stable_strict": up and row != 0.04 if done else None,
        "fell": not up if done else None,
        "fall_direction": None if up or not done else "forward",
        "fall_phase": 0.3 if done and not up else np.nan,
        "time_to_fall": 2.0 + 0.1 * seed if done and not up else np.nan,
        "distance": 0.1 * seed + abs(row) if done else np.nan,
        "pitch_amplitude": 0.1 if done else np.nan,
        "walking_speed": 0.05 if done else np.nan,
    }


def toy_trials(seeds: int = 4) -> list[dict[str, object]]:
    """Plain falls on high grass and long steps; with heel strike only the longest step falls."""
    trials = []
    for heel in ("none", "add"):
        for surface in SURFACES:
            for row in STEPS:
                for seed in range(seeds):
                    soft = surface in ("grass_50mm", "grass_30mm")
                    up = abs(row) < (0.02 if soft else 0.08) if heel == "none" else row < 0.08
                    trials.append(
                        trial(row, surface, heel, seed, up=up or (seed == 0 and row < 0.08))
                    )
    return trials


def toy_log(name: str) -> TrialLog:
    """Log of a toy trial: plain walks fall."""
    heel, *_, seed = name.split("-")
    fall_at = 3.0 + 0.2 * int(seed) if heel == "none" else None
    return walk_log(amplitude=0.3 if heel == "none" else 0.1, fall_at=fall_at, seed=int(seed))


def _table(variant: Variant, compare: bool) -> ReferenceTable | None:
    if not compare:
        return None
    return load_reference("eros_table7" if variant.label == PLAIN else "eros_table8")


def toy_tree() -> Tree:
    """A trunk on two legs with a knee each, feet as the last links."""
    trunk = Link(name="trunk", parent=None, origin=(0, 0, 0), joint=None, mass=1.0, box=_box(0.1))
    links = [trunk]
    for side, name in ((1.0, "left"), (-1.0, "right")):
        knee = Joint(name=f"{name}_knee", axis="y", lower=-1.0, upper=2.0, servo="mx_64")
        box = Box(size=(0.12, 0.08, 0.02), centre=(0.01, 0.0, -0.02))
        origin = (0.0, 0.05 * side, -0.2)
        foot = Link(
            name=f"{name}_foot", parent="trunk", origin=origin, joint=knee, mass=0.1, box=box
        )
        links.append(foot)
    return Tree(tuple(links))


def _box(edge: float) -> Box:
    return Box(size=(edge, edge, edge), centre=(0.0, 0.0, 0.0))


@dataclass(frozen=True)
class ToyRobot:
    name: str = "toy"
    feet: tuple[str, str] = ("left_foot", "right_foot")
    sole: Sole = SOLE
    tree: Tree = field(default_factory=toy_tree)

    def joint_targets(self, feet: FeetPoses) -> np.ndarray:
        return np.zeros((len(feet.position), 2))

    def hip_offset(self) -> float:
        return 0.0


@dataclass(frozen=True)
class ToyGait:
    step_length: float = 0.04
    hip_height: float = 0.2
    gait_period: float = 0.8
    startup_time: float = 1.0

    def feet(self, t: np.ndarray) -> FeetPoses:
        """Feet in turn in the air, at the places they stand on."""
        n, turns = len(t), (t - self.startup_time) / self.gait_period
        left = (turns > 0.0) & (turns % 1.0 < 0.5)
        return FeetPoses(
            position=np.zeros((n, 2, 3)),
            heading=np.zeros((n, 2)),
            trunk_pitch=np.zeros(n),
            ankle_pitch=np.zeros((n, 2)),
            knee_only=np.zeros((n, 2)),
            swing=np.stack([left, (turns > 0.0) & ~left], axis=-1),
            phase=np.where(turns > 0.0, turns % 1.0, np.nan),
            step_index=np.floor(2.0 * np.maximum(turns, -0.5)).astype(int),
        )


@cache
def toy_trial(name: str) -> Trial:
    """A trial whose robot has the joints of the toy logs, on the ground that the name tells."""
    height = 0.05 if "50mm" in name else 0.03
    names = Names(robot="toy", gait="toy", surface=name.split("-")[1])
    code = Plugin(name="toy", digest=None)
    return Trial(
        robot=ToyRobot(),
        gait=ToyGait(),
        surface=replace(GRASS, height=height),
        servos=(),
        seed=0,
        names=names,
        robot_code=code,
        gait_code=code,
    )


def results_of(
    trials: Sequence[dict[str, object]],
    *,
    paths: Sequence[str] = ("gait.heel_strike", "gait.landing_deceleration"),
    compare: bool = True,
    rows: str = "gait.step_length",
    columns: str = "surface",
    log: Callable[[str], TrialLog] = toy_log,
) -> Results:
    """Results as a store would give them."""
    frame = pd.DataFrame(list(trials))
    variants, labels = find_variants(frame, paths)
    return Results(
        title="Toy: does heel strike help?",
        question="A question.",
        rows=rows,
        columns=columns,
        variants=tuple(replace(v, compare=_table(v, compare)) for v in variants),
        reading="foot_travel",
        trials=frame.assign(variant=labels),
        log=log,
        trial=toy_trial,
        units={"gait.step_length": "m"},
    )
