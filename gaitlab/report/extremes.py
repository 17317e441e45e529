"""The best and the worst trial of a page, and the command that shows each."""

from __future__ import annotations

from collections.abc import Sequence

import pandas as pd

from gaitlab.report.markdown import code, escape, fenced, section, table
from gaitlab.report.results import Results
from gaitlab.report.telling import extremes
from gaitlab.report.words import NOTHING, place_text

SHORTEST = 8  # hex digits of a trial's name


def extremes_section(results: Results, options: str = "") -> str:
    """Best and worst trial with the commands that replay them; empty if nothing was simulated.

    Args:
        results: What was simulated.
        options: What the commands need besides the trial, ` --store DIR` for instance.
    """
    found = list(extremes(results))
    if not found:
        return ""
    names = [str(trial["trial_id"]) for _, trial in found]
    short = shortened(names, results.trials["trial_id"])
    header = ["", "trial", "variant", "cell", "seed", "distance [m]", "time to fall [s]"]
    rows = [
        _row(results, what, trial, name) for (what, trial), name in zip(found, short, strict=True)
    ]
    if len(results.variants) < 2:
        header.remove("variant")
        rows = [row[:2] + row[3:] for row in rows]
    lines = [f"gaitlab replay {name}{options} --output {name}.gif" for name in short]
    watch = f"To watch them:\n\n{fenced(chr(10).join(lines), 'sh')}"
    return section("Best and worst", table(header, rows, "lll"), watch)


def shortened(names: Sequence[str], known: pd.Series) -> list[str]:
    """The first digits of each name, as many as tell it from every known one."""
    others = [str(name) for name in known]
    return [_short(name, others) for name in names]


def _short(name: str, others: Sequence[str]) -> str:
    for length in range(SHORTEST, len(name)):
        if sum(other.startswith(name[:length]) for other in others) < 2:
            return name[:length]
    return name


def _row(results: Results, what: str, trial: pd.Series, name: str) -> list[str]:
    return [
        what,
        code(name),
        escape(str(trial["variant"])),
        escape(place_text(results, trial[results.rows], trial[results.columns])),
        str(int(trial["seed"])),
        _number(trial["distance"]),
        _number(trial["time_to_fall"]),
    ]


def _number(value: object) -> str:
    number = pd.to_numeric(value, errors="coerce")
    return NOTHING if pd.isna(number) else f"{float(number):.3g}"
