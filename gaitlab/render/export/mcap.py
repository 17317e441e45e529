"""A trial as MCAP, which Foxglove, Lichtblick and PlotJuggler open: JSON with its schemas.

One topic for the trunk with its balance, each foot and each joint, at every tick; the poses of the
links and their boxes in Foxglove's own types, for a 3D panel. Time counts from the trial's start.

References:
    MCAP: MCAP file format specification, Foxglove, mcap.dev.
    Foxglove: Foxglove SDK, schemas FrameTransforms and SceneUpdate.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple, TypeAlias

import numpy as np

from gaitlab.log.columns import FEET, Column, columns
from gaitlab.model import Link
from gaitlab.render.export.recorded import NANOSECONDS, ExportedTrial
from gaitlab.render.scene import channels, link_colour

Json: TypeAlias = "Mapping[str, Json] | list[Json] | str | float | int | bool | None"
Message: TypeAlias = tuple[int, Json]
POSES_EVERY = 0.02  # s; a 3D panel draws no faster
TYPES: dict[str, Json] = {
    "float32": ["number", "null"],
    "int8": "integer",
    "int16": "integer",
    "bool": "boolean",
}
OBJECT: dict[str, Json] = {"type": "object"}
LIST_OF_OBJECTS: dict[str, Json] = {"type": "array", "items": OBJECT}


class Topic(NamedTuple):
    """What goes into one channel.

    Attributes:
        name: Of the topic.
        title: Of its schema.
        properties: Of its schema, by name.
        messages: Time in [ns] and content, in order.
    """

    name: str
    title: str
    properties: dict[str, Json]
    messages: Iterator[Message]


def write_mcap(shown: ExportedTrial, files: Sequence[Path]) -> None:
    """Write every column of a log, and the moving robot."""
    from mcap.writer import Writer

    topics = [*_log_topics(shown), _transforms(shown), _scene(shown)]
    with files[0].open("wb") as file:
        writer = Writer(file)
        writer.start(library="gaitlab")
        record = shown.record
        facts = {"trial_id": record.trial_id, "trial": json.dumps(record.trial, sort_keys=True)}
        writer.add_metadata("gaitlab", facts)
        channels = []
        for topic in topics:
            schema = {"title": topic.title, "type": "object", "properties": topic.properties}
            text = json.dumps(schema).encode()
            number = writer.register_schema(topic.title, "jsonschema", text)
            channels.append(writer.register_channel(topic.name, "json", number))
        for time, channel, content in _in_order(topics, channels):
            data = json.dumps(content, separators=(",", ":"), allow_nan=False).encode()
            writer.add_message(channel, log_time=time, data=data, publish_time=time)
        writer.finish()


def _in_order(topics: list[Topic], channels: list[int]) -> list[tuple[int, int, Json]]:
    """Messages of all topics by time; readers seek in time."""
    pairs = zip(topics, channels, strict=True)
    found = [(time, channel, item) for topic, channel in pairs for time, item in topic.messages]
    return sorted(found, key=lambda message: message[:2])


def _log_topics(shown: ExportedTrial) -> Iterator[Topic]:
    """Every column but time, grouped by the part of the robot that it tells of."""
    described = columns(shown.log.header.joints)
    groups = [f"{side}_foot" for side in FEET] + list(shown.log.header.joints)
    rest = [c for c in described if c.name != "time"]
    for group in groups:
        own = [c for c in rest if c.name.startswith(f"{group}_")]
        rest = [c for c in rest if c not in own]
        yield _topic(shown, group, own, f"{group}_")
    yield _topic(shown, "robot", rest, "")


def _topic(shown: ExportedTrial, group: str, described: list[Column], prefix: str) -> Topic:
    names = [column.name.removeprefix(prefix) for column in described]
    properties: dict[str, Json] = {
        name: {"type": TYPES[column.dtype], "description": f"{column.doc} [{column.unit}]"}
        for name, column in zip(names, described, strict=True)
    }
    lists = [_plain(shown.log[column.name]) for column in described]
    rows = (dict(zip(names, row, strict=True)) for row in zip(*lists, strict=True))
    messages = zip(shown.nanoseconds.tolist(), rows, strict=True)
    return Topic(f"/{group}", f"gaitlab.{group}", properties, messages)


def _plain(array: np.ndarray) -> list[Json]:
    """Numbers as JSON has them, exact; None for those that it has not."""
    values: list[Json] = array.tolist()
    if np.issubdtype(array.dtype, np.floating) and not np.isfinite(array).all():
        return [v if known else None for v, known in zip(values, np.isfinite(array), strict=True)]
    return values


def _transforms(shown: ExportedTrial) -> Topic:
    """Pose of every link in the world."""
    every = max(1, round(POSES_EVERY / shown.log.header.dt))
    names = [link.name for link in shown.trial.robot.tree.links]

    def messages() -> Iterator[Message]:
        for row in range(0, len(shown.log), every):
            time = int(shown.nanoseconds[row])
            poses = zip(
                names, shown.poses.position[row], shown.quaternions[row].tolist(), strict=True
            )
            yield time, {"transforms": [_transform(time, *pose) for pose in poses]}

    properties: dict[str, Json] = {"transforms": LIST_OF_OBJECTS}
    return Topic("/tf", "foxglove.FrameTransforms", properties, messages())


def _transform(time: int, name: str, position: np.ndarray, quaternion: list[float]) -> Json:
    return {
        "timestamp": _stamp(time),
        "parent_frame_id": "world",
        "child_frame_id": name,
        "translation": _point(position.tolist()),
        "rotation": dict(zip("xyzw", quaternion, strict=True)),
    }


def _scene(shown: ExportedTrial) -> Topic:
    """Boxes of the links and the ground, sent once."""
    time = int(shown.nanoseconds[0])
    robot = shown.trial.robot
    boxes = [
        _entity(time, link.name, link.name, _link_box(link, robot.feet))
        for link in robot.tree.links
    ]
    ground = _box(*shown.ground, (0.35, 0.55, 0.25), 0.5)
    content: Json = {
        "deletions": [],
        "entities": [*boxes, _entity(time, "ground", "world", ground)],
    }
    properties: dict[str, Json] = {"deletions": LIST_OF_OBJECTS, "entities": LIST_OF_OBJECTS}
    return Topic("/scene", "foxglove.SceneUpdate", properties, iter([(time, content)]))


def _link_box(link: Link, feet: tuple[str, str]) -> Json:
    return _box(list(link.box.centre), list(link.box.size), channels(link_colour(link, feet)), 1.0)


def _box(
    centre: list[float], size: list[float], colour: tuple[float, float, float], alpha: float
) -> Json:
    return {
        "pose": {"position": _point(centre), "orientation": _point([0.0, 0.0, 0.0], w=1.0)},
        "size": _point(size),
        "color": dict(zip("rgba", (*colour, alpha), strict=True)),
    }


def _entity(time: int, name: str, frame: str, cube: Json) -> Json:
    return {
        "timestamp": _stamp(time),
        "frame_id": frame,
        "id": name,
        "lifetime": _stamp(0),
        "frame_locked": True,
        "metadata": [],
        **{kind: [] for kind in ("arrows", "spheres", "cylinders", "lines", "triangles")},
        "texts": [],
        "models": [],
        "cubes": [cube],
    }


def _point(values: list[float], **more: float) -> dict[str, Json]:
    return {**dict(zip("xyz", values, strict=True)), **more}


def _stamp(time: int) -> Json:
    seconds, rest = divmod(time, int(NANOSECONDS))
    return {"sec": seconds, "nsec": rest}
