"""`gaitlab` and `python -m gaitlab`."""

from __future__ import annotations

import sys
from io import TextIOWrapper


def main() -> None:
    """Run the command line; a worker process that imports this file loads nothing of it."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):  # a terminal of another alphabet shows `\\u2192`
            stream.reconfigure(errors="backslashreplace")
    try:
        from gaitlab.cli import run_command_line
    except KeyboardInterrupt:
        print("stopped; nothing was begun", file=sys.stderr)
        sys.exit(130)

    sys.exit(run_command_line(sys.argv[1:]))


if __name__ == "__main__":
    main()
