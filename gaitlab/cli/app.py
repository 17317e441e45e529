"""The commands in one place, and the edge at which errors become messages and exit codes."""

from __future__ import annotations

import sys
import traceback
from collections.abc import Sequence
from typing import Annotated

import typer
from typer.exceptions import TyperException

from gaitlab.cli.audit import audit
from gaitlab.cli.catalogue import list_names, show
from gaitlab.cli.exporting import export
from gaitlab.cli.gate import baseline, check
from gaitlab.cli.keeping import merge, verify
from gaitlab.cli.kinematics import NUMBERS, fk, ik
from gaitlab.cli.optimizing import optimize
from gaitlab.cli.printing import say, tell
from gaitlab.cli.replaying import replay
from gaitlab.cli.results import query, report, status
from gaitlab.cli.running import run
from gaitlab.errors import FileError, GaitlabError, StoreError

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


app.command(short_help="Simulate what the store does not hold yet.")(run)
app.command(short_help="Search for the parameters that walk best.")(optimize)
app.command(short_help="Write the tables and figures of experiments or studies.")(report)
app.command(name="list", short_help="List robots, gaits, surfaces, servos, experiments.")(
    list_names
)
app.command(short_help="Show the parameters behind a name, or a trial.")(show)
app.command(short_help="Show a trial as a film.")(replay)
app.command(short_help="Write a log or a robot for another tool.")(export)
app.command(short_help="Count what is done, infeasible, failed and damaged.")(status)
app.command()(query)
app.command(context_settings=NUMBERS)(ik)
app.command(context_settings=NUMBERS)(fk)
app.command(short_help="Set a paper's published tables beside our values.")(audit)
app.command(short_help="Walk an experiment and compare with a baseline.")(check)
app.command(short_help="Write the baseline that `check` compares with.")(baseline)
app.command(short_help="Add all trials and experiments of a store to another.")(merge)
app.command(short_help="Check every checksum, simulate some trials again.")(verify)


def run_command_line(arguments: Sequence[str]) -> int:
    """Carry out a command and give its exit code; nothing it raises gets past here."""
    words = list(arguments) or ["--help"]
    try:
        return int(app(words, prog_name="gaitlab", standalone_mode=False) or 0)
    except GaitlabError as error:
        tell(str(error))
        return error.exit_code
    except TyperException as error:
        tell(_usage_text(error))
        return error.exit_code
    except KeyboardInterrupt:
        tell("stopped; what is committed is safe, and the same command goes on from there")
        return INTERRUPTED
    except OSError as error:
        tell(_system_text(error))
        return StoreError.exit_code
    except SystemExit as error:
        tell(f"a gait or robot file ended the program (SystemExit: {error.code}); mend it")
        return FileError.exit_code
    except Exception:
        traceback.print_exc(file=sys.stderr)
        tell("This is a mistake in gaitlab. Please report it to its authors, with the lines above.")
        return 1


def _usage_text(error: TyperException) -> str:
    """What was wrong with the arguments, with what was found, and whose help to read."""
    message = error.format_message().replace("Value error, ", "")
    message = message.replace("Input should be a valid integer", "a whole number is expected")
    details: list[dict[str, object]] = getattr(error.__cause__, "errors", list)()
    if details and details[0]["type"] == "int_parsing":
        message = f"{message.partition(', unable')[0]}, found {details[0]['input']!r}"
    context = getattr(error, "ctx", None)
    return f"{message}\nTry `{context.command_path if context else 'gaitlab'} --help`."


def _system_text(error: OSError) -> str:
    """What the system refused, for whatever no command foresaw."""
    where = f"{error.filename}: " if error.filename else ""
    reason = error.strerror or str(error)
    return f"{where}{reason}; the folder may be gone, full, no folder or not yours to write to"
