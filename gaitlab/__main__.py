"""`gaitlab` and `python -m gaitlab`."""

from __future__ import annotations

import sys
from io import TextIOWrapper

WINDOWS = (
    "gaitlab runs on Linux and macOS: its locks and signals are those of POSIX. On Windows install "
    "it in WSL, where it is as on Linux (`wsl --install`, then `pip install gaitlab`)."
)


def main() -> None:
    """Run the command line; a worker process that imports this file loads nothing of it."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):  # a terminal of another alphabet shows `\\u2192`
            stream.reconfigure(errors="backslashreplace")
    if sys.platform == "win32":
        print(WINDOWS, file=sys.stderr)
        sys.exit(2)
    try:
        from gaitlab.cli import run_command_line
    except KeyboardInterrupt:
        print("stopped; nothing was begun", file=sys.stderr)
        sys.exit(130)

    sys.exit(run_command_line(sys.argv[1:]))


if __name__ == "__main__":
    main()
