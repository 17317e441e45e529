"""What stands in the way of a walk that a search did not find, in numbers of the nearest miss.

A robot falls where its support is narrow for the height of its centre of mass, or where a servo
has no more torque to give. Which of the two it was is read from the logs of its trials.
"""

from __future__ import annotations

from collections import Counter
from contextlib import suppress

import numpy as np

from gaitlab.errors import GaitlabError
from gaitlab.log import TrialLog
from gaitlab.metrics.stability import fall_direction
from gaitlab.model import Robot
from gaitlab.model.stance import stance_of
from gaitlab.search.candidates import Candidate, History
from gaitlab.store import Store

NEAR_LIMIT = 0.99  # of a servo's torque, from which on it has no more to give
OFTEN = 0.05  # share of the time that says that a servo is too weak


def obstacles(history: History, store: Store) -> list[str]:
    """A line for each thing that the nearest miss of a search was stopped by; none if it was not.

    Args:
        history: A search in which no candidate is allowed.
        store: Where its trials are.
    """
    walked = [candidate for candidate in history.nearest_misses(1) if candidate.trial_ids]
    if not walked:
        return []
    (nearest,) = walked
    logs = [log for trial_id in nearest.trial_ids if (log := _log(store, trial_id))]
    fallen = [log for log in logs if log.fall_index is not None]
    if not fallen:
        return []
    robot = history.experiment.parts.robot
    return [_falls(nearest, len(logs), fallen, robot), _servos(fallen)]


def _log(store: Store, trial_id: str) -> TrialLog | None:
    """Log of a trial; None if it never ran, or if the store has it no more."""
    with suppress(GaitlabError):
        return store.log(trial_id)
    return None


def _falls(nearest: Candidate, walked: int, fallen: list[TrialLog], robot: Robot) -> str:
    """Which way the robot falls, and what it stands on."""
    way, count = Counter(str(fall_direction(log)) for log in fallen).most_common(1)[0]
    after = float(np.median([log.walked_time for log in fallen]))
    line = (
        f"Candidate {nearest.number} falls with {len(fallen)} of {walked} seeds, {count} of them "
        f"{way}, after {after:.1f} s of walking"
    )
    with suppress(GaitlabError):
        stance = stance_of(robot)
        sideways = way in ("left", "right")
        extent = robot.sole.width if sideways else robot.sole.length
        line += (
            f": its soles are {1e3 * extent:.0f} mm {'wide' if sideways else 'long'} and its "
            f"centre of mass is {1e3 * stance.com_height:.0f} mm high"
        )
    return f"{line}."


def _servos(fallen: list[TrialLog]) -> str:
    """The servo that had least to spare."""
    log = max(fallen, key=lambda each: _shares(each).max(initial=0.0))
    shares, limits = _shares(log), np.array(log.header.torque_limits)
    if not len(shares):
        return "No servo had worked before the fall."
    worst = int(np.argmax(shares))
    joint, share = log.header.joints[worst], float(shares[worst])
    if share < OFTEN:
        return (
            f"Its servos have torque to spare: {joint} is at its limit most, "
            f"{100.0 * share:.1f} % of the time."
        )
    return (
        f"{joint} has no more to give {100.0 * share:.0f} % of the time: its servo ends at "
        f"{limits[worst]:.3g} N m. A stronger one, a lighter robot or a slower walk would help."
    )


def _shares(log: TrialLog) -> np.ndarray:
    """Share of the time up to the fall at which each joint's torque is at its limit. (joints,)."""
    limits = np.array(log.header.torque_limits)
    torque = np.abs(log.joint_table("torque"))[: log.fall_index]
    if not len(torque):
        return np.zeros(0)
    reached = (torque >= NEAR_LIMIT * np.maximum(limits, 1e-9)) & (limits > 0.0)
    shares: np.ndarray = reached.mean(axis=0)
    return shares
