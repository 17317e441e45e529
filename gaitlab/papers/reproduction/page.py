"""The page of a reproduction: headline, sections and where all of it comes from."""

from __future__ import annotations

import hashlib
import shlex
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import cast

import pandas as pd

from gaitlab.documents.steps import expect, step
from gaitlab.errors import NothingRun
from gaitlab.experiment import Experiment
from gaitlab.experiment.shell import called, command, store_option
from gaitlab.papers.reproduction.answers import Calibrated, answers
from gaitlab.papers.reproduction.document import Reproduction
from gaitlab.papers.reproduction.headline import front
from gaitlab.papers.reproduction.section import Context, Section
from gaitlab.papers.reproduction.sections import how_to_read, section_text
from gaitlab.report.forms import REPORTS, publish
from gaitlab.report.gather import gather
from gaitlab.report.markdown import DETAILS, code, details, escape, fenced, section, table
from gaitlab.report.provenance import common_values, facts_table, seeds_text
from gaitlab.report.results import Results
from gaitlab.report.scores import SCORED
from gaitlab.report.sources import records
from gaitlab.report.words import plural
from gaitlab.simulation.trial import PHYSICS_VERSION
from gaitlab.store import Store

WALKED = "walked_time"  # metric of a trial, in [s]
QUICK = "**Quick form**: fewer seeds and points than the whole has, as the members below say."
TABLES = "tables"  # kind of section that the headline is made from


def write_reproduction(
    reproduction: Reproduction,
    store: Store,
    output: Path | None = None,
    *,
    html: bool = False,
    tables: bool = False,
    force: bool = False,
    links: Mapping[str, str] | None = None,
) -> Path:
    """Write the page of a reproduction; the same store gives the same bytes.

    Args:
        reproduction: What was asked.
        store: Where the trials are; what is missing there is named on the page.
        output: Folder of the page and its figures; by default `reports/<name>`.
        html: Also write the page as one file of HTML.
        tables: Also write every table as LaTeX and CSV.
        force: Also write into a folder that holds files of somebody else.
        links: Pages beside it that the contents of the HTML lead to, by what they are called.

    Returns:
        The page, in HTML if that was asked for.

    Raises:
        NothingRun: If the store holds no trial of any member.
        UsageError: If members cannot share a section.
        WrongValue: If an option names what there is not.
    """
    results = _results(reproduction, store)
    folder = output or REPORTS / reproduction.name
    members = {member.name: member for member in reproduction.members}

    def write(place: Path) -> Path:
        context = Context(results=results, experiments=members, store=store, folder=place)
        page = place / "README.md"
        page.write_text(first_page(reproduction, context), encoding="utf-8")
        if any(each.details for each in reproduction.sections):
            second = second_page(reproduction, context)
            page.with_name(DETAILS).write_text(second, encoding="utf-8")
        return page

    return publish(folder, write, html=html, tables=tables, force=force, links=links)


def _results(reproduction: Reproduction, store: Store) -> dict[str, Results]:
    """Results of every member of which anything was run."""
    found = {}
    expect(len(reproduction.members) + len(reproduction.sections))
    for member in reproduction.members:
        step(f"reading the trials of {member.name}")
        try:
            found[member.name] = _gathered(member, reproduction.filed.get(member.name), store)
        except NothingRun:
            continue
    if not found:
        raise NothingRun(
            f"the store {store.path} holds no trial of this form of {reproduction.path.stem}; "
            f"run `{run_command(reproduction, store)}` first"
        )
    return found


def _gathered(member: Experiment, filed: Experiment | None, store: Store) -> Results:
    """Results of a member, and of the further seeds of its file that are wholly there.

    Raises:
        NothingRun: If the store holds no trial of it.
    """
    if filed is None or len(filed.seeds) <= len(member.seeds):
        return gather([member], store)
    whole = gather([filed], store)
    lacking = whole.trials.loc[whole.trials["state"].eq("MISSING"), "seed"]
    left_out = set(lacking) - set(member.seeds)
    kept = whole.trials[~whole.trials["seed"].isin(left_out)]
    return replace(whole, trials=kept.reset_index(drop=True))


def run_command(reproduction: Reproduction, store: Store) -> str:
    """The shell line that simulates what is missing."""
    return f"gaitlab run {_arguments(reproduction, store)}"


def _commands(reproduction: Reproduction, context: Context) -> list[str]:
    """Shell lines that make the page again, one for each member with further seeds of its file."""
    store = context.store
    further = [
        command("run", [filed], store.path)
        for name, filed in reproduction.filed.items()
        if not set(_seeds(context, name)) <= set(context.experiments[name].seeds)
    ]
    return [run_command(reproduction, store), *further, report_command(reproduction, store)]


def _seeds(context: Context, name: str) -> list[int]:
    """Seeds of a member that are counted."""
    found = context.results.get(name)
    return [] if found is None else sorted(found.trials["seed"].unique())


def report_command(reproduction: Reproduction, store: Store) -> str:
    """The shell line that writes the page."""
    return f"gaitlab report {_arguments(reproduction, store)}"


def _arguments(reproduction: Reproduction, store: Store) -> str:
    words = [called(reproduction.path), *reproduction.options, *store_option(store.path)]
    return shlex.join(words)


def first_page(reproduction: Reproduction, context: Context) -> str:
    """What was found: the scores in front, then the sections that do not stand behind."""
    blocks = [
        f"# {escape(reproduction.title)}",
        QUICK if "--quick" in reproduction.options else "",
        _completeness(reproduction, context),
        *_front(reproduction, context),
        escape(reproduction.description),
        _made_by(reproduction, context),
        *(_section(each, context) for each in reproduction.sections if not each.details),
        *_end(reproduction, context, second=False),
    ]
    return "\n\n".join(block for block in blocks if block) + "\n"


