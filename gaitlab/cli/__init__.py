"""The command line: arguments in, tables on stdout, messages on stderr, an exit code out.

Each command reads its arguments, calls the library and prints. What is slow to load (engine,
tables, plots) is imported inside the command that needs it, so that help is instant.
"""

from gaitlab.cli.app import run_command_line

__all__ = ["run_command_line"]
