"""What a reader of a study's HTML form opens: every candidate with its seeds, over every number.

One panel has the candidates in the order of the search, one each further objective, and one each
searched parameter, the most important first. Beside the candidates stand the combinations that
were walked again on fresh seeds.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from html import escape
from typing import ClassVar, NamedTuple

import pandas as pd

from gaitlab.experiment import Value
from gaitlab.experiment.study import Choices
from gaitlab.render.figure_style import CYCLE
from gaitlab.report.falls import SHOWN_METRICS, shown_values
from gaitlab.report.forms.explorer import COLOURS, ON_DARK, Explorer, ended, measure, rounded
from gaitlab.report.representative import shortened
from gaitlab.report.study.figures import KINDS, kind_of, objective_of
from gaitlab.report.study.findings import Findings
from gaitlab.report.study.fresh import score, stable_of
from gaitlab.report.study.words import (
    better,
    number,
    objective_axis,
    objective_text,
    short_paths,
    value,
    with_unit,
)
from gaitlab.report.words import percent, plural, surface_text
from gaitlab.search.fresh import WINNER, Rerun
from gaitlab.statistics import wilson
from gaitlab.store import Store

AGAIN = "on fresh seeds"
BEST = "best"  # kind of the candidate that won
SYMBOLS = {BEST: "star", "done": "circle", "broken": "circle-open", "pruned": "x-thin-open"}
OTHERS = ("square", "diamond", "triangle-up")  # of what was walked again


class _Point(NamedTuple):
    """A candidate, or a combination that was walked again."""

    title: str
    kind: str
    order: int | None
    values: dict[str, Value | None]
    objectives: list[float]
    stable: tuple[int, int]
    trials: Sequence[str]
    text: str


@dataclass(frozen=True, kw_only=True, eq=False)
class StudyExplorer(Explorer):
    """The candidates and trials of a study.

    Attributes:
        findings: What the page was computed from.
        store: Where the trials are.
    """

    picture: ClassVar[str] = "history"
    findings: Findings
    store: Store

    def data(self) -> dict[str, object]:
        """Axes, candidates and their trials."""
        findings, kinds = self.findings, self._kinds
        objectives = findings.study.objectives
        trials = self._trials()
        return {
            "axes": list(self._axes()),
            "variants": list(kinds.values()),
            "symbols": [self._symbol(kind) for kind in kinds],
            "colours": {"light": CYCLE[:COLOURS], "dark": ON_DARK},
            "cells": [self._cell(point, list(kinds)) for point in self._points],
            "scores": [
                {
                    "name": str(place),
                    "title": objective_axis(one),
                    "meaning": f"{objective_text(one, len(findings.grounds)).capitalize()}; "
                    f"{better(one)} is better. A point opens its seeds.",
                }
                for place, one in enumerate(objectives)
            ],
            "measures": [measure(name) for name in self._metrics],
            "options": self.options,
            "trials": trials,
        }

    def below(self) -> str:
        """Every candidate as a table, whose first column opens its seeds."""
        findings, paths = self.findings, self._paths
        names = short_paths(paths)
        head = [
            "candidate",
            *map(objective_axis, findings.study.objectives),
            "stable seeds",
            "ended",
            *(with_unit(names[path], findings.unit(path)) for path in paths),
        ]
        rows = []
        for place, point in enumerate(self._points):
            up, n = point.stable
            cells = [
                *map(number, point.objectives),
                f"{up} of {n}" if n else "\u2014",
                self._kinds[point.kind],
                *(value(point.values[path]) for path in paths),
            ]
            texts = "".join(
                f'<td data-label="{escape(title)}"><div>{escape(cell)}</div></td>'
                for title, cell in zip(head[1:], cells, strict=True)
            )
            button = (
                f'<button type="button" class="cell" data-cell="{place}" aria-haspopup="dialog">'
            )
            title = escape(point.title.removeprefix("Candidate "))
            rows.append(f'<tr><th scope="row">{button}{title}</button></th>{texts}</tr>')
        titles = "".join(f'<th scope="col">{escape(title)}</th>' for title in head)
        return (
            f"<details>\n<summary>All {plural(len(findings.candidates), 'candidate')} as a table"
            '</summary>\n<div class="scroll" tabindex="0" role="region" aria-label="Candidates">\n'
            f'<table class="wide">\n<thead><tr>{titles}</tr></thead>\n<tbody>\n{"".join(rows)}\n'
            "</tbody>\n</table>\n</div>\n</details>\n"
        )

    @property
    def _paths(self) -> list[str]:
        """Searched parameters, the most important for the first objective first."""
        shares = self.findings.importance[0] if self.findings.importance else {}
        paths = [item.path for item in self.findings.study.search]
        return sorted(paths, key=lambda path: -shares.get(path, 0.0))

    def _axes(self) -> Iterator[dict[str, object]]:
        findings, paths = self.findings, self._paths
        shares = findings.importance[0] if findings.importance else {}
        names = short_paths(paths)
        yield {"name": "the search", "title": "candidate"}
        for one in findings.study.objectives[1:]:
            yield {"name": objective_axis(one), "title": f"{better(one)} is better"}
        for path in paths:
            item = findings.parameter(path)
            share = f"importance {percent(100.0 * shares[path])}" if path in shares else ""
            axis: dict[str, object] = {
                "name": share,
                "title": with_unit(names[path], findings.unit(path)),
            }
            if isinstance(item, Choices):
                axis["ticks"] = [value(option) for option in item.options]
            else:
                axis["log"] = item.log
            yield axis

    @cached_property
    def _points(self) -> list[_Point]:
        return [*self._candidates(), *map(self._again, self.findings.reruns)]

    def _candidates(self) -> Iterator[_Point]:
        findings, outcomes = self.findings, self._outcomes
        count, winner = len(findings.study.objectives), findings.chosen
        for one in findings.candidates:
            won = winner is not None and one.number == winner.number
            there = outcomes[outcomes["trial_id"].isin(one.trial_ids)]
            done = there[there["state"].isin(("DONE", "INFEASIBLE"))]
            up = int(done["stable"].eq(True).sum()) if "stable" in done else 0
            yield _Point(
                title=f"Candidate {one.number}" + (", the winner" if won else ""),
                kind=BEST if won else kind_of(one),
                order=one.number,
                values={path: one.values.get(path) for path in self._paths},
                objectives=[objective_of(one, place) for place in range(count)],
                stable=(up, len(done)),
                trials=one.trial_ids,
                text=one.reason,
            )

    def _again(self, found: Rerun) -> _Point:
        findings, walks = self.findings, found.on(self.findings.grounds)
        count, own = len(findings.study.objectives), found.label == WINNER
        known = findings.chosen.values if own and findings.chosen else found.values
        return _Point(
            title=f"{found.label.capitalize()} {AGAIN}",
            kind=found.label,
            order=None,
            values={p: known.get(p, findings.defaults.get(p)) for p in self._paths},
            objectives=[
                score(findings.study, walks, place).value if walks else math.nan
                for place in range(count)
            ],
            stable=stable_of(walks),
            trials=[walk.trial_id for walk in walks],
            text="",
        )

    @cached_property
    def _kinds(self) -> dict[str, str]:
        """What the legend calls each kind of point that there is."""
        every = {kind: look.label for kind, look in KINDS.items()} | {BEST: "winner in the search"}
        every |= {one.label: f"{one.label} {AGAIN}" for one in self.findings.reruns}
        there = {point.kind for point in self._points}
        return {kind: label for kind, label in every.items() if kind in there}

    def _symbol(self, kind: str) -> str:
        labels = [one.label for one in self.findings.reruns]
        if kind in labels:
            return OTHERS[labels.index(kind) % len(OTHERS)]
        return SYMBOLS.get(kind, "line-ns-open")

    def _cell(self, point: _Point, kinds: Sequence[str]) -> dict[str, object]:
        findings, (up, n) = self.findings, point.stable
        names = short_paths(self._paths)
        known = {p: v for p, v in point.values.items() if v is not None}
        given = [f"{names[p]} {value(v, findings.unit(p))}" for p, v in known.items()]
        told = [
            f"{objective_axis(one)} {number(found)}"
            for one, found in zip(findings.study.objectives, point.objectives, strict=True)
        ]
        return {
            "title": point.title,
            "place": [kinds.index(point.kind), 0, 0],
            "at": [
                point.order,
                *rounded(point.objectives[1:]),
                *map(self._place, point.values.items()),
            ],
            "values": {str(k): found for k, found in enumerate(rounded(point.objectives))},
            "given": given,
            "text": " ".join(
                f"{part}." for part in ("; ".join([*told, *given]), point.text) if part
            ),
            "stable": up,
            "n": n,
            "interval": list(wilson(up, n)) if n else None,
            "stands": True,
        }

    def _place(self, searched: tuple[str, Value | None]) -> float | int | None:
        """Where a value stands on its axis."""
        path, found = searched
        item = self.findings.parameter(path)
        if isinstance(item, Choices):
            return item.options.index(found) if found in item.options else None
        return None if found is None or isinstance(found, str) else rounded([float(found)])[0]

    @cached_property
    def _outcomes(self) -> pd.DataFrame:
        """What became of every trial, a row each."""
        ids = [trial for one in self.findings.candidates for trial in one.trial_ids]
        again = [walk.trial_id for one in self.findings.reruns for walk in one.walks]
        return self.store.outcomes([*ids, *again])

    @property
    def _metrics(self) -> list[str]:
        asked = [one.metric for one in self.findings.study.objectives]
        every = dict.fromkeys([*asked, *SHOWN_METRICS])
        return [name for name in every if name in self._outcomes.columns]

    def _trials(self) -> dict[str, object]:
        """Every trial of every candidate, a list a quantity."""
        rows = self._outcomes.assign(row=range(len(self._outcomes))).set_index("trial_id")["row"]
        pairs = [
            (place, int(rows[trial]))
            for place, point in enumerate(self._points)
            for trial in point.trials
            if trial in rows.index
        ]
        table = self._outcomes.iloc[[row for _, row in pairs]]
        ids = [str(name) for name in table["trial_id"]]
        grounds = [surface_text(str(name)) for name in table["surface"]]
        times = table["time_to_fall"] if "time_to_fall" in table else [math.nan] * len(ids)
        return {
            "cell": [place for place, _ in pairs],
            "seed": [int(seed) for seed in table["seed"]],
            "id": shortened(ids, ids),
            "ended": [ended({"fell": False, **row}) for row in table.to_dict("records")],
            "more": {"ground": grounds} if len(set(grounds)) > 1 else {},
            "time": rounded(pd.to_numeric(pd.Series(times), errors="coerce")),
            "values": {name: rounded(shown_values(name, table[name])) for name in self._metrics},
            "replay": [self.replays.get(name) for name in ids],
        }