def second_page(reproduction: Reproduction, context: Context) -> str:
    """The sections behind it, and where all of it comes from."""
    blocks = [
        f"# {escape(reproduction.title)}: details",
        "What these sections come to stands on [the page itself](README.md).",
        *(_section(each, context) for each in reproduction.sections if each.details),
        *_end(reproduction, context, second=True),
    ]
    return "\n\n".join(block for block in blocks if block) + "\n"


def _end(reproduction: Reproduction, context: Context, *, second: bool) -> list[str]:
    """How to read the tables of a page, and on the last page where all comes from."""
    here = [each for each in reproduction.sections if each.details is second]
    words = [how_to_read(kind) for kind in dict.fromkeys(each.kind for each in here)]
    behind = [escape(each.title) for each in reproduction.sections if each.details]
    note = f"On the [second page]({DETAILS}): {'; '.join(behind)}; where all of it comes from."
    last = _provenance(reproduction, context) if second or not behind else note
    return [details("How to read these tables", *words), last]


def _front(reproduction: Reproduction, context: Context) -> list[str]:
    """What the first section of tables comes to; nothing without one."""
    for each in reproduction.sections:
        here = [name for name in each.experiments if name in context.results]
        if each.kind == TABLES and here:
            calibrated = cast(Calibrated, each.options["calibrated"])
            found = answers(context.results, here, context.experiments)
            return front(found, calibrated, context)
    return []


def _made_by(reproduction: Reproduction, context: Context) -> str:
    """Which command makes the page again, and how much it walks."""
    every = context.results.values()
    walked = sum(float(each.done[WALKED].sum()) for each in every if WALKED in each.done)
    trials = pd.concat([each.trials[["trial_id", "state"]] for each in every])
    done = int(trials.drop_duplicates("trial_id")["state"].isin(SCORED).sum())
    whole = len(context.results) == len(context.experiments) and trials["state"].isin(SCORED).all()
    counted = plural(done, "trial") + ("" if whole else " so far")
    return (
        f"Made again by {', then '.join(map(code, _commands(reproduction, context)))}: {counted}, "
        f"{walked / 3600.0:.1f} hours of walking simulated. Intervals are 95 % unless something "
        "else is said, and of the seeds alone, not of what was assumed."
    )


def _completeness(reproduction: Reproduction, context: Context) -> str:
    """What is missing and how to get it; empty when every planned trial is there."""
    parts = [text for each in reproduction.members for text in _lacking(each.name, context)]
    if not parts:
        return ""
    lines = "\n".join(f"- {part}" for part in parts)
    command = fenced(run_command(reproduction, context.store), "sh")
    return f"**Incomplete.** What is not there is counted nowhere.\n\n{lines}\n\n{command}"


def _lacking(name: str, context: Context) -> Iterator[str]:
    """What a member has no result of."""
    if name not in context.results:
        yield f"{escape(name)}: none of its trials is in the store"
        return
    states = context.results[name].trials["state"].value_counts()
    planned = int(states.sum())
    for state, verb in (("MISSING", "not in the store"), ("FAILED", "failed")):
        if state in states.index:
            yield f"{escape(name)}: {int(states[state])} of {planned} trials {verb}"


def _section(each: Section, context: Context) -> str:
    """A heading, the file's own words and what the section's kind makes of its members."""
    step(f"writing {each.title}")
    here = tuple(name for name in each.experiments if name in context.results)
    absent = [escape(name) for name in each.experiments if name not in here]
    note = f"Without {' and '.join(absent)}, of which nothing was run." if absent else ""
    text = section_text(replace(each, experiments=here), context) if here else ""
    return section(escape(each.title), each.text.strip(), note, text)


def _provenance(reproduction: Reproduction, context: Context) -> str:
    lines = "\n".join(_commands(reproduction, context))
    first = next(name for name in context.experiments if name in context.results)
    constants = command("report", [context.experiments[first]], context.store.path)
    head = ["member", "file SHA-256", "digest of all it resolves to", "trials", "done", "seeds"]
    rows = [_member_row(member, context) for member in context.experiments.values()]
    return section(
        "Provenance",
        facts_table(_facts(reproduction, context.results)),
        table(head, rows, "lllrrl"),
        f"This page again:\n\n{fenced(lines, 'sh')}",
        f"Constants, grounds and their sources: {code(constants)}; other members change what their "
        "files say.",
    )


def _facts(reproduction: Reproduction, results: Mapping[str, Results]) -> dict[str, str]:
    planned = sum(len(each.trials) for each in results.values())
    every = [record for each in results.values() for record in records(each)]
    return {
        f"reproduction {reproduction.name}": f"file SHA-256 {_file_digest(reproduction.path)}",
        "trials": (
            f"{plural(planned, 'planned trial')} of {plural(len(results), 'experiment')}; those "
            "that experiments share are walked once"
        ),
        "physics version": str(PHYSICS_VERSION),
        **{name.replace("_", " "): value for name, value in common_values(every).items()},
    }


def _member_row(member: Experiment, context: Context) -> list[str]:
    found = context.results.get(member.name)
    trials = [] if found is None else list(found.trials["state"])
    done = sum(state in SCORED for state in trials)
    return [
        escape(member.name),
        _file_digest(member.path),
        code(member.digest[:16]),
        str(len(trials)) if trials else "",
        str(done) if trials else "",
        seeds_text(_seeds(context, member.name)),
    ]


def _file_digest(path: Path) -> str:
    return code(hashlib.sha256(path.read_bytes()).hexdigest()[:16])
