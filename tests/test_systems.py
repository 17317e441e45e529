"""What is promised on systems that the tests do not run on."""

from __future__ import annotations

import subprocess
import sys

UNIX = ("fcntl", "resource", "termios", "pwd", "grp", "gaitlab.cli", "gaitlab.store")
WINDOWS = f"""
import sys
sys.modules.update(dict.fromkeys({UNIX}))  # importing one of them is an error
sys.platform = "win32"
from gaitlab.__main__ import main
main()
"""


def test_on_windows_a_command_says_where_it_runs_and_loads_nothing_that_is_not_there() -> None:
    done = subprocess.run(
        [sys.executable, "-c", WINDOWS, "list"], capture_output=True, text=True, timeout=60.0
    )
    assert done.returncode == 2
    assert done.stdout == ""
    assert "WSL" in done.stderr
    assert "Traceback" not in done.stderr
