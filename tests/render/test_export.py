from __future__ import annotations

import json
import sys
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest

from gaitlab.errors import StoreError, UsageError
from gaitlab.log.columns import columns
from gaitlab.render.export import FORMATS, ExportedTrial, write_export
from gaitlab.store import Store
from tests.walked import commit, record, walked


@pytest.fixture(scope="module")
def shown() -> ExportedTrial:
    walking, log = walked()
    return ExportedTrial(record=record(walking, log), trial=walking, log=log)


def test_a_csv_reads_back_bit_for_bit_and_names_every_unit(
    shown: ExportedTrial, tmp_path: Path
) -> None:
    (path,) = write_export(shown, "csv", tmp_path / "walk.csv")
    table = pd.read_csv(path, dtype=np.float64)
    described = columns(shown.log.header.joints)
    assert len(table.columns) == len(described)
    for title, column in zip(table.columns, described, strict=True):
        assert title == (column.name if column.unit == "-" else f"{column.name} [{column.unit}]")
        back = table[title].to_numpy().astype(column.dtype)
        assert np.array_equal(back, shown.log.arrays[column.name], equal_nan=back.dtype.kind == "f")


def test_an_mcap_holds_every_number_at_its_time(shown: ExportedTrial, tmp_path: Path) -> None:
    from mcap.reader import make_reader

    (path,) = write_export(shown, "mcap", tmp_path / "walk.mcap")
    log, rows = shown.log, {}
    with path.open("rb") as file:
        reader = make_reader(file)
        for schema, channel, message in reader.iter_messages():
            assert schema is not None
            assert schema.encoding == "jsonschema"
            assert channel.message_encoding == "json"
            rows.setdefault(channel.topic, []).append((message.log_time, json.loads(message.data)))
        assert {meta.metadata["trial_id"] for meta in reader.iter_metadata()} == {shown.trial.id}
    seen = {"time"}
    for topic, messages in rows.items():
        if topic in ("/tf", "/scene"):
            continue
        prefix = "" if topic == "/robot" else f"{topic[1:]}_"
        times = np.array([time for time, _ in messages])
        assert np.abs(times * 1e-9 - log["time"]).max() < 1e-6
        assert (np.diff(times) > 0).all()
        for name in messages[0][1]:
            values = [np.nan if row[name] is None else row[name] for _, row in messages]
            assert np.array_equal(np.array(values, float), log[prefix + name].astype(float), True)
            seen.add(prefix + name)
    assert seen == {column.name for column in columns(log.header.joints)}


def test_an_mcap_moves_the_links_as_the_tree_does(shown: ExportedTrial, tmp_path: Path) -> None:
    from mcap.reader import make_reader

    (path,) = write_export(shown, "mcap", tmp_path / "walk.mcap")
    links = shown.trial.robot.tree.links
    with path.open("rb") as file:
        messages = list(make_reader(file).iter_messages(topics=["/tf", "/scene"]))
    scene = next(json.loads(m.data) for _, channel, m in messages if channel.topic == "/scene")
    assert [e["frame_id"] for e in scene["entities"][:-1]] == [link.name for link in links]
    moving = [m for _, channel, m in messages if channel.topic == "/tf"]
    row = int(np.flatnonzero(shown.nanoseconds == moving[-1].log_time)[0])
    for index, transform in enumerate(json.loads(moving[-1].data)["transforms"]):
        place = [transform["translation"][axis] for axis in "xyz"]
        assert place == pytest.approx(shown.poses.position[row, index].tolist())
        turn = [transform["rotation"][axis] for axis in "xyzw"]
        assert np.linalg.norm(turn) == pytest.approx(1.0)


def test_a_rerun_recording_holds_robot_and_columns(shown: ExportedTrial, tmp_path: Path) -> None:
    from rerun.chunk import RrdReader

    (path,) = write_export(shown, "rerun", tmp_path / "walk.rrd")
    reader = RrdReader(path)
    assert [store.recording_id for store in reader.recordings()] == [shown.trial.id]
    names = {str(chunk.entity_path) for chunk in reader.stream()}
    assert {f"/log/{c.name}" for c in columns(shown.log.header.joints)} - names == {"/log/time"}
    assert {f"/world/robot/{link.name}" for link in shown.trial.robot.tree.links} <= names


def test_urdf_and_mjcf_carry_the_same_links_joints_and_mass(
    shown: ExportedTrial, tmp_path: Path
) -> None:
    files = write_export(shown, "mjcf-urdf", tmp_path / "robot")
    assert [path.name for path in files] == ["robot.urdf", "robot.xml"]
    urdf, model = (ElementTree.parse(path).getroot() for path in files)
    tree = shown.trial.robot.tree
    names = [link.name for link in tree.links]
    assert [link.get("name") for link in urdf.iter("link")] == names
    assert sorted(str(body.get("name")) for body in model.iter("body")) == sorted(names)
    hinges = {joint.get("name"): joint for joint in model.iter("joint") if joint.get("type")}
    for joint in urdf.iter("joint"):
        limit = joint.find("limit")
        assert limit is not None
        low, high = str(hinges[joint.get("name")].get("range")).split()
        assert (float(low), float(high)) == (
            float(str(limit.get("lower"))),
            float(str(limit.get("upper"))),
        )
    for masses in (urdf.iter("mass"), model.iter("inertial")):
        weights = [float(str(mass.get("value") or mass.get("mass"))) for mass in masses]
        assert sum(weights) == pytest.approx(tree.mass)


def test_the_keyframe_of_the_mjcf_is_the_first_tick(shown: ExportedTrial, tmp_path: Path) -> None:
    _, path = write_export(shown, "mjcf-urdf", tmp_path / "robot")
    model = ElementTree.parse(path).getroot()
    key = model.find("keyframe/key")
    assert key is not None
    qpos = [float(part) for part in str(key.get("qpos")).split()]
    log = shown.log
    assert qpos[:3] == log.vector("trunk_")[0].tolist()
    assert qpos[3:7] == log.vector("trunk_q", "wxyz")[0].tolist()
    met = [joint.get("name") for joint in model.iter("joint") if joint.get("type") == "hinge"]
    assert qpos[7:] == [float(log[f"{name}_position"][0]) for name in met]


def test_the_parquet_of_a_store_opens_flat_with_rising_time(tmp_path: Path) -> None:
    """What PlotJuggler needs: one level of columns and a time that rises."""
    name = commit(tmp_path)
    table = pq.read_table(Store(tmp_path).file(name))
    assert table.column_names[0] == "time"
    assert not any("." in column or "/" in column for column in table.column_names)
    assert all(field.type.num_fields == 0 for field in table.schema)
    assert (np.diff(table["time"].to_numpy()) > 0.0).all()
    assert table.schema.field("trunk_x").metadata[b"unit"] == b"m"


@pytest.mark.parametrize("form", FORMATS)
def test_a_place_that_cannot_be_written_is_told(
    shown: ExportedTrial, form: str, tmp_path: Path
) -> None:
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(StoreError, match="another --output"):
        write_export(shown, form, tmp_path / "file" / "walk")  # type: ignore[arg-type]
    with pytest.raises(UsageError, match="folder is in the way"):
        write_export(shown, form, tmp_path)  # type: ignore[arg-type]


@pytest.mark.parametrize(("form", "package"), [("mcap", "mcap"), ("rerun", "rerun-sdk")])
def test_a_missing_library_is_named(
    shown: ExportedTrial, form: str, package: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, package.removesuffix("-sdk"), None)
    with pytest.raises(UsageError, match=f"pip install {package}"):
        write_export(shown, form, tmp_path / "walk")  # type: ignore[arg-type]
