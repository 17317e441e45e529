"""Where the numbers of a ground or a servo come from, as the notes in its file say."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from gaitlab.documents import Node, load, parse
from gaitlab.errors import GaitlabError
from gaitlab.experiment import Experiment
from gaitlab.parameters import get_path, parameters
from gaitlab.plugins import label, locate
from gaitlab.servos.files import load_servo
from gaitlab.surfaces.files import load_surface


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
        values={item.name: get_path(owner, item.name) for item in parameters(type(owner))},
        sources={key: str(source.value) for key, source in _sources(nodes).items()},
    )


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
