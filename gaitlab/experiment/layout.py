"""How an experiment's results are laid out: the section `report:`, checked and filled in."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from gaitlab.documents import Node
from gaitlab.errors import FileError, Problem, UnknownName
from gaitlab.experiment.axes import Axis
from gaitlab.experiment.design import box_paths
from gaitlab.experiment.reference import load_reference
from gaitlab.experiment.reference import names as reference_names
from gaitlab.experiment.schema import ReportSettings, Sections
from gaitlab.metrics import numeric_names
from gaitlab.plugins import suggestion


def read_layout(tree: Node, sections: Sections, axes: Sequence[Axis]) -> ReportSettings:
    """Report settings with title and rows filled in.

    Raises:
        FileError: If a path is not varied, a metric is unknown or a word, or no reference table
            has that name or that reading.
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
    problems += _reference_problems(node)
    problems = problems or [*_used_twice(node, report), *_no_pairs(node)]
    if problems:
        raise FileError(problems)
    return report


def _allowed(varied: Sequence[str]) -> dict[str, Sequence[str]]:
    """Names that each key of the section takes."""
    paths = ["surface", *varied]
    return {
        "rows": paths,
        "columns": paths,
        "variants": varied,
        "metrics": numeric_names(),
        "maps": paths,
    }


def _reference_problems(node: Node) -> list[Problem]:
    """An unknown reference table, or a reading that it has not."""
    compare, reading = (node.mapping.get(key) for key in ("compare", "distance_reading"))
    named = [str(compare.value)] if compare is not None and compare.value is not None else []
    try:
        tables = [load_reference(name, node.folder) for name in named or reference_names()]
    except UnknownName as error:
        return [compare.problem(f"report.compare: {error}")] if compare is not None else []
    known = list(dict.fromkeys(name for table in tables for name in table.readings))
    if reading is None or reading.value in known:
        return []
    message = f"report.distance_reading: found {reading.found()}"
    return [reading.problem(f"{message}{suggestion(str(reading.value), known)}")]


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
