"""Walks joint angles from a file: a log of a robot, or what a team's own engine would have sent.

`gait: {type: trajectory, file: ./walk.csv, period: 0.6}`. What a file holds is said in
`gaitlab.motions.trajectory`, how it is walked in `gaitlab.motions.joint_walk`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from gaitlab.errors import WrongValue
from gaitlab.motions.joint_walk import JointWalk
from gaitlab.motions.trajectory import Trajectory, load_trajectory
from gaitlab.parameters import parameter


@dataclass(frozen=True, kw_only=True)
class Gait(JointWalk):
    """Joint angles over time, from a .csv, .npz or .parquet file with `time` and joints' names."""

    file: str = parameter(unit="file", doc="joint angles over time: ./walk.csv, .npz, .parquet")
    digest: str = parameter("", unit="-", doc="of the file's angles; filled in", contents_of="file")

    def __post_init__(self) -> None:
        if not self.digest:
            object.__setattr__(self, "digest", load_trajectory(self.file, self.unit).digest)

    @cached_property
    def trajectory(self) -> Trajectory:
        """What the file holds.

        Raises:
            FileError: If it is no trajectory any more.
            WrongValue: If it is not the one that the trial was planned with.
        """
        found = load_trajectory(self.file, self.unit)
        if found.digest != self.digest:
            raise WrongValue(
                f"{found.file} has changed since the trial was planned; plan the experiment again"
            )
        return found
