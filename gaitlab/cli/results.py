"""`gaitlab report`, `status`, `query`, `merge` and `verify`: what a store holds, and if soundly."""

from __future__ import annotations

import csv
import io
import itertools
import json
import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from contextlib import nullcontext
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from typer.core import TyperCommand

from gaitlab.cli.options import (
    DEFAULT_STORE,
    AllowCode,
    Force,
    Quick,
    Seeds,
    Settings,
    ShownEngine,
    StoreFolder,
    complete_experiments,
    with_engine,
    written_to,
)
from gaitlab.cli.printing import (
    columns,
    number,
    other_output_on_stderr,
    plural,
    say,
    size,
    tell,
)
from gaitlab.cli.trial_lookup import allowed
from gaitlab.documents.printable import csv_cell
from gaitlab.errors import UnknownName, UsageError

if TYPE_CHECKING:
    from gaitlab.running.verify import Verdict
    from gaitlab.store import ShardStatus, Store, TrialList
    from gaitlab.store.index import Index


NEEDS_ATTENTION = 4  # exit code: what is right is kept, something else was found
DEFAULT_SAMPLE = 3  # trials simulated again
COMMENT = re.compile(r"--(?![\w-]+(?:=|$))(?=.*\s)", re.DOTALL)  # begins SQL, no option
JSON_WORD = re.compile(r'"(?:[^"\\]|\\.)*"|NaN|-?Infinity')  # of a text in JSON
WIDEST_CELL = 80  # characters of a cell in a printed table; csv and json hold all of it


class QueryCommand(TyperCommand):
    """The command `query`, whose SQL may begin with a comment and is then no option."""

    def parse_args(self, ctx: typer.Context, args: list[str]) -> list[str]:  # type: ignore[override]
        """Arguments, SQL that would pass for an option begun with a blank."""
        sql = (f" {word}" if COMMENT.match(word) else word for word in args)
        return super().parse_args(ctx, list(sql))


class Format(str, Enum):
    """How a table is printed."""

    table = "table"
    csv = "csv"
    json = "json"


class Form(str, Enum):
    """In which form a page is written."""

    md = "md"
    html = "html"


def report(
    experiments: Annotated[
        list[str],
        typer.Argument(
            metavar="EXPERIMENT",
            help="Files, or names of some in experiments/.",
            autocompletion=complete_experiments,
        ),
    ],
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            metavar="DIR",
            parser=written_to,
            help="Folder, reports/EXPERIMENT by default.",
        ),
    ] = None,
    form: Annotated[
        Form,
        typer.Option(
            "--format", help="html adds index.html: every cell opens its seeds, in one file."
        ),
    ] = Form.md,
    tables: Annotated[
        bool, typer.Option("--tables", help="Also write every table as LaTeX and CSV.")
    ] = False,
    storage: Annotated[
        str | None,
        typer.Option(metavar="URL", help="Database of a study, if several machines share it."),
    ] = None,
    force: Force = False,
    quick: Quick = False,
    seeds: Seeds = None,
    settings: Settings = None,
    engine: ShownEngine = None,
    store: StoreFolder = DEFAULT_STORE,
) -> int:
    """Write the tables and figures of experiments, studies or a reproduction as a page of Markdown.

    \b
    Example:
      gaitlab report eros_table7 eros_table8
      gaitlab report eros_quick --format html --tables
      gaitlab report eros_small
      gaitlab report eros_reproduction --quick
    """
    from gaitlab import load
    from gaitlab.cli.common import refuse_quick
    from gaitlab.cli.progress import steps
    from gaitlab.experiment import is_reproduction

    if output is not None and output.exists() and not output.is_dir():
        raise UsageError(f"--output {output}: a file is in the way; give a folder")
    settings = with_engine(settings, engine)
    if any(map(is_reproduction, experiments)):
        from gaitlab.cli.reproducing import only_one
        from gaitlab.papers.reproduction import load_reproduction, write_reproduction
        from gaitlab.store import Store

        name, html = only_one(experiments), form is Form.html
        with other_output_on_stderr(), steps():
            whole = load_reproduction(name, quick=quick, settings=settings, seeds=seeds)
            page = write_reproduction(
                whole, Store(store), output, html=html, tables=tables, force=force
            )
        say(str(page))
        return 0
    refuse_quick(experiments[0], quick)
    with other_output_on_stderr(), steps():
        first, *others = [load(name, settings, seeds) for name in experiments]
        page = first.report(
            *others,
            output=output,
            format=form.value,
            tables=tables,
            force=force,
            storage=storage,
            store=store,
        )
    say(str(page))
    return 0


