"""What precedes a fall: the gait cycle in which a robot last stood well, beside another walk's.

A walk that falls is looked at in the gait cycle that ends where it last stood well, its partner of
equal step and seed in the same cycle; of two falls in that of the earlier one. What differs before
falls need not be their cause: walks picked because they fall look worse just then than others.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import cos, degrees, inf, isinf, nan, radians
from typing import Literal, NamedTuple

import numpy as np
import pandas as pd

from gaitlab.log import LogHeader, TrialLog
from gaitlab.log.columns import FEET, columns
from gaitlab.metrics.balance import pitch_amplitude, roll_amplitude, zmp_margin_min
from gaitlab.metrics.feet import peak_plough_force, toe_first_share
from gaitlab.report.falls import DIRECTIONS, quartiles
from gaitlab.report.markdown import escape, table
from gaitlab.report.results import Results
from gaitlab.report.scores import truth
from gaitlab.report.words import NOTHING, plural, surface_text
from gaitlab.simulation.trial import Trial
from gaitlab.statistics import Contrast, Side, contrast, judged, match, runs_of
from gaitlab.store import Store
from gaitlab.surfaces.tipping import settled, tipping_ratio

GOOD_MARGIN = 0.005  # m, ZMP inside the support polygon; the last millimetres are impact noise
GOOD_TILT = cos(radians(20.0))  # -, R33; walks that stay up hardly ever lean farther
READ = ("time", "zmp_margin", "trunk_qx", "trunk_qy", "fall_cause")  # columns that `stand` reads
PLACES = 6  # decimals of a cycle count; two windows that agree in them are one
LANDINGS = 2  # gait cycles; a swing that begins before a single one would not count as a landing
STANDING = 0.5  # s into a trial, at which it still stands
Axis = Literal["fore-aft", "sideways", "neither"]


class Stand(NamedTuple):
    """Until when a robot stood well.

    Attributes:
        row: Row of the log; -1 if it never did.
        cycles: Gait cycles since walking at full amplitude began; negative in the start-up.
        lead: Time from then to the fall, in [s]; NaN without one.
    """

    row: int
    cycles: float
    lead: float


def stand(header: LogHeader, arrays: Mapping[str, np.ndarray]) -> Stand:
    """The last instant before a fall at which the ZMP was well inside and the trunk upright.

    Well inside is `GOOD_MARGIN`, upright a tilt of up to 20 degrees. Without a fall it is the
    end of the log. Defined here.

    Args:
        header: Of the log.
        arrays: The columns `READ`. Shape (n,) each.
    """
    fallen = np.flatnonzero(arrays["fall_cause"])
    end = int(fallen[0]) if len(fallen) else len(arrays["time"]) - 1
    row = end
    if len(fallen):
        upright = 1.0 - 2.0 * (arrays["trunk_qx"] ** 2 + arrays["trunk_qy"] ** 2)
        good = (arrays["zmp_margin"] >= GOOD_MARGIN) & (upright >= GOOD_TILT)
        found = np.flatnonzero(good[: end + 1])
        row = int(found[-1]) if len(found) else -1
    cycles = ((row + 1) * header.dt - header.startup_time) / header.gait_period
    return Stand(row, cycles, (end - row) * header.dt if len(fallen) else nan)


def row_at(header: LogHeader, cycles: float) -> int:
    """Row of the log that ends so many gait cycles after the start-up."""
    return round((header.startup_time + cycles * header.gait_period) / header.dt) - 1


def first_axis(log: TrialLog, row: int) -> Axis:
    """In which axis the trunk first left what it had done in the gait cycle before a row.

    Fore-aft if the pitch left its range first, sideways if the roll did. Defined here.
    """
    start = max(0, row + 1 - round(log.header.gait_period / log.header.dt))
    pitch, roll = (_leaves(log[name], start, row + 1) for name in ("pitch", "roll"))
    if pitch == roll:
        return "neither"
    return "fore-aft" if pitch < roll else "sideways"


def _leaves(angle: np.ndarray, start: int, stop: int) -> float:
    """Rows after `stop` until an angle leaves its range over the rows before."""
    if start >= stop:
        return inf
    low, high = angle[start:stop].min(), angle[start:stop].max()
    beyond = np.flatnonzero((angle[stop:] < low) | (angle[stop:] > high))
    return float(beyond[0]) if len(beyond) else inf


class Piece(NamedTuple):
    """The end of a walk: its last gait cycle, and its last two, each as a log of its own."""

    cycle: TrialLog
    two: TrialLog


def piece_before(log: TrialLog, row: int) -> Piece | None:
    """The gait cycles that end in a row; None if the log does not hold a whole one."""
    period = round(log.header.gait_period / log.header.dt)
    stop = row + 1
    if stop < period or stop > len(log):
        return None
    two = _cut(log, max(0, stop - LANDINGS * period), stop)
    return Piece(_cut(log, stop - period, stop), two)


def _cut(log: TrialLog, start: int, stop: int) -> TrialLog:
    """Rows of a log as a log in which everything is walked."""
    arrays = {name: array[start:stop] for name, array in log.arrays.items()}
    arrays["time"] = log.header.dt * np.arange(1, stop - start + 1)
    arrays["fall_cause"] = np.zeros(stop - start)
    return TrialLog(header=replace(log.header, startup_time=0.0), arrays=arrays)


def stance_sink(piece: Piece) -> float:
    """Median depth of the centre of the only loaded sole below the top of the pile, in [m]."""
    log, foot = piece.cycle, _stance(piece.cycle)
    height = np.where(foot == 0, log["left_foot_z"], log["right_foot_z"])
    return _median(log.header.pile_height - height[foot >= 0])


def stance_pitch(piece: Piece) -> float:
    """Median pitch of the only loaded sole against the horizon, toe down positive, in [rad]."""
    log, foot = piece.cycle, _stance(piece.cycle)
    pitches = []
    for side in FEET:
        x, y, z, w = log.vector(f"{side}_foot_q", "xyzw").T
        pitches.append(np.arcsin(np.clip(2.0 * (w * y - x * z), -1.0, 1.0)))
    return _median(np.where(foot == 0, *pitches)[foot >= 0])


def lift(piece: Piece) -> float:
    """Mean over the feet of the largest height of the lowest corner over the pile, in [m]."""
    return float(np.mean(-piece.cycle.per_foot("sink").min(axis=0)))


def single_support(piece: Piece) -> float:
    """Share of the time in which one foot alone carries load."""
    return float(np.mean(_stance(piece.cycle) >= 0))


def _stance(log: TrialLog) -> np.ndarray:
    """The only loaded foot: 0 left, 1 right, -1 when it is not one. Shape (n,)."""
    support = log["support"]
    return np.where((support == 1) | (support == 2), support - 1, -1)


def zmp_ahead(log: TrialLog) -> np.ndarray:
    """ZMP ahead of the centre of the soles that carry load, along the trunk's heading, in [m].

    Of two loaded soles the middle between them. NaN in flight. Shape (n,).
    """
    loaded = log.per_foot("contact").astype(bool)
    centres = np.stack([log.vector(f"{side}_foot_", "xy") for side in FEET], axis=1)
    count = loaded.sum(axis=1)
    weights = loaded / np.maximum(count, 1)[:, None]
    offset = log.vector("zmp_", "xy") - (weights[:, :, None] * centres).sum(axis=1)
    ahead = offset[:, 0] * np.cos(log["yaw"]) + offset[:, 1] * np.sin(log["yaw"])
    return np.where(count > 0, ahead, np.nan)


def _median(values: np.ndarray) -> float:
    known = values[np.isfinite(values)]
    return float(np.median(known)) if len(known) else nan


class Measure(NamedTuple):
    """One quantity of a piece, in SI units, and how a table shows it."""

    name: str
    unit: str
    scale: float
    of: Callable[[Piece], float]


DEGREES, MM = degrees(1.0), 1000.0
MEASURES: dict[str, Measure] = {
    "toe_first": Measure("toe-first landings", "%", 100.0, lambda p: toe_first_share(p.two)),
    "plough": Measure("peak plough force", "N", 1.0, lambda p: peak_plough_force(p.cycle)),
    "sink": Measure("sink of the stance sole", "mm", MM, stance_sink),
    "lift": Measure("swing foot over the tips", "mm", MM, lift),
    "single": Measure("time on one foot", "%", 100.0, single_support),
    "margin_min": Measure("smallest ZMP margin", "mm", MM, lambda p: zmp_margin_min(p.cycle)),
    "ahead": Measure(
        "ZMP ahead of the soles' centre", "mm", MM, lambda p: _median(zmp_ahead(p.cycle))
    ),
    "lean": Measure("trunk's mean pitch", "°", DEGREES, lambda p: float(p.cycle["pitch"].mean())),
    "pitch": Measure("pitch amplitude", "°", DEGREES, lambda p: pitch_amplitude(p.cycle)),
    "roll": Measure("roll amplitude", "°", DEGREES, lambda p: roll_amplitude(p.cycle)),
    "tip": Measure("stance sole's pitch", "°", DEGREES, stance_pitch),
}


def measured(piece: Piece | None) -> dict[str, float]:
    """Every measure of a piece by its key; NaN without one."""
    return {key: nan if piece is None else item.of(piece) for key, item in MEASURES.items()}


def body_log(store: Store, trial_id: str) -> TrialLog:
    """The log of a trial without its joints: trunk, CoM, ZMP and feet.

    Raises:
        UnknownName: If the store does not hold it.
        StoreError: If its file is damaged, or the trial ended without a log.
    """
    part = store.log_part(trial_id, [column.name for column in columns(())])
    return TrialLog(header=replace(part.header, joints=(), torque_limits=()), arrays=part.arrays)


def last_stands(results: Results, store: Store, labels: Sequence[str]) -> pd.DataFrame:
    """Simulated walks of some variants with `cycles` and `lead` of `stand`, and a fall's `axis`."""
    done = results.done[results.done["variant"].isin(labels)]
    done = done.assign(fell=truth(done["fell"]))
    rows = []
    for trial_id, fell in zip(done["trial_id"], done["fell"], strict=True):
        until = stand(*store.log_part(trial_id, READ))
        axis = first_axis(body_log(store, trial_id), until.row) if fell else ""
        rows.append((round(until.cycles, PLACES), until.lead, axis))
    found = pd.DataFrame(rows, columns=["cycles", "lead", "axis"], index=done.index)
    return done.join(found)


