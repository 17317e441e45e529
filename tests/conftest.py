"""Settings of the whole test run."""

from __future__ import annotations

from hypothesis import settings

# No deadline: a busy machine is no failure. Derandomised: the same commit gives the same verdict.
settings.register_profile("gaitlab", deadline=None, derandomize=True)
settings.load_profile("gaitlab")
