"""Charts 1 to 7 of the NAO study, from simulated walks."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path

import numpy as np

from gaitlab.log import TrialLog
from gaitlab.papers._nao_sweeps import Setting, Sweep, settings, sweeps
from gaitlab.papers.page import Picture
from gaitlab.report.signals import Signal, write_signals
from gaitlab.sensing import READING, load_index_signal, normalised_zmp_signal
from gaitlab.store import Store

SHOWN_SEED, SHOWN_CYCLES = 0, 2  # of which the charts are drawn


def pictures(store: Path) -> list[Picture]:
    """Charts 1 to 7 of the paper as far as the store has their trials."""
    drawn: list[Picture] = []
    for number, sweep in enumerate(sweeps()):
        found = settings(sweep, store)
        for axis in range(2) if found else ():
            drawn.append(_chart(2 * number + axis + 1, sweep, found, axis, store))
    first = sweeps()[0]
    final = next((s for s in settings(first, store) if s.value == first.chosen), None)
    return [*drawn, _last_chart(final, store)] if final else drawn


def _chart(number: int, sweep: Sweep, found: Sequence[Setting], axis: int, store: Path) -> Picture:
    caption = (
        f"Chart {number} of the paper, simulated: normalised {'XY'[axis]} of the ZMP for five "
        f"values of the {sweep.title} {sweep.symbol} in [{sweep.unit}], seed {SHOWN_SEED}, the "
        f"last {SHOWN_CYCLES} measured cycles. Lines at 1 and -1; red dots lie beyond the axis."
    )

    def draw(folder: Path, name: str) -> object:
        logs = ((f"{sweep.symbol} = {s.value:g}", _shown_log(s, store)) for s in found)
        signals = [_signal(label, log, axis) for label, log in logs if log is not None]
        title = f"Chart {number}, {sweep.title} in [{sweep.unit}]"
        return _write(signals, folder, name, title, f"normalised {'XY'[axis]} of the ZMP [-]")

    return Picture(name=f"chart_{number}", caption=caption, draw=draw)


def _last_chart(final: Setting, store: Path) -> Picture:
    caption = (
        "Chart 7 of the paper, simulated: normalised X and Y of the ZMP at the final setting, and "
        f"below them the load index, which never leaves its bounds; seed {SHOWN_SEED}."
    )
    return Picture(name="chart_7", caption=caption, draw=partial(_draw_last, final, store))


def _draw_last(final: Setting, store: Path, folder: Path, name: str) -> object:
    log = _shown_log(final, store)
    if log is None:
        return None
    rows = _shown_rows(log)
    time = _signal("", log, 0).time
    load = Signal(label="load", time=time, value=load_index_signal(log, rows))
    signals = [_signal("X", log, 0), _signal("Y", log, 1), load]
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