class Pairs(NamedTuple):
    """Walks of equal step and seed, and the gait cycles after the start-up at which both end.

    Attributes:
        ids: Trials of the first and of the second side.
        cycles: Where the earlier of the two last stood well. Shape (pairs,).
        cells: Number of the step of each pair. Shape (pairs,).
        seeds: Its seed. Shape (pairs,).
    """

    ids: tuple[list[str], list[str]]
    cycles: np.ndarray
    cells: np.ndarray
    seeds: np.ndarray


def pairs_of(first: pd.DataFrame, second: pd.DataFrame, rows: str) -> Pairs:
    """Walks that agree in a column and the seed; none if no seed is shared.

    Args:
        first: As of `last_stands`, of one ground and variant.
        second: Likewise.
        rows: Column that makes a cell.
    """
    keys = [
        list(zip(side[rows], side["seed"].astype(int), strict=True)) for side in (first, second)
    ]
    found = match(*keys)
    rows_of = found.rows if found.paired else (found.rows[0][:0], found.rows[1][:0])
    one, two = (side.iloc[rows] for side, rows in zip((first, second), rows_of, strict=True))
    return Pairs(
        ids=(list(one["trial_id"]), list(two["trial_id"])),
        cycles=np.minimum(one["cycles"].to_numpy(float), two["cycles"].to_numpy(float)),
        cells=found.cells[0][: len(one)],
        seeds=one["seed"].to_numpy(int),
    )


