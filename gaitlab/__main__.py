"""`gaitlab` and `python -m gaitlab`."""

from __future__ import annotations

import sys


def main() -> None:
    """Run the command line; a worker process that imports this file loads nothing of it."""
    from gaitlab.cli import run_command_line

    sys.exit(run_command_line(sys.argv[1:]))


if __name__ == "__main__":
    main()