def status(
    experiment: Annotated[
        str | None,
        typer.Argument(
            metavar="EXPERIMENT",
            help="Name or file of one that was run; all by default.",
            autocompletion=complete_experiments,
        ),
    ] = None,
    rebuild: Annotated[
        bool, typer.Option("--rebuild", help="Write the index anew from the trials' own files.")
    ] = False,
    store: StoreFolder = DEFAULT_STORE,
) -> int:
    """Say how many trials of each experiment, and which of its shards, are done.

    Also names the files that are no trials.

    \b
    Example:
      gaitlab status eros_quick
    """
    from gaitlab.store import Store

    results = Store(store)
    with results.alone() if rebuild else nullcontext():
        index = results.rebuild() if rebuild else results.index()
    lists, damaged = results.lists()
    wanted = list(lists) if experiment is None else _registered_names(experiment, lists, results)
    chosen = {
        name: found  # a form stands below the experiment that it is one of
        for one in wanted
        for name, found in lists.items()
        if name == one or name.startswith(f"{one}+")
    }
    if experiment is not None and wanted[0] in damaged:
        raise damaged[wanted[0]]
    if experiment is not None and not chosen:
        known = ", ".join(lists) or "none"
        raise UnknownName(f"{store}: no experiment {wanted[0]!r} was run here; there: {known}")
    head = (
        *("experiment", "planned", "done", "infeasible", "failed", "left"),
        *("falls", "fell standing"),
    )
    say(columns(head, [_status_row(found, index) for found in chosen.values()]))
    for found in chosen.values():
        shards = results.shards(found, index)
        if shards and experiment is not None:
            say(f"\n{_shard_table(found, shards)}")
        elif shards:
            tell(_shard_counts(found, shards))
    if not store.is_dir():
        tell(f"{store}: no such folder; nothing was run into it yet")
        return 0
    total = sum(entry.size for entry in index.entries.values())
    tell(f"{store}: {plural(len(index.entries), 'trial')}, {size(total)}")
    for problem in (*index.unreadable, *damaged.values()):
        _tell_left_out(problem)
    return 0


def query(
    sql: Annotated[str, typer.Argument(metavar="SQL", help="One SELECT over trials and ticks.")],
    form: Annotated[Format, typer.Option("--format", help="How to print it.")] = Format.table,
    store: StoreFolder = DEFAULT_STORE,
) -> int:
    """Answer a question in SQL; the views are `trials` and `ticks`.

    \b
    Example:
      gaitlab query "SELECT surface, avg(stable::int) FROM trials GROUP BY 1"
    """
    from gaitlab import open_store

    answer = open_store(store).query(sql, exact=True, left_out=_tell_left_out)
    head, rows = unlike(answer.columns), list(answer.itertuples(index=False, name=None))
    say(FORMATTED[form](head, rows))
    return 0


def _tell_left_out(problem: Exception) -> None:
    tell(f"not counted: {problem}")


def _registered_names(experiment: str, lists: Mapping[str, TrialList], results: Store) -> list[str]:
    """Names of what is asked for: of a file, or of every experiment of a reproduction."""
    from gaitlab.experiment import is_reproduction, load_experiment
    from gaitlab.plugins import is_file_name, names

    if experiment in lists or not (is_file_name(experiment) or experiment in names("experiment")):
        return [experiment]
    with other_output_on_stderr():
        if is_reproduction(experiment):
            from gaitlab.papers.reproduction import load_reproduction

            return [member.listed_as for member in load_reproduction(experiment).members]
        if not is_file_name(experiment):
            return [experiment]
        wanted = load_experiment(experiment)
        results.require_one_file(wanted)
        return [wanted.listed_as]


def _shard_table(listed: TrialList, shards: Sequence[ShardStatus]) -> str:
    rows = [
        [str(status.shard), status.state, str(status.planned), str(status.left), status.holder]
        for status in shards
    ]
    return columns((f"shard of {listed.experiment}", "state", "planned", "left", "run by"), rows)


def _shard_counts(listed: TrialList, shards: Sequence[ShardStatus]) -> str:
    counts = Counter(status.state for status in shards)
    states = ", ".join(f"{counts[state]} {state}" for state in ("pending", "running", "done"))
    return f"{listed.experiment} in {plural(len(shards), 'shard')}: {states}"


def _status_row(found: TrialList, index: Index) -> list[str]:
    there = [index.entries[t.trial_id] for t in found.trials if t.trial_id in index.entries]
    states = [entry.state for entry in there]
    counts = [states.count(state) for state in ("DONE", "INFEASIBLE", "FAILED")]
    fallen = [entry for entry in there if entry.fell]
    standing = sum(bool(entry.details.metrics.get("fell_standing")) for entry in fallen)
    left = len(found.trials) - len(there)
    row = (len(found.trials), *counts, left, len(fallen), standing)
    return [found.experiment, *map(str, row)]


