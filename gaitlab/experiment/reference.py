"""Reference tables: what somebody else found, cell by cell, to stand beside results of ours.

`report: {compare: ./outdoors_2025.yaml}` names a file beside the experiment; those of
`experiments/references` are called by their name. Such a file holds

title: Table 7                     what a page calls it
source: A. Author, A Title, 2018
note: text                         what a reader has to know of it
rows: gait.step_length             dotted path whose values its rows are
readings:                          what a row that is printed as 1 can mean, the first by default
  cm: {one: 0.01, text: the step length in cm}
printed: [0, 4, -4]                its rows as they are printed
cells: {carpet_4mm: [S, S, U]}     on each ground, stable or unstable in each row
stated: {carpet_4mm: 66}           percentages that its text states
stated_mean: 66                    and their mean
variant: {gait.heel_strike: [none]}    values that its walks had
others: [eros_table8]              tables of other variants, for experiments with several
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Literal, NamedTuple

from gaitlab.documents import build, load
from gaitlab.errors import FileError, UnknownName
from gaitlab.parameters import parameter
from gaitlab.plugins import folders, is_file_name, suggestion
from gaitlab.statistics import efficiency, stability_percent

FOLDER = "references"  # below every folder of experiments
EXACT = 1e-6  # of a printed numeral, rounding of a value that stands for it


class ReferenceCell(NamedTuple):
    """A cell of a reference table: its row as printed, below zero for backward, and its ground."""

    printed: float
    surface: str

    @property
    def direction(self) -> str:
        """`forward` or `backward`."""
        return "backward" if self.printed < 0.0 else "forward"

    @property
    def distance(self) -> float:
        """The row as printed, without its direction."""
        return abs(self.printed)


@dataclass(frozen=True, kw_only=True)
class Reading:
    """What the rows of a table can mean.

    Attributes:
        one: Value of the path `rows` where 1 is printed.
        text: The same in words.
    """

    one: float = parameter(unit="-", doc="value of the path `rows` where 1 is printed")
    text: str = parameter(unit="-", doc="what a printed number is, in words")


@dataclass(frozen=True, kw_only=True)
class _Content:
    """Keys of the file."""

    title: str = parameter(unit="-", doc="what a page calls it")
    source: str = parameter(unit="-", doc="where it comes from")
    note: str = parameter("", unit="-", doc="what a reader has to know of it")
    rows: str = parameter(unit="-", doc="dotted path whose values its rows are")
    readings: dict[str, dict[str, float | str]] = parameter(
        unit="-", doc="{name: {one: value where 1 is printed, text: words}}"
    )
    printed: tuple[float, ...] = parameter(unit="-", doc="its rows as they are printed")
    cells: dict[str, tuple[Literal["S", "U"], ...]] = parameter(
        unit="-", doc="on each ground S or U for each row"
    )
    stated: dict[str, float] | None = parameter(
        None, unit="-", doc="percentages that its text states"
    )
    stated_mean: float | None = parameter(None, unit="%", doc="their mean as its text states it")
    variant: dict[str, tuple[str | float | bool, ...]] | None = parameter(
        None, unit="-", doc="values that its walks had, {dotted path: [...]}"
    )
    others: tuple[str, ...] = parameter((), unit="-", doc="tables of other variants")


@dataclass(frozen=True, kw_only=True, eq=False)
class ReferenceTable:
    """A reference table.

    Attributes:
        name: What it is called by: name or file.
        content: The rest of its file.
        readings: By name, the first one is the usual.
    """

    name: str
    content: _Content
    readings: Mapping[str, Reading]

    @property
    def title(self) -> str:
        """What a page calls it."""
        return self.content.title

    @property
    def source(self) -> str:
        """Where it comes from."""
        return self.content.source

    @property
    def stated(self) -> Mapping[str, float]:
        """Percentage of stable cells that its text states, by ground."""
        return self.content.stated or {}

    @cached_property
    def cells(self) -> Mapping[ReferenceCell, bool]:
        """True where it says stable."""
        return {
            ReferenceCell(printed, surface): verdict == "S"
            for surface, verdicts in self.content.cells.items()
            for printed, verdict in zip(self.content.printed, verdicts, strict=True)
        }

    @property
    def counted(self) -> dict[str, float]:
        """Percentage of its cells that are stable, by ground."""
        return {
            surface: stability_percent([verdict == "S" for verdict in verdicts])
            for surface, verdicts in self.content.cells.items()
        }

    @property
    def counted_mean(self) -> float:
        """Mean of those over the grounds."""
        return efficiency(list(self.counted.values()))

    def printed(self, value: float, reading: str) -> float:
        """What it prints for a value of its rows' path."""
        return value / self.readings[reading].one

    def place(self, value: float, surface: str, reading: str) -> ReferenceCell | None:
        """The cell that a value and a ground stand for; None if it has none there."""
        printed = self.printed(value, reading)
        found = ReferenceCell(round(printed), surface)
        return found if abs(printed - found.printed) < EXACT and found in self.cells else None

    def answers(self, values: Mapping[str, object]) -> bool:
        """Whether its walks had these values; what is not among them is none."""
        asked = (self.content.variant or {}).items()
        return all(values.get(path, "none") in known for path, known in asked)


def load_reference(name: str, relative_to: Path | None = None) -> ReferenceTable:
    """Reference table of a name or a file.

    Args:
        name: Name of a file in `experiments/references`, or a .yaml file of the user's own.
        relative_to: Folder that a relative file starts from; the working directory by default.

    Raises:
        UnknownName: If there is none.
        FileError: If its file is wrong.
    """
    if is_file_name(name):
        path = (relative_to or Path.cwd()) / name
        if not path.is_file():
            raise UnknownName(f"no file {path}; give a reference table{suggestion(name, names())}")
        return _read(name, path, path.stat().st_mtime_ns)
    files = {path.stem: path for path in reversed(_files())}
    if name not in files:
        raise UnknownName(f"no reference table is called {name!r}{suggestion(name, names())}")
    return _read(name, files[name], files[name].stat().st_mtime_ns)


def names() -> list[str]:
    """Names of the tables in `experiments/references`, sorted."""
    return sorted({path.stem for path in _files()})


def _files() -> list[Path]:
    return [path for place in folders("experiment") for path in (place / FOLDER).glob("*.yaml")]


@lru_cache(maxsize=16)
def _read(name: str, path: Path, changed: int) -> ReferenceTable:
    node = load(path)
    content = build(_Content, node)
    readings = {key: build(Reading, item) for key, item in node.mapping["readings"].mapping.items()}
    cells = node.mapping["cells"].mapping
    uneven = [key for key, row in content.cells.items() if len(row) != len(content.printed)]
    problems = [
        cells[key].problem(f"cells: {key} has {len(content.cells[key])} verdicts; `printed` has "
                           f"{len(content.printed)} rows")
        for key in uneven
    ]  # fmt: skip
    if problems:
        raise FileError(problems)
    return ReferenceTable(name=name, content=content, readings=readings)
