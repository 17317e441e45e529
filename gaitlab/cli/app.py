"""The commands in one place, and the edge at which errors become messages and exit codes."""

from __future__ import annotations

import sys
import traceback
from collections.abc import Sequence
from typing import Annotated

import typer
from typer.exceptions import TyperException

from gaitlab.cli.catalogue import list_names, show
from gaitlab.cli.printing import say, tell
from gaitlab.cli.results import query, report, status
from gaitlab.cli.running import run
from gaitlab.errors import GaitlabError

INTERRUPTED = 130  # exit code, as of a shell after Ctrl-C

app = typer.Typer(
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        say(f"gaitlab {version('gaitlab')}")
        raise typer.Exit


@app.callback()
def gaitlab(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """Tell which walking-gait parameters keep a humanoid robot on its feet on which ground.

    \b
    Example:
      gaitlab run eros_quick
      gaitlab report eros_quick
    """


app.command()(run)
app.command()(report)
app.command(name="list")(list_names)
app.command()(show)
app.command()(status)
app.command()(query)


def run_command_line(arguments: Sequence[str]) -> int:
    """Carry out a command and give its exit code; nothing it raises gets past here."""
    words = list(arguments) or ["--help"]
    try:
        return int(app(words, prog_name="gaitlab", standalone_mode=False) or 0)
    except GaitlabError as error:
        tell(str(error))
        return error.exit_code
    except TyperException as error:
        tell(f"{error.format_message()}\nTry `gaitlab --help`, or --help after a command.")
        return error.exit_code
    except SystemExit as error:
        return error.code if isinstance(error.code, int) else 1
    except KeyboardInterrupt:
        return INTERRUPTED
    except Exception:
        traceback.print_exc(file=sys.stderr)
        tell("This is a mistake in gaitlab. Please report it to its authors, with the lines above.")
        return 1