def unlike(names: Iterable[str]) -> list[str]:
    """Names of columns, a second `n` as `n_1`: an object of JSON holds a name once."""
    unlike: list[str] = []
    for name in names:
        again = (f"{name}_{count}" for count in itertools.count(1))
        unlike.append(name if name not in unlike else next(n for n in again if n not in unlike))
    return unlike


def _json(head: Sequence[str], rows: Sequence[Sequence[str | None]]) -> str:
    """An array with one object a row; every number as it is, what is none in JSON as null."""
    names = [json.dumps(name) for name in head]
    objects = (
        ", ".join(f"{name}: {JSON_WORD.sub(_of_json, cell or 'null')}" for name, cell in pairs)
        for pairs in (zip(names, row, strict=True) for row in rows)
    )
    return f"[{', '.join(f'{{{content}}}' for content in objects)}]"


def _of_json(word: re.Match[str]) -> str:
    """DuckDB writes NaN, which JSON lacks; texts in ASCII pass every pipe and terminal."""
    return json.dumps(json.loads(word[0])) if word[0].startswith('"') else "null"


def _csv(head: Sequence[str], rows: Sequence[Sequence[str | None]]) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([csv_cell(name) for name in head])
    writer.writerows([_csv_cell(cell) for cell in row] for row in rows)
    return text.getvalue().rstrip("\n")


def _csv_cell(cell: str | None) -> str:
    if cell is None or cell == "NaN":
        return ""
    return csv_cell(json.loads(cell)) if cell.startswith('"') else cell


def _table(head: Sequence[str], rows: Sequence[Sequence[str | None]]) -> str:
    return columns(head, [[_cell(cell) for cell in row] for row in rows])


def _cell(cell: str | None) -> str:
    """A value on one line, numbers to six digits, cut if it is long."""
    if cell is None or cell == "NaN":
        return ""
    value = cell if cell.startswith(("[", "{")) else json.loads(cell)
    text = " ".join(value.split()) if isinstance(value, str) else number(value)
    return text if len(text) <= WIDEST_CELL else f"{text[: WIDEST_CELL - 3]}..."


FORMATTED = {Format.table: _table, Format.csv: _csv, Format.json: _json}


def merge(
    into: Annotated[Path, typer.Argument(metavar="A", help="Folder that gets everything.")],
    other: Annotated[Path, typer.Argument(metavar="B", help="Folder that is only read.")],
) -> int:
    """Add all trials and experiments of store B to store A; B stays as it is.

    Where both hold a trial and disagree, A's stays and B's goes to A/conflicts; exit code 4.

    \b
    Example:
      gaitlab merge data ../laptop/data
    """
    from gaitlab.store import Store
    from gaitlab.store.merge import merge as merge_stores

    done = merge_stores(Store(into), Store(other))
    for message in done.conflicts:
        tell(f"conflict: {message}")
    for message in done.refused:
        tell(f"not taken: {message}")
    counts = f"{done.taken} trials taken, {done.shared} were there, "
    say(f"{counts}{len(done.conflicts)} conflicts, {len(done.refused)} files not taken")
    return NEEDS_ATTENTION if done.conflicts or done.refused else 0


def verify(
    sample: Annotated[
        int,
        typer.Option("--sample", metavar="N", min=0, help="Trials to simulate again, at random."),
    ] = DEFAULT_SAMPLE,
    jobs: Annotated[
        int, typer.Option("-j", "--jobs", metavar="N", min=0, help="Worker processes for them.")
    ] = 1,
    repair: Annotated[
        bool,
        typer.Option("--repair", help="Set damaged files aside, so that `run` does them again."),
    ] = False,
    allow_code: AllowCode = False,
    store: StoreFolder = DEFAULT_STORE,
) -> int:
    """Check the checksums of every trial, and simulate some again: the bits must be the same.

    \b
    Example:
      gaitlab verify --sample 10
    """
    from gaitlab.cli.progress import steps
    from gaitlab.running.verify import verify as verify_store
    from gaitlab.store import Store

    results = Store(store)
    with steps():
        found = verify_store(results, sample=sample, jobs=jobs, allowed=allowed(allow_code))
    for problem in found.unsound:
        tell(f"not sound: {problem}")
    for message in found.different:
        tell(f"not repeated: {message}")
    for message in found.skipped:
        tell(f"not simulated again: {message}")
    if repair:
        _repair(results, found)
    say(
        f"{found.checked} trials sound, {len(found.unsound)} files not; "
        f"{found.repeated} simulated again bit for bit, {len(found.different)} not"
    )
    return 0 if found.sound else NEEDS_ATTENTION


def _repair(results: Store, found: Verdict) -> None:
    damaged = [error.path for error in found.unsound if error.kind == "damaged"]
    if not damaged:
        return
    with results.alone():
        for path in damaged:
            if path.exists():
                tell(f"set aside: {path} is now {results.set_aside(path)}")
        results.compact()
