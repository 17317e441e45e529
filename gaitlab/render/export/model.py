"""The robot of a trial as URDF and as MJCF, standing as it stood at the trial's first tick."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from gaitlab.documents.outputs import MARK
from gaitlab.model.urdf import urdf
from gaitlab.render.export.mjcf import mjcf
from gaitlab.render.export.recorded import ExportedTrial

NOTE = f"<!-- written by {MARK} -->\n"


def write_model(shown: ExportedTrial, files: Sequence[Path]) -> None:
    """Write the URDF and the MJCF."""
    robot, header, log = shown.trial.robot, shown.log.header, shown.log
    # Without a gantry's massless rig, which only Bullet takes; the MJCF has it as joints.
    files[0].write_text(urdf(robot.tree, robot.sole, robot.feet) + NOTE, encoding="utf-8")
    limits = zip(header.joints, header.torque_limits, strict=True)
    model = mjcf(
        robot,
        {name: limit for name, limit in limits if limit > 0.0},
        position=log.vector("trunk_")[0],
        quaternion=log.vector("trunk_q", "xyzw")[0],
        joints=log.joint_table("position")[0, : len(robot.tree.joints)],
        dt=header.dt,
    )
    files[1].write_text(model + NOTE, encoding="utf-8")
