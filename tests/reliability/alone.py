"""`gaitlab` in a process of its own, with trials that are pretended."""

from __future__ import annotations

import sys

if __name__ == "__main__":
    import gaitlab.running.processes
    from gaitlab.cli import run_command_line
    from tests.reliability import sweeps

    gaitlab.running.processes.simulated = sweeps.slow
    sys.exit(run_command_line(sys.argv[1:]))
