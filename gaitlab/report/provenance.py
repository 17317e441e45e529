"""Where the numbers come from: digests, seeds, versions, parameters, and the way to them again."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from gaitlab.parameters import Parameter, get_path, parameters
from gaitlab.report.markdown import code, escape, table
from gaitlab.report.variants import value_text

UNPUBLISHED = ("assumption", "reconstruction")
# Differ from run to run without a result changing, so the page would.
PER_RUN = ("finished", "wall_time")
MOST_VALUES = 4  # of one provenance entry; the rest is counted


@dataclass(frozen=True, kw_only=True)
class Part:
    """A thing with parameters that took part in the trials.

    Attributes:
        title: What it is and its name, `gait eros` for instance.
        path: Prefix of its parameters' dotted paths.
        value: The dataclass.
        varied: Paths that the experiment varies.
    """

    title: str
    path: str
    value: Any
    varied: frozenset[str]

    def parameters(self) -> Iterable[Parameter]:
        """Its parameters, in order."""
        return parameters(type(self.value))

    @property
    def unpublished(self) -> int:
        """Parameters at a default that nobody published and that the experiment does not vary."""
        return sum(self._is_unpublished(item) for item in self.parameters())

    def _is_unpublished(self, item: Parameter) -> bool:
        varied = f"{self.path}.{item.name}" in self.varied
        return item.source.lower().startswith(UNPUBLISHED) and not varied

    def table(self) -> str:
        """Name, value, unit, meaning and source of every parameter."""
        rows = [self._row(item) for item in self.parameters()]
        return table(["parameter", "value", "unit", "meaning", "source"], rows, "lrlll")

    def _row(self, item: Parameter) -> list[str]:
        path = f"{self.path}.{item.name}"
        value = get_path(self.value, item.name)
        shown = "*varied*" if path in self.varied else escape(value_text(value))
        return [
            code(item.name),
            shown,
            escape(item.unit),
            escape(item.doc),
            self._source(item, value),
        ]

    def _source(self, item: Parameter, value: object) -> str:
        if f"{self.path}.{item.name}" in self.varied:
            return ""
        if value != item.default and item.source:
            return "set by the experiment"
        text = escape(item.source)
        return f"**{text}**" if self._is_unpublished(item) else text


def part_tables(parts: Sequence[Part]) -> str:
    """All parameters, one table a part, what nobody published in bold."""
    blocks = [
        f"### {escape(part.title)}\n\n{part.table()}" for part in parts if any(part.parameters())
    ]
    return "\n\n".join(blocks)


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
