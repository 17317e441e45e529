"""Over how many gait cycles the rocking was measured."""

from __future__ import annotations

from gaitlab.log import TrialLog

UNIT = "-"


def pitch_cycles(log: TrialLog) -> int:
    """Gait cycles that `pitch_amplitude`, `roll_amplitude` and `pitch_rms` use."""
    return len(log.measured_cycles)
