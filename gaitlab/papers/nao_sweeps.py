"""The NAO study's sweeps as simulated: what a store holds of them, and what that says.

The paper judges by eye whether its normalised ZMP "fluctuates". Here that is the total variation
of the load index, see the metric `load_index_fluctuation`, compared seed by seed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from math import isfinite
from pathlib import Path

import numpy as np

from gaitlab.errors import UnknownName
from gaitlab.papers.nao_effects import final_gait, straight
from gaitlab.papers.page import Table
from gaitlab.papers.printed import rows as published
from gaitlab.robots.nao import Robot
from gaitlab.statistics import (
    Contrast,
    Side,
    contrast,
    judged,
    match,
    mean_interval,
    runs_of,
    wilson,
)
from gaitlab.store import Store

FLUCTUATION = "load_index_fluctuation"

Trials = Sequence[Mapping[str, object]]


@dataclass(frozen=True, kw_only=True)
class NaoSweep:
    """One of the paper's experiments, or ours over the period.

    Attributes:
        experiment: Name of the shipped experiment.
        title: What it varies.
        symbol: The paper's symbol.
        unit: Unit in which it is shown.
        path: Dotted path of our parameter.
        shown: Value of the symbol in that unit from our parameter.
        chosen: Value that the paper ends with, in that unit; None where it gives none.
        table: Its table in `gaitlab/papers/printed`, None for ours.
        column: Column of that table.
    """

    experiment: str
    title: str
    symbol: str
    unit: str
    path: str
    shown: Callable[[float], float]
    chosen: float | None
    table: str | None = None
    column: str = ""

    def values(self, trials: Trials) -> list[float]:
        """Values to show, in the order of the paper's table, or of the experiment."""
        if self.table is None:
            return sorted({self.value_of(trial) for trial in trials})
        return [round(1000.0 * float(row[self.column]), 6) for row in published(self.table)]

    def value_of(self, trial: Mapping[str, object]) -> float:
        """Value of one trial, in the unit that is shown."""
        return round(self.shown(float(str(trial[self.path]))), 6)


_PAPER = (
    ("nao_bending_height", "bending height", "h", "gait.hip_height", "Bending Height (m)", 3),
    ("nao_frontal_shift", "frontal shift", "F", "gait.lateral_sway", "Frontal Shift (m)", 4),
    ("nao_step_length", "step length", "s", "gait.step_length", "Step length (m)", 5),
)
_IN_MM: Mapping[str, Callable[[float], float]] = {
    "h": lambda hip_height: 1000.0 * (straight(Robot()) - hip_height),
    "F": lambda lateral_sway: 1000.0 * lateral_sway,
    "s": lambda step_length: 2000.0 * step_length,
}


@cache
def sweeps() -> tuple[NaoSweep, ...]:
    """The paper's three experiments."""
    final = published("nao_table6")[0]
    return tuple(
        NaoSweep(
            experiment=experiment,
            title=title,
            symbol=symbol,
            unit="mm",
            path=path,
            shown=_IN_MM[symbol],
            chosen=round(1000.0 * float(final[column]), 6),
            table=f"nao_table{number}",
            column=column,
        )
        for experiment, title, symbol, path, column, number in _PAPER
    )


PERIOD = NaoSweep(
    experiment="nao_period",
    title="half period",
    symbol="T",
    unit="s",
    path="gait.gait_period",
    shown=lambda gait_period: gait_period / 2.0,
    chosen=None,
)


@dataclass(frozen=True, kw_only=True)
class Setting:
    """The replicates of one setting.

    Attributes:
        value: Value of the sweep's symbol.
        trials: Finished trials by seed.
    """

    value: float
    trials: Mapping[int, Mapping[str, object]]

    @property
    def walked(self) -> int:
        """Trials that stayed on their feet and covered the ground."""
        return sum(bool(trial["stable_strict"]) for trial in self.trials.values())

    @property
    def share(self) -> float:
        """Share of the trials that walked."""
        return self.walked / len(self.trials)

    @property
    def open(self) -> bool:
        """Whether the interval of the share that walked holds one half."""
        low, high = wilson(self.walked, len(self.trials))
        return low <= 0.5 <= high

    def metric(self, name: str) -> dict[int, float]:
        """Finite values of a metric by seed."""
        found = {seed: float(str(trial[name])) for seed, trial in self.trials.items()}
        return {seed: value for seed, value in found.items() if isfinite(value)}


