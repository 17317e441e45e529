"""A policy at work on one robot: what it feels becomes an input, its output joint targets."""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, pi, sin

import numpy as np

from gaitlab.errors import WrongValue
from gaitlab.model.imu import Attitude
from gaitlab.motions.declaration import TERMS, Wiring, require_numbers
from gaitlab.motions.network import Network


class Pilot:
    """One walk of a policy; it remembers its last output and what it was fed before.

    Attributes:
        interval: From one act to the next, in [s].
        delay: From an act to when its targets are sent, in [s].
        columns: The joints that it moves, in the robot's tree. Shape (m,).
    """

    def __init__(
        self,
        network: Network,
        wiring: Wiring,
        names: Sequence[str],
        *,
        command: tuple[float, float, float],
        ramp: float,
        period: float,
        delay: float,
    ) -> None:
        """A policy that has not acted yet.

        Args:
            network: The network.
            wiring: What goes in and comes out.
            names: Of the joints that it moves.
            command: Speed ahead and to the left, in [m/s], and of turning left, in [rad/s].
            ramp: In which the command grows from nothing, in [s].
            period: Of the phase, in [s].
            delay: From an act to when its targets are sent, in [s].
        """
        self.interval, self.delay, self.columns = 1.0 / wiring.rate, delay, wiring.columns
        self._network, self._wiring, self._names = network, wiring, names
        self._command, self._ramp, self._period = np.array(command), ramp, period
        joints, at = len(wiring.columns), 0
        places = {}
        for term, size in TERMS.items():
            places[term] = slice(at, at + (size or joints))
            at = places[term].stop
        self._state, self._at = np.zeros(at), places
        index = [np.arange(at)[places[term]] for term in wiring.terms]
        self._index = np.concatenate(index)
        self._rest = wiring.pose[wiring.columns]
        self._frames = np.zeros((wiring.history, len(self._index)))
        self._order: np.ndarray | None = None
        if wiring.by_term and wiring.history > 1:
            numbers = np.arange(self._frames.size).reshape(self._frames.shape)
            ends = np.cumsum([len(part) for part in index])[:-1]
            self._order = np.concatenate([p.ravel() for p in np.split(numbers, ends, axis=1)])
        self._acted = False

    def act(
        self,
        t: float,
        felt: Attitude,
        yaw_rate: float,
        position: np.ndarray,
        velocity: np.ndarray,
    ) -> np.ndarray:
        """Targets of its joints, in [rad]. Shape (m,).

        Args:
            t: Time since it took over, in [s].
            felt: What the IMU says.
            yaw_rate: Likewise, about the trunk's upward axis, in [rad/s].
            position: Of its joints, in [rad]. Shape (m,).
            velocity: Of its joints, in [rad/s]. Shape (m,).

        Raises:
            WrongValue: If it gives what is no number, or as many as it did not declare.
        """
        wiring, frames = self._wiring, self._frames
        row = self.observation(t, felt, yaw_rate, position, velocity)
        if wiring.history > 1:
            frames[:-1] = frames[1:]
        frames[-1] = row
        if not self._acted:
            frames[:], self._acted = row, True
        given = frames.reshape(-1)
        action = self._network.run(given if self._order is None else given[self._order])
        if len(action) != len(self._names):
            raise WrongValue(f"the policy gave {len(action)} numbers for {len(self._names)} joints")
        action = action.astype(float)
        require_numbers(action, self._names, f"{t:.3f} s after it took over")
        if wiring.action_clip:
            action = np.minimum(np.maximum(action, -wiring.action_clip), wiring.action_clip)
        self._state[self._at["last_action"]] = action
        targets: np.ndarray = self._rest + wiring.action_scale * action
        return targets

    def observation(
        self,
        t: float,
        felt: Attitude,
        yaw_rate: float,
        position: np.ndarray,
        velocity: np.ndarray,
    ) -> np.ndarray:
        """What of this instant goes in, scaled; arguments as of `act`. Shape (numbers,)."""
        state, at, level = self._state, self._at, cos(felt.pitch)
        turned = 2.0 * pi * (t / self._period % 1.0)
        share = min(t / self._ramp, 1.0) if self._ramp else 1.0
        state[:8] = (
            *(felt.roll_rate, felt.pitch_rate, yaw_rate),
            *(sin(felt.pitch), -level * sin(felt.roll), -level * cos(felt.roll)),
            *(felt.roll, felt.pitch),
        )
        state[at["command"]] = share * self._command
        state[at["joint_positions"]] = position - self._rest
        state[at["joint_velocities"]] = velocity
        state[at["phase"]] = sin(turned), cos(turned)
        row: np.ndarray = state[self._index] * self._wiring.scale
        clip = self._wiring.observation_clip
        return np.minimum(np.maximum(row, -clip), clip) if clip else row
