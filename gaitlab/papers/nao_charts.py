"""The NAO study's charts 1 to 7 as simulated: its normalised ZMP, setting by setting."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from gaitlab.log import TrialLog
from gaitlab.log.sensing import READING, load_index_signal, normalised_zmp_signal
from gaitlab.papers.nao_sweeps import NaoSweep, Setting, settings, sweeps
from gaitlab.papers.page import Picture
from gaitlab.render.figure_style import BLUE, FAINT, VERMILLION, new_figure, save, style
from gaitlab.store import Store

SHOWN_SEED, SHOWN_CYCLES = 0, 2  # of which the charts are drawn


def pictures(store: Path) -> list[Picture]:
    """Charts 1 to 7 of the paper as far as the store has walks of a cycle or more for them."""
    drawn: list[Picture] = []
    walks = [
        {s.value: log for s in settings(sweep, store) if (log := _shown_log(s, store)) is not None}
        for sweep in sweeps()
    ]
    for number, (sweep, logs) in enumerate(zip(sweeps(), walks, strict=True)):
        for axis in range(2) if logs else ():
            drawn.append(_chart(2 * number + axis + 1, sweep, logs, axis))
    final = [log for value, log in walks[0].items() if value == sweeps()[0].chosen]
    return [*drawn, *map(_last_chart, final)]


def _chart(number: int, sweep: NaoSweep, logs: Mapping[float, TrialLog], axis: int) -> Picture:
    caption = (
        f"Chart {number} of the paper, simulated: normalised {'XY'[axis]} of the ZMP for five "
        f"values of the {sweep.title} {sweep.symbol} in [{sweep.unit}], seed {SHOWN_SEED}, the "
        f"last {SHOWN_CYCLES} measured cycles. Lines at 1 and -1; red dots lie beyond the axis."
    )

    def draw(folder: Path, name: str) -> object:
        signals = [_signal(f"{sweep.symbol} = {value:g}", log, axis) for value, log in logs.items()]
        title = f"Chart {number}, {sweep.title} in [{sweep.unit}]"
        return _write(signals, folder, name, title, f"normalised {'XY'[axis]} of the ZMP [-]")

    return Picture(name=f"chart_{number}", caption=caption, draw=draw)


def _last_chart(final: TrialLog) -> Picture:
    caption = (
        "Chart 7 of the paper, simulated: normalised X and Y of the ZMP at the final setting, and "
        f"below them the load index, which never leaves its bounds; seed {SHOWN_SEED}."
    )
    return Picture(name="chart_7", caption=caption, draw=partial(_draw_last, final))


def _draw_last(final: TrialLog, folder: Path, name: str) -> object:
    x, y = (_signal("XY"[axis], final, axis) for axis in range(2))
    load = replace(x, label="load", value=load_index_signal(final, _shown_rows(final)))
    signals = [x, y, load]
    return _write(
        signals, folder, name, "Chart 7, final setting", "normalised ZMP and load index [-]"
    )


def _write(signals: Sequence[Signal], folder: Path, name: str, title: str, quantity: str) -> object:
    return write_signals(
        signals, folder, name, title=title, quantity=quantity, bounds=(-1.0, 1.0), shown=(-3.0, 3.0)
    )


def _shown_log(setting: Setting, store: Path) -> TrialLog | None:
    """Log of the seed that is shown; None if it fell before a cycle was complete."""
    trial = setting.trials.get(SHOWN_SEED)
    log = Store(store).log(str(trial["trial_id"])) if trial else None
    return log if log is not None and log.measured_cycles else None


def _shown_rows(log: TrialLog) -> slice:
    cycles = log.measured_cycles[-SHOWN_CYCLES:]
    return slice(cycles[0].start, cycles[-1].stop)


def _signal(label: str, log: TrialLog, axis: int) -> Signal:
    rows = _shown_rows(log)
    value = normalised_zmp_signal(log, rows)[:, axis]
    start = rows.start * log.header.dt - log.header.startup_time
    return Signal(label=label, time=start + (np.arange(len(value)) + 0.5) * READING, value=value)


@dataclass(frozen=True, kw_only=True, eq=False)
class Signal:
    """One panel.

    Attributes:
        label: What is special about this walk.
        time: In [s]. Shape (n,).
        value: NaN where it is not defined. Shape (n,).
    """

    label: str
    time: np.ndarray
    value: np.ndarray


def write_signals(
    signals: Sequence[Signal],
    folder: Path,
    name: str,
    *,
    title: str,
    quantity: str,
    bounds: tuple[float, float],
    shown: tuple[float, float],
) -> Path:
    """Draw signals and save them; the same signals give the same bytes.

    Args:
        signals: One a panel, from the top.
        folder: Where it goes.
        name: Name of the file, without ending.
        title: Title of the figure.
        quantity: What is drawn, with its unit.
        bounds: Two levels that are marked in every panel.
        shown: Lowest and highest value shown; what lies beyond is drawn on the edge in red.
    """
    with style():
        figure = new_figure(height=0.8 + 0.85 * len(signals))
        axes = figure.subplots(len(signals), 1, sharex=True, sharey=True, squeeze=False).ravel()
        for axis, signal in zip(axes, signals, strict=True):
            for level in bounds:
                axis.axhline(level, color=FAINT, linewidth=0.8)
            axis.plot(signal.time, np.clip(signal.value, *shown), color=BLUE, linewidth=0.9)
            beyond = (signal.value < shown[0]) | (signal.value > shown[1])
            edge = np.clip(signal.value[beyond], *shown)
            axis.plot(signal.time[beyond], edge, ".", color=VERMILLION, markersize=3.0)
            axis.set_ylabel(signal.label, rotation=0, ha="right", va="center")
            axis.set_ylim(1.05 * shown[0], 1.05 * shown[1])
        axes[-1].set_xlabel("time since walking at full amplitude [s]")
        figure.suptitle(f"{title}: {quantity}", x=0.01, ha="left", fontsize=10.0, weight="bold")
    return save(figure, folder, name)
