"""A trial as a Rerun recording: the robot in 3D, what acts on its feet, and every column.

References:
    Rerun: Rerun SDK, rerun.io, logging of columns.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from gaitlab.log.columns import FEET, columns
from gaitlab.render.export.recorded import NANOSECONDS, ExportedTrial
from gaitlab.render.overlay import REACH
from gaitlab.render.scene import channels, link_colour, loads

if TYPE_CHECKING:
    import rerun

TIMELINE = "time"
GREEN, VERMILLION, BLACK = (90, 140, 64, 128), (213, 94, 0), (0, 0, 0)


def write_rerun(shown: ExportedTrial, files: Sequence[Path]) -> None:
    """Write the moving robot and every column of its log.

    Raises:
        OSError: If the file cannot be written.
    """
    import rerun

    try:
        stream = rerun.RecordingStream("gaitlab", recording_id=shown.record.trial_id)
        stream.save(files[0])
        _log(stream, shown)
        stream.flush()
        stream.disconnect()
    except RuntimeError as error:  # its only kind, a full disk for instance
        raise OSError(str(error)) from error


def _log(stream: rerun.RecordingStream, shown: ExportedTrial) -> None:
    import rerun

    stream.log("/", rerun.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
    seconds = shown.nanoseconds / NANOSECONDS
    times = [rerun.TimeColumn(TIMELINE, duration=seconds)]
    _ground(stream, shown)
    _robot(stream, shown, times)
    _marks(stream, shown, times)
    for column in columns(shown.log.header.joints):
        if column.name != "time":
            values = np.asarray(shown.log[column.name], dtype=np.float64)
            place = f"/log/{column.name}"
            stream.send_columns(place, indexes=times, columns=rerun.Scalars.columns(scalars=values))
            label = f"{column.name} [{column.unit}]"
            stream.log(place, rerun.SeriesLines(names=label), static=True)


def _ground(stream: rerun.RecordingStream, shown: ExportedTrial) -> None:
    import rerun

    centre, size = shown.ground
    box = rerun.Boxes3D(centers=[centre], sizes=[size], colors=[GREEN], fill_mode="solid")
    stream.log("/world/ground", box, static=True)


def _robot(
    stream: rerun.RecordingStream, shown: ExportedTrial, times: Iterable[rerun.TimeColumn]
) -> None:
    import rerun

    robot = shown.trial.robot
    for index, link in enumerate(robot.tree.links):
        place = f"/world/robot/{link.name}"
        colour = [round(255 * part) for part in channels(link_colour(link, robot.feet))]
        box = rerun.Boxes3D(
            centers=[link.box.centre], sizes=[link.box.size], colors=[colour], fill_mode="solid"
        )
        stream.log(place, box, static=True)
        poses = rerun.Transform3D.columns(
            translation=shown.poses.position[:, index], quaternion=shown.quaternions[:, index]
        )
        stream.send_columns(place, indexes=times, columns=poses)


def _marks(
    stream: rerun.RecordingStream, shown: ExportedTrial, times: Iterable[rerun.TimeColumn]
) -> None:
    """Load on each foot, ZMP and CoM."""
    import rerun

    log = shown.log
    scale = REACH * log.header.standing_height / log.header.weight
    for side, force in zip(FEET, np.swapaxes(loads(log), 0, 1), strict=True):
        place = f"/world/load/{side}_foot"
        stream.log(place, rerun.Arrows3D.from_fields(colors=[VERMILLION]), static=True)
        arrows = rerun.Arrows3D.columns(vectors=scale * force, origins=log.vector(f"{side}_foot_"))
        stream.send_columns(place, indexes=times, columns=arrows)
    height = np.min([log[f"{side}_foot_z"] for side in FEET], axis=0)
    zmp = np.column_stack([log["zmp_x"], log["zmp_y"], height])
    for name, points in (("zmp", zmp), ("com", log.vector("com_"))):
        place = f"/world/{name}"
        stream.log(place, rerun.Points3D.from_fields(colors=[BLACK], radii=[0.008]), static=True)
        stream.send_columns(place, indexes=times, columns=rerun.Points3D.columns(positions=points))
