"""Where a search finds no walk it says what the nearest one was stopped by, in numbers."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gaitlab.experiment import load_experiment
from gaitlab.model.stance import stance_of
from gaitlab.search.candidates import History
from gaitlab.search.obstacles import obstacles
from gaitlab.search.search import optimize
from gaitlab.store import Store

STUDY = """\
robot: eros
gait: walk
surfaces: [hard_floor]
seeds: 1
horizon: {time: 1.5, cycles: 100, distance: 100}
study:
  sampler: random
  trials: 2
  batch: 2
  search: {gait.step_height: {low: 0.01, high: 0.02}}
  objectives: [{maximize: distance_before_fall}]
  constraints: [stable >= 1]
"""


def searched(folder: Path, *settings: str) -> tuple[History, Store]:
    file, store = folder / "search.yaml", Store(folder / "data")
    file.write_text(STUDY)
    result = optimize(load_experiment(file, settings), store, jobs=0)
    return result.history, store


def test_a_servo_that_is_too_weak_is_named_with_its_limit(tmp_path: Path) -> None:
    history, store = searched(tmp_path, "servo.stall_torque=0.5")
    falls, servos = obstacles(history, store)
    (trial_id, *_) = history.nearest_misses(1)[0].trial_ids
    log = store.log(trial_id)
    torque = np.abs(log.joint_table("torque"))[: log.fall_index]
    limits = np.array(log.header.torque_limits)
    share = (torque >= 0.99 * limits).mean(axis=0)
    worst = log.header.joints[int(np.argmax(share))]
    assert worst in servos
    assert f"{limits[int(np.argmax(share))]:.3g} N m" in servos
    assert f"{100.0 * share.max():.0f} %" in servos
    com = stance_of(history.experiment.parts.robot).com_height
    assert f"{1e3 * com:.0f} mm" in falls


def test_a_search_that_found_a_walk_was_stopped_by_nothing(tmp_path: Path) -> None:
    history, store = searched(tmp_path)
    assert history.front
    assert obstacles(history, store) == []


@pytest.mark.parametrize("candidates", [(), None])
def test_what_never_walked_says_nothing(tmp_path: Path, candidates) -> None:
    history, store = searched(tmp_path, "servo.stall_torque=0.5")
    if candidates is None:
        candidates = tuple(replace(c, trial_ids=()) for c in history.candidates)
    assert obstacles(History(experiment=history.experiment, candidates=candidates), store) == []
