"""Where the numbers come from: digests, seeds, versions, parameters, and the way to them again."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from gaitlab.documents import Node, load, parse
from gaitlab.errors import GaitlabError
from gaitlab.experiment import Experiment
from gaitlab.model import Robot, gantry_of
from gaitlab.parameters import Parameter, get_path, parameters
from gaitlab.plugins import label, locate
from gaitlab.report.markdown import code, details, escape, table
from gaitlab.report.variants import value_text
from gaitlab.report.words import plural
from gaitlab.servos.files import load_servo
from gaitlab.surfaces import Surface
from gaitlab.surfaces.files import load_surface

UNPUBLISHED = ("assumption", "reconstruction")
# Differ from run to run without a result changing, so the page would.
PER_RUN = ("finished", "wall_time", "processor_time")
HELD = {
    "level": "holds its lateral motion, roll, yaw and pitch",
    "planar": "holds its lateral motion, roll and yaw",
}
MOST_VALUES = 4  # of one provenance entry; the rest is counted


@dataclass(frozen=True, kw_only=True)
class Notes:
    """What a file says of its numbers.

    Attributes:
        values: The numbers themselves, by parameter.
        sources: Where those come from that the file says it of.
    """

    values: Mapping[str, object] = field(default_factory=dict)
    sources: Mapping[str, str] = field(default_factory=dict)


def file_notes(kind: Literal["surface", "servo"], name: str, folder: Path) -> Notes:
    """Notes of a file; none when it is gone or no longer right, for the results outlive it."""
    try:
        nodes = load(locate(kind, name, folder)).mapping
        owner = (load_surface if kind == "surface" else load_servo)(name, folder)
    except GaitlabError:
        return Notes()
    return Notes(
        values=_values(owner),
        sources={key: str(source.value) for key, source in _sources(nodes).items()},
    )


def servo_notes(robot: Robot, name: str, folder: Path) -> Notes:
    """Notes of a servo: of its file, or of the robot's file that has its numbers."""
    own: Mapping[str, object] = getattr(robot, "own_servos", {})
    if name not in own:
        return file_notes("servo", name, folder)
    sources: Mapping[str, Mapping[str, str]] = getattr(robot, "servo_sources", {})
    return Notes(values=_values(own[name]), sources=sources.get(name, {}))


def _values(owner: object) -> dict[str, object]:
    return {item.name: get_path(owner, item.name) for item in parameters(type(owner))}


def _sources(nodes: Mapping[str, Node]) -> dict[str, Node]:
    given = {key: node.mapping.get("source") for key, node in nodes.items()}
    return {key: node for key, node in given.items() if node is not None}


def ground_notes(experiment: Experiment) -> dict[str, Notes]:
    """Notes of every ground of an experiment, by what the experiment calls it."""
    listed = parse(experiment.text, experiment.path).mapping.get("surfaces")
    items = (listed.items or (listed,)) if listed else ()
    files = {label(str(item.value)): str(item.value) for item in items}
    return {
        name: file_notes("surface", files.get(name, name), experiment.path.parent)
        for name in experiment.parts.surfaces
    }


@dataclass(frozen=True, kw_only=True)
class DescribedPart:
    """A thing with parameters that took part in the trials.

    Attributes:
        title: What it is and its name, `gait eros` for instance.
        path: Prefix of its parameters' dotted paths.
        value: The dataclass.
        varied: Paths that the experiment varies.
        notes: What its own file says, over what its class says.
    """

    title: str
    path: str
    value: Any
    varied: frozenset[str]
    notes: Notes = field(default_factory=Notes)

    def parameters(self) -> Iterable[Parameter]:
        """Its parameters, in order."""
        return parameters(type(self.value))

    @property
    def unpublished(self) -> frozenset[tuple[str, str, str]]:
        """Parameters that nobody published and the experiment does not vary: path, value, source.

        Parts that share a value from one source share the entry.
        """
        return frozenset(
            (f"{self.path}.{item.name}", value_text(self._value(item)), self._note(item))
            for item in self.parameters()
            if self._is_unpublished(item)
        )

    def _is_unpublished(self, item: Parameter) -> bool:
        varied = f"{self.path}.{item.name}" in self.varied
        return self._note(item).lower().startswith(UNPUBLISHED) and not varied

    def _note(self, item: Parameter) -> str:
        return self.notes.sources.get(item.name, item.source)

    def _value(self, item: Parameter) -> object:
        value: object = get_path(self.value, item.name)
        return value

    def table(self) -> str:
        """Name, value, unit, meaning and source of every parameter."""
        rows = []
        for item in self.parameters():
            path = f"{self.path}.{item.name}"
            value = self._value(item)
            files = {f"{self.path}.{name}" for name in item.contents_of}
            varied = {path, *files} & self.varied
            shown = "*varied*" if varied else escape(value_text(value))
            rows.append(
                [
                    code(item.name),
                    shown,
                    escape(item.unit),
                    escape(item.doc),
                    self._source(item, value),
                ]
            )
        return table(["parameter", "value", "unit", "meaning", "source"], rows, "lrlll")

    def _source(self, item: Parameter, value: object) -> str:
        if f"{self.path}.{item.name}" in self.varied:
            return ""
        text = escape(self._note(item))
        if text and value != self.notes.values.get(item.name, item.default):
            text = "set by the experiment"
        return (
            f"**{text}, nobody published it**"
            if self._hides(item, text)
            else self._bold(item, text)
        )

    def _hides(self, item: Parameter, text: str) -> bool:
        return self._is_unpublished(item) and not text.lower().startswith(UNPUBLISHED)

    def _bold(self, item: Parameter, text: str) -> str:
        return f"**{text}**" if self._is_unpublished(item) else text


