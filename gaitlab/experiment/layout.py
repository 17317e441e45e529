"""How an experiment's results are laid out: the section `report:`, checked and filled in."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from gaitlab.documents import Node
from gaitlab.errors import FileError, Problem
from gaitlab.experiment.axes import Axis
from gaitlab.experiment.design_reading import box_paths
from gaitlab.experiment.schema import ReportSettings, Sections
from gaitlab.metrics import numeric_names
from gaitlab.plugins import PACKAGE, suggestion


def read_layout(tree: Node, sections: Sections, axes: Sequence[Axis]) -> ReportSettings:
    """Report settings with title and rows filled in.

    Raises:
        FileError: If a path is not varied, a metric is unknown or a word, or no published table
            has that name.
    """
    varied = [path for axis in axes for path in axis.paths]
    node = tree.mapping.get("report", tree)
    report = sections.report
    elsewhere = {report.columns, *report.variants, *dict(box_paths(sections.design))}
    free = (path for path in varied if path not in elsewhere)
    rows = report.rows or next(free, "surface")
    report = replace(report, rows=rows, title=report.title or sections.title)
    problems = [
        problem
        for key, allowed in _allowed(varied).items()
        for problem in _unknown(node, key, allowed)
    ]
    problems = problems or [*_used_twice(node, report), *_no_pairs(node)]
    if problems:
        raise FileError(problems)
    return report


def _allowed(varied: Sequence[str]) -> dict[str, Sequence[str]]:
    """Names that each key of the section takes."""
    paths = ["surface", *varied]
    tables = sorted(
        file.stem for file in (PACKAGE / "papers" / "printed").glob("*.csv") if _of_cells(file)
    )
    return {
        "rows": paths,
        "columns": paths,
        "variants": varied,
        "compare": tables,
        "metrics": numeric_names(),
        "maps": paths,
    }


def _of_cells(table: Path) -> bool:
    """Whether a published table says which cells were stable."""
    with table.open(encoding="utf-8") as lines:
        return "pedestal_1" in next(lines, "").split(",")


def _unknown(report: Node, key: str, allowed: Sequence[str]) -> list[Problem]:
    node = report.mapping.get(key)
    return [
        item.problem(f"report.{key}: found {item.found()}{suggestion(str(item.value), allowed)}")
        for item in (_leaves(node) if node else ())
        if item.value not in (*allowed, (), None)
    ]


def _leaves(node: Node) -> list[Node]:
    """The values of a list of lists, or the value itself."""
    return [leaf for item in node.items for leaf in _leaves(item)] if node.items else [node]


def _used_twice(node: Node, report: ReportSettings) -> list[Problem]:
    """A path can be the rows, the columns or a variant, not two of them."""
    problems = []
    rows, variants = node.mapping.get("rows"), node.mapping.get("variants", node)
    if rows is not None and report.rows == report.columns:
        message = f"report.rows: found {report.rows!r}, which is the columns already"
        problems.append(rows.problem(f"{message}; choose another path for one of them"))
    for path in report.variants:
        if path in (report.rows, report.columns):
            message = f"report.variants: found {path!r}, which is the rows or columns already"
            problems.append(variants.problem(f"{message}; leave it out"))
    return problems


def _no_pairs(report: Node) -> list[Problem]:
    """Maps that do not have two different axes."""
    maps = report.mapping.get("maps")
    return [
        pair.problem(
            f"report.maps: found {_listed(pair)}; a map has two different paths, "
            "[gait.step_length, surface] for instance"
        )
        for pair in (maps.items if maps else ())
        if len({item.value for item in pair.items}) != 2 or len(pair.items) != 2
    ]


def _listed(node: Node) -> str:
    """A list as it is written."""
    return f"[{', '.join(str(item.value) for item in node.items)}]" if node.items else node.found()