@dataclass(frozen=True, kw_only=True)
class Walked:
    """What an engine says of all sweeps.

    Attributes:
        engine: Its name, as a reader writes it.
        experiment: The experiment that holds all of its sweeps; None where each has its own.
        sweeps: By experiment of the sweep, every setting that was walked.
        gaps: Of each choice of the paper, by value of another setting: the choice's fluctuation
            less that one's. All of them, and those of the other engine, are judged together.
    """

    engine: str
    experiment: str | None
    sweeps: Mapping[str, list[Setting]]
    gaps: Mapping[tuple[str, float], Contrast] = field(default_factory=dict)

    def __getitem__(self, sweep: NaoSweep) -> list[Setting]:
        return self.sweeps[sweep.experiment]

    def run(self, sweep: NaoSweep) -> str:
        """Experiment that walks a sweep."""
        return self.experiment or sweep.experiment


ENGINES = (("MuJoCo", None), ("Bullet", "nao_confirmed"))


def walked(store: Path) -> list[Walked]:
    """What each engine says, the fast one first; settings that were never walked are left out."""
    found = [
        Walked(
            engine=engine,
            experiment=experiment,
            sweeps={
                sweep.experiment: settings(sweep, store, experiment)
                for sweep in (*sweeps(), PERIOD)
            },
        )
        for engine, experiment in ENGINES
    ]
    return compared(found)


def compared(found: Sequence[Walked]) -> list[Walked]:
    """The same with the choices compared, all comparisons of all engines as one family."""
    places = [
        (number, (sweep.experiment, other.value), _gap(other, chosen))
        for number, one in enumerate(found)
        for sweep in sweeps()
        for chosen in one[sweep]
        if chosen.value == sweep.chosen
        for other in one[sweep]
        if other is not chosen
    ]
    verdicts = judged([gap for _, _, gap in places])
    gaps: list[dict[tuple[str, float], Contrast]] = [{} for _ in found]
    for (number, key, _), gap in zip(places, verdicts, strict=True):
        gaps[number][key] = gap
    return [replace(one, gaps=its) for one, its in zip(found, gaps, strict=True)]


def settings(sweep: NaoSweep, store: Path, experiment: str | None = None) -> list[Setting]:
    """Every setting of a sweep with its finished trials; none for a sweep that was never run.

    Args:
        sweep: What is varied.
        store: Folder of the results.
        experiment: One that varies other things too, one at a time; only those trials count that
            have the others as they usually are. The sweep's own by default.
    """
    try:
        table = Store(store).table(experiment or sweep.experiment)
    except UnknownName:
        return []
    if table.empty:
        return []
    table = table[table["state"] == "DONE"]
    for other in (*sweeps(), PERIOD) if experiment else ():
        if other != sweep:
            table = table[np.isclose(table[other.path].astype(float), _usual(other))]
    grouped: dict[float, dict[int, Mapping[str, object]]] = {}
    for row in table.to_dict("records"):
        trial = {str(key): value for key, value in row.items()}
        grouped.setdefault(sweep.value_of(trial), {})[int(str(trial["seed"]))] = trial
    trials: Trials = [trial for each in grouped.values() for trial in each.values()]
    return [
        Setting(value=value, trials=grouped[value])
        for value in sweep.values(trials)
        if value in grouped
    ]


def _usual(sweep: NaoSweep) -> float:
    """Value of a sweep's parameter at the paper's final setting."""
    value: float = getattr(final_gait(), sweep.path.removeprefix("gait."))
    return value


def table(sweep: NaoSweep, one: Walked) -> Table:
    """What the simulation shows of each setting."""
    marked = {True: " (the paper's choice)", False: ""}
    header = [f"{sweep.symbol} [{sweep.unit}]", "walks", "share, 95 % interval"]
    header += ["fluctuation of the load", "roles changed again", "X beyond ±1"]
    header += ["ZMP clear of the edge", "roll ± [deg]"]
    body = [
        [f"{s.value:g}{marked[s.value == sweep.chosen]}", *_walked(s), *_measured(s)]
        for s in one[sweep]
    ]
    if sweep.chosen is not None:
        header.insert(4, "the choice less this")
        for row, s in zip(body, one[sweep], strict=True):
            row.insert(4, _gap_told(one.gaps.get((sweep.experiment, s.value))))
    number = f"Table {sweep.table[-1]}, " if sweep.table else ""
    title = f"{number}{sweep.title} {sweep.symbol}, in {one.engine}"
    text = f"`gaitlab run {one.run(sweep)}`"
    return Table(title=title, text=text, header=header, rows=body)


def _gap_told(gap: Contrast | None) -> str:
    """By how much the choice fluctuates more, in bold where that is told from nothing."""
    if gap is None or not isfinite(gap.interval.high - gap.interval.low):
        return "–"
    told = f"{gap.difference:+.2f} [{gap.interval.low:+.2f}, {gap.interval.high:+.2f}]"
    return f"**{told}**" if gap.verdict in ("better", "worse") else told