def ground_table(grounds: Mapping[str, Surface]) -> str:
    """Every ground with its numbers, one column each."""
    items: dict[str, Parameter] = {}
    for surface in grounds.values():
        items |= {item.name: item for item in parameters(type(surface))}
    rows = [_ground_row(item, list(grounds.values())) for item in items.values()]
    kinds = ["`type`", "", *(surface.type for surface in grounds.values())]
    header = ["parameter", "unit", *map(escape, grounds)]
    numbers = table(header, [kinds, *rows], "ll" + "r" * len(grounds))
    return f"### grounds\n\n{numbers}"


def _ground_row(item: Parameter, grounds: Sequence[Surface]) -> list[str]:
    values = [getattr(surface, item.name, None) for surface in grounds]
    owned = [item.name in {p.name for p in parameters(type(surface))} for surface in grounds]
    shown = [value_text(v) if own else "" for v, own in zip(values, owned, strict=True)]
    return [code(item.name), unit_text(item.unit), *map(escape, shown)]


def unit_text(unit: str) -> str:
    """A unit in a table; a ratio has none."""
    return "" if unit == "-" else escape(unit)


def part_tables(parts: Sequence[DescribedPart]) -> str:
    """All parameters, one folded table a part, what nobody published in bold."""
    return "\n\n".join(
        f"### {escape(part.title)}\n\n{details(_summary(part), part.table())}"
        for part in parts
        if any(part.parameters())
    )


def _summary(part: DescribedPart) -> str:
    """How many parameters a part has, and of how many nobody published the value."""
    n, hidden = len(list(part.parameters())), len(part.unpublished)
    count = plural(n, "parameter")
    return f"{count}, {hidden} of them nobody published" if hidden else count


def facts_table(facts: Mapping[str, str]) -> str:
    """Name and value, one row each."""
    return table(["", ""], [[escape(name), value] for name, value in facts.items()], "ll")


def common_values(records: Iterable[Mapping[str, object]]) -> dict[str, str]:
    """Every provenance entry with the values it takes, the commonest named, the rest counted."""
    seen: dict[str, dict[str, None]] = {}
    for record in records:
        for name, value in record.items():
            if name not in PER_RUN and value is not None:
                seen.setdefault(name, {})[str(value)] = None
    return {name: _listed(sorted(values)) for name, values in sorted(seen.items())}


def _listed(values: Sequence[str]) -> str:
    shown = ", ".join(code(value) for value in values[:MOST_VALUES])
    rest = len(values) - MOST_VALUES
    return shown if rest <= 0 else f"{shown} and {rest} more"


def seeds_text(seeds: Iterable[int]) -> str:
    """Seeds as ranges: `0 to 9, 20`."""
    ordered = sorted(set(seeds))
    runs: list[list[int]] = []
    for seed in ordered:
        if runs and seed == runs[-1][1] + 1:
            runs[-1][1] = seed
        else:
            runs.append([seed, seed])
    return ", ".join(str(low) if low == high else f"{low} to {high}" for low, high in runs)


def gantry_note(parts: Sequence[DescribedPart]) -> str:
    """A bold line for every robot on a gantry; empty when all stand on their own."""
    robots = [part for part in parts if part.path == "robot"]
    return " ".join(note for note in map(_note, robots) if note)


def _note(part: DescribedPart) -> str:
    if "robot.gantry" in part.varied:
        return (
            f"**On a gantry: the gantry of {escape(part.title)} is varied; only where it is `none` "
            "does the robot balance by itself.**"
        )
    kind = gantry_of(part.value)
    if kind == "none":
        return ""
    return (
        f"**On a gantry: a rig {HELD[kind]}; {escape(part.title)} does not balance by itself, and "
        "staying up says that its legs carried it.**"
    )
