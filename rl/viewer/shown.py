"""What the page asks of whatever it shows: a simulation of its own, or a robot somewhere else."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from rl.physics.terrain import Terrain
from symdyn.analysis.recording import Floats


@dataclass(frozen=True)
class Pose:
    """A robot at a moment.

    Attributes:
        time: s; of any clock that runs with the robot, and may be set back.
        base_pos_w: (3,) m, or None if nobody knows it.
        base_quat_w: (4,) w, x, y, z.
        joint_pos: (12,) rad, order of symdyn.robot.legs.JOINTS.
        contact: (4,) whether a foot bears load, order of symdyn.robot.legs.LEGS.
    """

    time: float
    base_pos_w: Floats | None
    base_quat_w: Floats
    joint_pos: Floats
    contact: NDArray[np.bool_]


class Shown(Protocol):
    """Something that can be shown; called from the page's thread."""

    def pose(self) -> Pose | None:
        """Where the robot is now; None if that is not known."""
        ...

    def ground(self) -> Terrain | None:
        """What it stands on; None is a flat floor."""
        ...

    def report(self, now: float) -> str:
        """What it does, as HTML for the panel, at a time of time.monotonic()."""
        ...

    def hurried(self) -> bool:
        """Whether the robot's time falls behind the clock, so that less should be drawn."""
        ...

    def failure(self) -> BaseException | None:
        """What has ended it, if anything has."""
        ...