def _walked(setting: Setting) -> list[str]:
    n = len(setting.trials)
    low, high = wilson(setting.walked, n)
    return [f"{setting.walked} of {n}", f"{100.0 * low:.0f} to {100.0 * high:.0f} %"]


def _measured(setting: Setting) -> list[str]:
    roll = [np.degrees(value) for value in setting.metric("roll_amplitude").values()]
    return [
        _mean(list(setting.metric(FLUCTUATION).values()), 2),
        _mean(list(setting.metric("load_index_crossings").values()), 1),
        _mean(_percent(setting, "zmp_normalised_outside"), 1, " %"),
        _mean(_percent(setting, "zmp_inside_share"), 0, " %"),
        _mean(roll, 1),
    ]


def _percent(setting: Setting, metric: str) -> list[float]:
    return [100.0 * share for share in setting.metric(metric).values()]


def _mean(values: Sequence[float], digits: int, unit: str = "") -> str:
    if len(values) < 2:
        return "–"
    low, high = mean_interval(values)
    return f"{np.mean(values):.{digits}f}{unit} [{low:.{digits}f}, {high:.{digits}f}]"


def criterion(found: Sequence[Setting]) -> str:
    """How often the paper's index leaves its bounds in walks and in falls, as sentences."""
    trials = {str(trial["trial_id"]): trial for s in found for trial in s.trials.values()}
    beyond: dict[bool, list[float]] = {True: [], False: []}
    for trial in trials.values():
        beyond[bool(trial["fell"])].append(100.0 * float(str(trial["zmp_normalised_outside"])))
    if not beyond[True] or not beyond[False]:
        return ""
    walks, falls = (
        _mean([x for x in beyond[fell] if isfinite(x)], 1, " %") for fell in (False, True)
    )
    never = [sum(share == 0.0 for share in beyond[fell]) for fell in (False, True)]
    return (
        "The paper calls a robot stable if and only if its normalised ZMP lies in [-1, 1]. Here X "
        f"leaves that range in {walks} of the readings of the {len(beyond[False])} trials that "
        f"stay up, and in {falls} of those of the {len(beyond[True])} that fall, before they do. "
        f"By that criterion {never[0]} of the former and {never[1]} of the latter are stable."
    )


VERDICTS = (
    *("choice of the paper", "engine", "supported", "walks", "other settings walk"),
    *("load fluctuates by", "less than", "more than"),
)


def verdict(sweep: NaoSweep, one: Walked) -> list[str]:
    """Whether an engine supports the paper's choice, a row of `VERDICTS`; empty if not walked."""
    found = one[sweep]
    chosen = next((s for s in found if s.value == sweep.chosen), None)
    others = [s for s in found if s.value != sweep.chosen]
    if chosen is None or not others:
        return []
    gaps = [one.gaps[sweep.experiment, other.value] for other in others]
    better, worse = (sum(gap.verdict == word for gap in gaps) for word in ("better", "worse"))
    stands = chosen.share >= max(s.share for s in found)
    counts = list(dict.fromkeys(_walked(other)[0] for other in others))
    return [
        f"{sweep.symbol} = {sweep.chosen:g} {sweep.unit}",
        one.engine,
        "**yes**" if better == len(others) and stands else "no",
        "{} ({})".format(*_walked(chosen)),
        ", ".join(counts),
        _measured(chosen)[0],
        f"{better} of {len(others)}",
        f"{worse} of {len(others)}",
    ]


def doubts(found: Sequence[Walked]) -> str:
    """The settings whose share that walks has an interval that holds one half, as a sentence."""
    named = [
        f"{sweep.symbol} = {s.value:g} {sweep.unit} in {one.engine}"
        for one in found
        for sweep in (*sweeps(), PERIOD)
        for s in one[sweep]
        if s.open
    ]
    if not named:
        return "No share of walks has an interval that holds one half."
    return f"The interval of the share that walks holds one half at {', '.join(named)}."


def _gap(other: Setting, chosen: Setting) -> Contrast:
    """How the chosen setting's fluctuation differs from another's, in pairs of equal seed."""
    sides = [setting.metric(FLUCTUATION) for setting in (other, chosen)]
    found = match(*([((), seed) for seed in side] for side in sides))
    runs = [
        Side(
            values=np.array(list(side.values()))[rows],
            cells=found.cells[k],
            seeds=np.array(list(side))[rows],
        )
        for k, (side, rows) in enumerate(zip(sides, found.rows, strict=True))
    ]
    return contrast(FLUCTUATION, runs_of(*runs, paired=found.paired), "lower")
