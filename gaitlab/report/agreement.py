"""How far two physics engines agree: the same cells and seeds in both, verdict by verdict."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

from gaitlab.experiment.experiment import ENGINE
from gaitlab.report.comparison import difference
from gaitlab.report.markdown import escape, table
from gaitlab.report.matching import matched_by
from gaitlab.report.results import Results
from gaitlab.report.scores import ScoredCell, cell_of
from gaitlab.report.variants import Value
from gaitlab.report.words import interval, letter, path_text, percent, plural, with_unit
from gaitlab.statistics import Contrast, judged, wilson

MOST_LISTED = 40  # cells that are told differently; more fill a page and tell nothing new
HOW_TO_READ = """\
A cell is stable when at least half of its seeds stay up. An engine draws the same friction, servos,
pose and lawn for a seed as the other, so runs are pairs of equal cell and seed."""


@dataclass(frozen=True, kw_only=True)
class EngineCell:
    """One cell in both engines.

    Attributes:
        values: What tells it from the others, by the paths of `Agreement.paths`.
        first: Its runs in the first engine.
        second: The same seeds in the second.
    """

    values: tuple[Value, ...]
    first: ScoredCell
    second: ScoredCell

    @property
    def verdicts(self) -> tuple[bool, bool]:
        """Whether it is stable in each."""
        return bool(self.first.verdict()), bool(self.second.verdict())

    @property
    def opposed(self) -> bool:
        """Whether all seeds stay up in one engine and none in the other."""
        shares = {self.first.share(), self.second.share()}
        return shares == {0.0, 1.0}


@dataclass(frozen=True, kw_only=True, eq=False)
class Agreement:
    """Two engines, cell by cell.

    Attributes:
        engines: Their names, the first planned one first.
        paths: Columns that tell the cells apart.
        cells: The cells that both have walked, with the seeds that both have walked.
        pairs: Runs of equal cell and seed: how many stayed up in (first, second).
        stable: The paired difference of the shares that stay up.
    """

    engines: tuple[str, str]
    paths: tuple[str, ...]
    cells: tuple[EngineCell, ...]
    pairs: Counter[tuple[bool, bool]]
    stable: Contrast

    @property
    def verdicts(self) -> Counter[tuple[bool, bool]]:
        """Cells by their verdicts in (first, second)."""
        return Counter(cell.verdicts for cell in self.cells)

    @property
    def differing(self) -> list[EngineCell]:
        """Cells with another verdict in each."""
        return [cell for cell in self.cells if len(set(cell.verdicts)) > 1]


def agreement(results: Results) -> Agreement | None:
    """How far the two engines of a page agree; None where it has one, or no runs in common."""
    trials = results.trials
    engines = list(dict.fromkeys(trials[ENGINE])) if ENGINE in trials.columns else []
    if len(engines) != 2:
        return None
    paths = [
        name
        for name in map(str, trials.columns)
        if ("." in name or name in ("surface", "robot", "experiment"))
        and name != ENGINE
        and trials[name].nunique(dropna=False) > 1
    ] or ["surface"]
    both = matched_by(trials, ENGINE, (engines[0], engines[1]), paths)
    if not both.n or not both.paired:
        return None
    sides = [dict(iter(side.groupby("cell", sort=False))) for side in (both.first, both.second)]
    cells = [
        EngineCell(
            values=tuple(first[path].iloc[0] for path in paths),
            first=cell_of(first),
            second=cell_of(sides[1][number]),
        )
        for number, first in sides[0].items()
    ]
    stable = [cell_of(side).stable for side in (both.first, both.second)]
    (told,) = judged([both.contrast("stable")])
    return Agreement(
        engines=(str(engines[0]), str(engines[1])),
        paths=tuple(paths),
        cells=tuple(cells),
        pairs=Counter(zip(*stable, strict=True)),
        stable=told,
    )


def agreement_sentence(found: Agreement) -> str:
    """In how many cells the engines agree, in a sentence for the first page."""
    n, equal = len(found.cells), len(found.cells) - len(found.differing)
    opposed = sum(cell.opposed for cell in found.cells)
    extremes = (
        f"{plural(opposed, 'cell')} of them at opposite ends, all seeds against none"
        if opposed
        else "none of the others has all seeds up in one and none in the other"
    )
    return (
        f"**{_names(found)} agree in {equal} of {plural(n, 'cell')}** "
        f"({percent(100 * equal / n)} {interval(wilson(equal, n), 100)})"
        + (f", {extremes}." if equal < n else ".")
    )


def agreement_blocks(results: Results, found: Agreement) -> list[str]:
    """Both confusion tables, the paired difference, and every cell that is told differently."""
    runs = found.pairs.total()
    same = found.pairs[True, True] + found.pairs[False, False]
    return [
        agreement_sentence(found),
        f"Cells by verdict (n = {len(found.cells)}):",
        _confusion(found, found.verdicts),
        f"Runs of equal cell and seed (n = {runs}; {same} end alike, "
        f"{percent(100 * same / runs)} {interval(wilson(same, runs), 100)}):",
        _confusion(found, found.pairs),
        f"Stable runs in {found.engines[1]} against {found.engines[0]}: "
        f"{difference(found.stable)} over {plural(runs, 'pair')}, {found.stable.verdict}.",
        *_differing(results, found),
        HOW_TO_READ,
    ]


def _names(found: Agreement) -> str:
    return " and ".join(escape(name) for name in found.engines)


def _confusion(found: Agreement, counts: Counter[tuple[bool, bool]]) -> str:
    first, second = map(escape, found.engines)
    head = ["", f"{second}: stable", f"{second}: not stable"]
    rows = [
        [f"{first}: {word}", *(str(counts[here, there]) for there in (True, False))]
        for here, word in ((True, "stable"), (False, "not stable"))
    ]
    return table(head, rows, "lrr")


def _differing(results: Results, found: Agreement) -> list[str]:
    cells = found.differing
    if not cells:
        return []
    rows = [
        [
            *(
                escape(with_unit(results, path, value))
                for path, value in zip(found.paths, cell.values, strict=True)
            ),
            *(_counted(side) for side in (cell.first, cell.second)),
        ]
        for cell in cells[:MOST_LISTED]
    ]
    head = [*(escape(path_text(path)) for path in found.paths), *map(escape, found.engines)]
    rest = len(cells) - len(rows)
    return [
        "Told differently:",
        table(head, rows, "l" * len(found.paths) + "rr"),
        f"And {plural(rest, 'further cell')}." if rest else "",
    ]


def _counted(cell: ScoredCell) -> str:
    return (
        f"{letter(bool(cell.verdict()))} {cell.count()}/{cell.n} {interval(cell.interval(), 100)}"
    )