def contrasts_of(store: Store, compared: Mapping[str, Pairs]) -> dict[str, dict[str, Contrast]]:
    """Every measure of every comparison, second less first, all judged together.

    Args:
        store: Where the logs are; each is read once.
        compared: By the name of a column.
    """
    windows: dict[str, dict[float, dict[str, float]]] = {}
    for pairs in compared.values():
        for side in pairs.ids:
            for trial_id, cycles in zip(side, pairs.cycles.tolist(), strict=True):
                windows.setdefault(trial_id, {})[cycles] = {}
    for trial_id, ends in windows.items():
        log = body_log(store, trial_id)
        for cycles in ends:
            ends[cycles] = measured(piece_before(log, row_at(log.header, cycles)))
    asked = [(name, key) for name in compared for key in MEASURES]
    told = judged([_contrast(key, compared[name], windows) for name, key in asked])
    made: dict[str, dict[str, Contrast]] = {name: {} for name in compared}
    for (name, key), item in zip(asked, told, strict=True):
        made[name][key] = item
    return made


def _contrast(
    key: str, pairs: Pairs, windows: Mapping[str, Mapping[float, Mapping[str, float]]]
) -> Contrast:
    first, second = (
        np.array([windows[i][c][key] for i, c in zip(side, pairs.cycles.tolist(), strict=True)])
        for side in pairs.ids
    )
    sides = (Side(values, pairs.cells, pairs.seeds) for values in (first, second))
    return contrast(key, runs_of(*sides, paired=True), "neither")


