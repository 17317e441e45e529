"""The commands in one place, and the edge at which errors become messages and exit codes."""

from __future__ import annotations

import sys
import traceback
from collections.abc import Sequence
from functools import cache
from typing import Annotated, Any

import typer
from typer.core import TyperGroup
from typer.exceptions import TyperException
from typer.main import get_command

from gaitlab.cli.audit import audit
from gaitlab.cli.catalogue import list_names, show
from gaitlab.cli.comparing import compare_log
from gaitlab.cli.gate import baseline, check
from gaitlab.cli.kinematics import NUMBERS, fk, ik
from gaitlab.cli.optimizing import optimize
from gaitlab.cli.printing import say, tell
from gaitlab.cli.replaying import export, replay, view
from gaitlab.cli.results import QueryCommand, merge, query, report, status, verify
from gaitlab.cli.robot import robot
from gaitlab.cli.running import run
from gaitlab.cli.starting import new, schema
from gaitlab.cli.submitting import submit
from gaitlab.documents.printable import is_utf8
from gaitlab.errors import FileError, GaitlabError, StoreError, UsageError
from gaitlab.kinematics.caches import lend_caches

INTERRUPTED = 130  # exit code, as of a shell after Ctrl-C
READING = ("list", "show", "query", "ik", "fk", "compare-log")
WRITING = (
    "new",
    "schema",
    "robot",
    "report",
    "audit",
    "export",
    "replay",
    "view",
    "baseline",
)  # files outside the store


class _Stopped(Exception):
    """Ctrl-C, past Typer, which would end the program without a word."""


class _Commands(TyperGroup):
    """The commands, and what ends one of them early."""

    def make_context(self, *arguments: Any, **options: Any) -> Any:
        try:
            return super().make_context(*arguments, **options)
        except KeyboardInterrupt as error:
            raise _Stopped("stopped; nothing was begun") from error

    def invoke(self, ctx: typer.Context) -> Any:  # type: ignore[override]
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt as error:
            raise _Stopped(_left_by(ctx.invoked_subcommand or "")) from error
        except SystemExit as error:
            tell(f"a gait or robot file ended the program (SystemExit: {error.code}); mend it")
            return FileError.exit_code


def _left_by(command: str) -> str:
    """What a command leaves that Ctrl-C has ended."""
    if command in READING:
        return "stopped; nothing was changed"
    if command in WRITING:
        return (
            f"stopped; `{command}` had not finished: files that it had not written yet are missing "
            "or those of before. The store is as it was, and the same command writes all of them"
        )
    return "stopped; what is committed is safe, and the same command goes on from there"


app = typer.Typer(
    cls=_Commands,
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
    """Tell which walk keeps a humanoid robot on its feet on which ground.

    \b
    Example:
      gaitlab run eros_quick
      gaitlab report eros_quick
    """


app.command(short_help="Simulate what the store does not hold yet.")(run)
app.command(short_help="Run an experiment on a SLURM cluster, in shards.")(submit)
app.command(short_help="Search for the parameters that walk best.")(optimize)
app.command(short_help="Write the tables and figures of experiments or studies.")(report)
app.command(name="list", short_help="List robots, gaits, surfaces, servos, experiments.")(
    list_names
)
app.command(short_help="Begin an experiment, study, surface, servo or gait.")(new)
app.command(short_help="See what a URDF holds, and draft a first walk.")(robot)
app.command(short_help="Show the parameters behind a name, or a trial.")(show)
app.command(short_help="Look at an experiment and its walks in the browser.")(view)
app.command(short_help="Show a trial in 3-D or as a film.")(replay)
app.command(short_help="Write a log or a robot for another tool.")(export)
app.command(name="compare-log", short_help="Set a real robot's log beside its simulation.")(
    compare_log
)
app.command(short_help="Count what is done, infeasible, failed and damaged.")(status)
app.command(cls=QueryCommand)(query)
app.command(context_settings=NUMBERS)(ik)
app.command(context_settings=NUMBERS)(fk)
app.command(short_help="Print what may stand in a file, for editors.")(schema)
app.command(short_help="Set a paper's published tables beside our values.")(audit)
app.command(short_help="Walk an experiment and compare with a baseline.")(check)
app.command(short_help="Write the baseline that `check` compares with.")(baseline)
app.command(short_help="Add all trials and experiments of a store to another.")(merge)
app.command(short_help="Check every checksum, simulate some trials again.")(verify)


def run_command_line(arguments: Sequence[str]) -> int:
    """Carry out a command and give its exit code; nothing it raises gets past here."""
    words = list(arguments) or ["--help"]
    lend_caches()
    try:
        _require_utf8(words)
        return int(_command()(words, prog_name="gaitlab", standalone_mode=False) or 0)
    except GaitlabError as error:
        tell(str(error))
        return error.exit_code
    except TyperException as error:
        tell(_usage_text(error))
        return error.exit_code
    except (_Stopped, KeyboardInterrupt) as error:
        tell(str(error) or "stopped; nothing was begun")
        return INTERRUPTED
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        reason = error.strerror or str(error)
        system_text = (
            f"{where}{reason}; the folder may be gone, full, no folder or not yours to write to"
        )
        tell(system_text)
        return StoreError.exit_code
    except SystemExit as error:  # of the shell's completion, or the reader of the help has gone
        gone = isinstance(error.__context__, BrokenPipeError)
        return 0 if gone else int(error.code or 0)
    except Exception:
        traceback.print_exc(file=sys.stderr)
        tell("This is a mistake in gaitlab. Please report it to its authors, with the lines above.")
        return 1


@cache
def _command() -> Any:
    """The commands as Typer builds them, in a tenth of a second; a program may call many."""
    return get_command(app)


def _require_utf8(words: Sequence[str]) -> None:
    """Refuse names and texts that neither Parquet, SQL nor a page could hold.

    Raises:
        UsageError: If a word holds other bytes.
    """
    for word in words:
        if not is_utf8(word):
            raise UsageError(
                f"the argument '{word}' holds bytes that are no UTF-8; rename the file or "
                "folder, or set a locale of UTF-8 (LC_ALL=C.UTF-8) if it was typed so"
            )


def _usage_text(error: TyperException) -> str:
    """What was wrong with the arguments, with what was found, and whose help to read."""
    message = error.format_message().replace("Value error, ", "")
    message = message.replace("Input should be a valid integer", "a whole number is expected")
    details: list[dict[str, object]] = getattr(error.__cause__, "errors", list)()
    if details and details[0]["type"] == "int_parsing":
        message = f"{message.partition(', unable')[0]}, found {details[0]['input']!r}"
    context = getattr(error, "ctx", None)
    return f"{message}\nTry `{context.command_path if context else 'gaitlab'} --help`."
