"""How honest is the time left? The trials of a store, run again on paper with their own wall times.

python benchmarks/forecast.py [STORE] [EXPERIMENT ...]
"""

from __future__ import annotations

import sys
from pathlib import Path

from gaitlab.experiment import load_experiment
from gaitlab.experiment.plan import duration, plan
from gaitlab.running.forecast import Forecast
from gaitlab.running.sweep import _kind
from gaitlab.store import Store

WORKERS = 2
LOOKS = (0.05, 0.1, 0.25, 0.5, 0.75, 0.9)  # share of the run's time at which the forecast is read
EXPERIMENTS = ("eros_table7", "nao_period", "all_robots")


def forecasts(store: Store, name: str) -> tuple[float, dict[float, float]]:
    """Time of a whole run in [s], and what the forecast said of it at each look, as a ratio."""
    found = store.states()
    trials = []
    for _, item in plan(load_experiment(name)).rounds():
        if item.trial.id in found:
            spent = float(store.record(item.trial.id).provenance["wall_time"])
            kind = _kind(item)
            length = duration(item.trial.gait, item.trial.horizon)
            trials.append((item.trial.id, kind, length, spent))
    forecast = Forecast(workers=WORKERS)
    for _, kind, length, _ in trials:
        forecast.expect(kind, length)
    said, total = _run(forecast, trials)
    ratios = {}
    for look in LOOKS:
        left = next((left for now, left in said if now >= look * total and left), None)
        now = next(now for now, left in said if now >= look * total)
        ratios[look] = left / (total - now) if left and total > now else float("nan")
    return total, ratios


def _run(forecast: Forecast, trials: list) -> tuple[list[tuple[float, float | None]], float]:
    """Every worker takes the next trial as soon as it is free."""
    running: list[tuple[float, str]] = []
    said, now = [], 0.0
    waiting = iter(trials)
    while True:
        while len(running) < WORKERS and (following := next(waiting, None)) is not None:
            trial_id, kind, length, spent = following
            forecast.start(trial_id, kind, length, now)
            running.append((now + spent, trial_id))
        if not running:
            return said, now
        now, trial_id = min(running)
        running.remove((now, trial_id))
        forecast.end(trial_id, now)
        said.append((now, forecast.time_left(now)))


def main() -> None:
    store, *names = sys.argv[1:] or ["data"]
    head = " | ".join(f"at {look:.0%}" for look in LOOKS)
    print(f"forecast / truth\n\n| experiment | whole run | {head} |\n|{'---|' * (len(LOOKS) + 2)}")
    for name in names or EXPERIMENTS:
        total, ratios = forecasts(Store(Path(store)), name)
        row = " | ".join(f"{ratio:.2f}" for ratio in ratios.values())
        print(f"| {name} | {total:.0f} s | {row} |")


if __name__ == "__main__":
    main()