def contrast_table(found: Mapping[str, Mapping[str, Contrast]]) -> str:
    """One row a measure, one column a comparison; bold where the two can be told apart."""
    shown = {name: items for name, items in found.items() if any(c.n for c in items.values())}
    if not shown:
        return ""
    counts = {name: max(item.n for item in items.values()) for name, items in shown.items()}
    header = ["", *(f"{escape(name)}, {plural(n, 'pair')}" for name, n in counts.items())]
    rows = [
        [f"{item.name} [{item.unit}]", *(_gap(items[key], item) for items in shown.values())]
        for key, item in MEASURES.items()
    ]
    return table(header, rows, "l")


def _gap(item: Contrast, measure: Measure) -> str:
    if not item.n or isinf(item.interval.low):
        return NOTHING
    gap, *ends = (measure.scale * value for value in (item.difference, *item.interval))
    text = f"{gap:+.1f} [{ends[0]:.1f}, {ends[1]:.1f}]"
    return text if item.verdict == "cannot tell" else f"**{text}**"


def falls_table(done: pd.DataFrame, grounds: Iterable[str], labels: Sequence[str]) -> str:
    """Where the falls of each ground and variant went, and how they began.

    Args:
        done: As of `last_stands`.
        grounds: Names of grounds.
        labels: Variants.
    """
    header = ["", "variant", "falls", *DIRECTIONS, "before a full cycle"]
    header += ["first fore-aft", "first sideways", "from the last good stand [s]"]
    rows = []
    for ground in grounds:
        for label in labels:
            walks = done[(done["surface"] == ground) & (done["variant"] == label)]
            if len(walks):
                falls = walks[walks["fell"]]
                counted = [
                    *(falls["fall_direction"] == way for way in DIRECTIONS),
                    falls["cycles"] < 1.0,
                    *(falls["axis"] == axis for axis in ("fore-aft", "sideways")),
                ]
                counts = (str(int(flags.sum())) for flags in counted)
                falls_row = [f"{len(falls)} of {len(walks)}", *counts, quartiles(falls["lead"])]
                rows.append([escape(surface_text(ground)), escape(label), *falls_row])
    return table(header, rows, "ll") if rows else ""


@dataclass(frozen=True, kw_only=True)
class Firmness:
    """What a ground gives a robot that stands on one foot, by the law of its pile alone.

    Attributes:
        sink: Under the weight of the robot, in [m].
        stiffness: In [N/m], infinite on a floor.
        tipping: Moment of the settled sole against tipping over that of gravity on a stiff robot,
            fore-aft and sideways; below 1 it cannot stand.
    """

    sink: float
    stiffness: float
    tipping: tuple[float, float]


def firmness(trial: Trial, log: TrialLog) -> Firmness:
    """What a trial's ground gives its robot; the log says how high its CoM stands."""
    sole, weight, height = trial.robot.sole, log.header.weight, standing_height(log)
    pitch, roll = (
        tipping_ratio(
            trial.surface, sole, weight=weight, com_height=height, support=sole.kind, axis=axis
        )
        for axis in ("x", "y")
    )
    rest = settled(trial.surface, sole, weight)
    return Firmness(sink=rest.sink, stiffness=rest.stiffness, tipping=(pitch, roll))


def standing_height(log: TrialLog) -> float:
    """Height of the CoM over the soles as the robot stands, in [m]."""
    row = round(STANDING / log.header.dt)
    return float(log["com_z"][row] - log.per_foot("z")[row].mean())


def firmness_table(grounds: Mapping[str, Firmness], fell: Mapping[str, str], what: str) -> str:
    """One row a ground, the softest first, beside how many walks fell there.

    Args:
        grounds: By the name of the ground.
        fell: Falls of the walks there, as text, by the name of the ground.
        what: Whose walks.
    """
    rows = [
        [
            escape(surface_text(name)),
            f"{1000.0 * ground.sink:.1f}",
            *(f"{v:.3g}" for v in (ground.stiffness / 1000.0, *ground.tipping)),
            fell.get(name, ""),
        ]
        for name, ground in sorted(grounds.items(), key=lambda item: item[1].stiffness)
    ]
    header = ["", "sink on one foot [mm]", "stiffness [kN/m]", "holds fore-aft", "holds sideways"]
    return table([*header, f"falls of {escape(what)}"], rows, "lr") if rows else ""
