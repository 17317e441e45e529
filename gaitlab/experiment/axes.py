"""What an experiment varies: `design`, `grid`, `zip`, `one_at_a_time` as axes that multiply."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice, product
from math import isclose
from types import MappingProxyType

from gaitlab.documents import Node, checked, typed_number
from gaitlab.errors import FileError, GaitlabError, Problem, WrongValue
from gaitlab.experiment.parts import GROUPS, Parts, Value, changed, changes_of, owned
from gaitlab.experiment.schema import Sections
from gaitlab.parameters import fragment
from gaitlab.plugins import shown

ROUNDING = 1e-9  # relative; two values of a list that differ by less are one
MOST_COMPARED = 200  # combinations of grounds that are looked at for equal ones
MOST_TRIED = 2000  # combinations of one part that are tried before anything runs


@dataclass(frozen=True, kw_only=True)
class Axis:
    """Paths that take their values together.

    Attributes:
        paths: Dotted paths.
        rows: Values of the paths, row by row.
    """

    paths: tuple[str, ...]
    rows: tuple[tuple[Value, ...], ...]


@dataclass(frozen=True, kw_only=True)
class VariedColumn:
    """A path and its list, as written."""

    section: str
    path: str
    key: Node
    values: Node


def varied_columns(
    sections: Sections, swept: Iterable[tuple[str, Node]] = ()
) -> list[VariedColumn]:
    """Every path with a list of values, in the order of the file.

    Args:
        sections: The file's sections.
        swept: Paths that the section `design` moves, with the places of their keys.

    Raises:
        FileError: If a section has another form, a list is empty or a path is varied twice.
    """
    columns = [
        column
        for name in ("grid", "zip", "one_at_a_time")
        for part in _mappings(name, getattr(sections, name))
        for column in _columns(name, part)
    ]
    problems = [problem for column in columns for problem in _list_problems(column)]
    listed = [(column.section, column.path, column.key) for column in columns]
    problems += _twice([*listed, *(("design", path, key) for path, key in swept)])
    if problems:
        raise FileError(problems)
    return columns


def first_values(columns: list[VariedColumn]) -> dict[str, Node]:
    """First value of every varied path."""
    return {column.path: column.values.items[0] for column in columns}


def _mappings(name: str, node: Node | None) -> tuple[Node, ...]:
    """The mappings of a section; `zip` may be a list of them."""
    if node is None:
        return ()
    parts = node.items if name == "zip" and isinstance(node.value, tuple) else (node,)
    for part in parts:
        if not part.mapping:
            what = "nothing" if part.value in (None, {}, ()) else part.found()
            message = (
                f"{name}: found {what}; expected lines of the form "
                "`gait.step_length: [0.02, 0.04]`, or leave the section out"
            )
            raise FileError([part.problem(message)])
    return parts


def _columns(name: str, part: Node) -> Iterator[VariedColumn]:
    for path, values in part.mapping.items():
        yield VariedColumn(section=name, path=path, key=part.keys[path], values=values)


def _list_problems(column: VariedColumn) -> Iterator[Problem]:
    where = f"{column.section}: {column.path}"
    found = column.values.found()
    if column.values.mapping:
        inner = f"{column.path}.{next(iter(column.values.mapping))}"
        yield column.values.problem(
            f"{where}: found {found}; expected a list of values under a dotted path, "
            f"`{inner}: [...]` for instance"
        )
    elif not isinstance(column.values.value, tuple):
        text = column.values.value if isinstance(column.values.value, str) else found
        shown = typed_number(text)[0] or text
        yield column.values.problem(f"{where}: found {found}; expected a list, [{shown}]")
    elif not column.values.items:
        yield column.values.problem(f"{where}: an empty list; write at least one value")


def _twice(varied: Iterable[tuple[str, str, Node]]) -> Iterator[Problem]:
    """Paths that two places vary, of section, path and the place of its key."""
    seen: dict[str, str] = {}
    for section, path, key in varied:
        if path in seen:
            message = f"{path} is varied twice, under {seen[path]} and {section}; keep one of them"
            yield key.problem(message)
        seen.setdefault(path, section)


def read_axes(
    sections: Sections,
    parts: Parts,
    columns: list[VariedColumn],
    swept: Axis | None = None,
    places: Mapping[str, Node] = MappingProxyType({}),
) -> tuple[Axis, ...]:
    """Axes of the experiment, every value checked like the field it stands for.

    Args:
        sections: The file's sections.
        parts: What the paths change.
        columns: Every path with a list of values.
        swept: Points of the section `design`; the slowest axis, so that a run that is stopped
            early leaves whole points.
        places: Keys of the paths that the section moves.

    Raises:
        FileError: All mistakes.
    """
    problems: list[Problem] = []
    values = {column.path: tuple(_values(column, parts, problems)) for column in columns}
    problems += _unequal(sections, values)
    if problems:
        raise FileError(problems)
    grid = [_single(path, values[path]) for path in _paths(sections.grid)]
    zips = [_together(part, values) for part in _mappings("zip", sections.zip)]
    axes = [*([swept] if swept else []), *grid, *zips]
    if sections.one_at_a_time is not None:
        paths = _paths(sections.one_at_a_time)
        axes.append(checked(sections.one_at_a_time, lambda: _one_at_a_time(paths, parts, values)))
    keys = {column.path: column.key for column in columns} | dict(places)
    problems += _impossible(parts, axes, keys)
    if not problems:
        problems += _same_grounds(parts, axes, keys, sections.surfaces)
    if problems:
        raise FileError(problems)
    return tuple(axes)


def _same_grounds(
    parts: Parts, axes: Sequence[Axis], keys: Mapping[str, Node], listed: Node
) -> Iterator[Problem]:
    """Grounds of equal numbers: their trials would be the same ones under two names."""
    touching = [axis for axis in axes if any(p.startswith("surface.") for p in axis.paths)]
    for values in islice(combinations(touching), MOST_COMPARED):
        changes = changes_of("surface", values)
        known: dict[tuple[str, str], str] = {}
        for name, ground in parts.surfaces.items():
            made = changed(ground, owned(ground, changes))
            other = known.setdefault((made.type, fragment(made)), name)
            if other != name:
                where = ", ".join(f"surface.{path} = {v}" for path, v in changes.items())
                where = f" at {where}" if where else ""
                place = keys[next(iter(touching[0].paths))] if where else listed
                yield place.problem(
                    f"surfaces: {other} and {name} are the same ground{where}, for all "
                    "their numbers are equal, and would share every trial; change one of them or "
                    "leave it out"
                )
                return


def _paths(node: Node | None) -> tuple[str, ...]:
    return () if node is None else tuple(node.mapping)


def _values(column: VariedColumn, parts: Parts, problems: list[Problem]) -> Iterator[Value]:
    """Checked values of a path; mistakes go to `problems`."""
    try:
        parts.parameter(column.path, everywhere=True)
    except WrongValue as error:
        problems.append(column.key.problem(f"{column.section}: {error}"))
        return
    seen: set[Value] = set()
    for node in column.values.items:
        try:
            value = parts.check(column.path, node)
        except FileError as error:
            problems += error.problems
            continue
        if value in seen and column.section != "zip":
            problems.append(node.problem(f"{column.path}: {value} is listed twice; keep one"))
        problems += nearly_listed(node, column.path, value, seen)
        others = {shown(other) for other in seen - {value} if isinstance(other, str)}
        if isinstance(value, str) and shown(value) in others:
            message = f"{column.path}: results would call two files {shown(value)}; rename one"
            problems.append(node.problem(message))
        seen.add(value)
        yield value


def nearly_listed(node: Node, path: str, value: Value, listed: Iterable[Value]) -> list[Problem]:
    """A value that differs from another by no more than rounding: two cells that look alike."""
    close = [other for other in listed if other != value and _nearly_equal(other, value)]
    return [
        node.problem(
            f"{path}: {value!r} and {other!r} differ by rounding only, and would be two cells that "
            "look alike; keep one"
        )
        for other in close[:1]
    ]


def _nearly_equal(one: Value, other: Value) -> bool:
    numbers = all(isinstance(v, int | float) and not isinstance(v, bool) for v in (one, other))
    return numbers and isclose(float(one), float(other), rel_tol=ROUNDING)


def _unequal(sections: Sections, values: Mapping[str, tuple[Value, ...]]) -> Iterator[Problem]:
    for part in _mappings("zip", sections.zip):
        lengths = {path: len(part.mapping[path].items) for path in part.mapping}
        if len(set(lengths.values())) > 1:
            found = ", ".join(f"{path} has {n}" for path, n in lengths.items())
            yield part.problem(f"zip: lists that move together are equally long; {found}")


def _single(path: str, values: tuple[Value, ...]) -> Axis:
    return Axis(paths=(path,), rows=tuple((value,) for value in values))


def _together(part: Node, values: Mapping[str, tuple[Value, ...]]) -> Axis:
    paths = tuple(part.mapping)
    rows = tuple(zip(*(values[path] for path in paths), strict=True))
    return Axis(paths=paths, rows=rows)


def _one_at_a_time(
    paths: tuple[str, ...], parts: Parts, values: Mapping[str, tuple[Value, ...]]
) -> Axis:
    """The base once, then every path through its values while the others keep the base."""
    centre = tuple(_base_value(parts, path) for path in paths)
    rows = [centre]
    for index, path in enumerate(paths):
        moved = [value for value in values[path] if value != centre[index]]
        if any(_nearly_equal(value, centre[index]) for value in moved):
            raise WrongValue(
                f"one_at_a_time: {path}: {moved} has a value that differs from the base, "
                f"{centre[index]!r}, by rounding only, and would be a cell that looks alike; leave "
                "it out"
            )
        rows += [(*centre[:index], value, *centre[index + 1 :]) for value in moved]
    return Axis(paths=paths, rows=tuple(rows))


def _base_value(parts: Parts, path: str) -> Value:
    found = parts.base_values(path)
    if len(found) > 1:
        raise WrongValue(
            f"one_at_a_time: {path} has no single base, it is {' and '.join(map(str, found))}; "
            "put it under grid"
        )
    return found[0]


def _impossible(parts: Parts, axes: list[Axis], keys: Mapping[str, Node]) -> list[Problem]:
    """Combinations that a robot, gait, ground or servo itself refuses, one of each group."""
    return [keys[path].problem(reason) for path, reason in refusals(parts, axes)]


def refusals(parts: Parts, axes: Sequence[Axis]) -> Iterator[tuple[str, str]]:
    """Path and reason of a combination that the part itself refuses, one of each group."""
    for group in GROUPS:
        touching = [axis for axis in axes if any(p.startswith(f"{group}.") for p in axis.paths)]
        for values in islice(combinations(touching), MOST_TRIED if touching else 0):
            changes = {path: v for path, v in values.items() if path.startswith(f"{group}.")}
            try:
                parts.try_out(group, changes)
            except (GaitlabError, ValueError, ArithmeticError) as error:
                shown = ", ".join(f"{path} = {value}" for path, value in changes.items())
                yield next(iter(changes)), f"{shown}: {error}"
                break


def combinations(axes: Sequence[Axis]) -> Iterator[dict[str, Value]]:
    """Values by dotted path of every combination, the last axis moves fastest."""
    for rows in product(*(axis.rows for axis in axes)):
        yield {
            path: value
            for axis, row in zip(axes, rows, strict=True)
            for path, value in zip(axis.paths, row, strict=True)
        }
