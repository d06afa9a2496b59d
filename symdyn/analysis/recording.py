"""What a run leaves behind, from the simulator or the robot: plain arrays, so that both go through the same metrics."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray

from symdyn.errors import FileProblem
from symdyn.io.files import write_with

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Recording:
    """One robot over S samples at a fixed rate. Legs in the order of symdyn.robot.legs.LEGS, joints in that of JOINTS.

    Attributes:
        dt: time between samples, s.
        mass: of the robot, kg.
        gravity: m/s^2.
        velocity_command: (S, 3) v_x, v_y (m/s), yaw rate (rad/s).
        velocity_h: (S, 3) the same, realised, in the heading frame.
        base_pos_w: (S, 3) trunk origin, m.
        base_quat_w: (S, 4) orientation of the trunk: w, x, y, z.
        joint_pos: (S, 12) rad.
        joint_vel: (S, 12) rad/s.
        joint_torque: (S, 12) N m.
        contact: (S, 4) bool, whether a foot bears load.
        desired_stance: (S, 4) bool, whether it should.
        stride_phase: (S,) phi in [0, 1).
        offsets: (S, 4) theta of the commanded gait.
        period: (S,) commanded stride period, s.
        duty: (S,) commanded duty factor.
    """

    dt: float
    mass: float
    gravity: float
    velocity_command: Floats
    velocity_h: Floats
    base_pos_w: Floats
    base_quat_w: Floats
    joint_pos: Floats
    joint_vel: Floats
    joint_torque: Floats
    contact: NDArray[np.bool_]
    desired_stance: NDArray[np.bool_]
    stride_phase: Floats
    offsets: Floats
    period: Floats
    duty: Floats

    @property
    def time(self) -> Floats:
        """(S,) s from the start."""
        return np.arange(len(self.stride_phase), dtype=np.float64) * self.dt

    def between(self, start: float, stop: float) -> Recording:
        """The samples with start <= time < stop, s."""
        first, last = round(start / self.dt), round(stop / self.dt)
        arrays = {name: value for name, value in vars(self).items() if isinstance(value, np.ndarray)}
        return replace(self, **{name: value[first:last] for name, value in arrays.items()})

    def save(self, path: Path) -> None:
        """Write as .npz. Raises FileProblem."""

        def write(temporary: Path) -> None:
            with temporary.open("wb") as stream:  # given a name, numpy would append .npz to it
                np.savez_compressed(stream, **vars(self))

        write_with(path, write)

    @classmethod
    def load(cls, path: Path) -> Recording:
        """Read :meth:`save`'s file. Raises FileProblem if it is missing, no recording, or lacks a field."""
        names = [f.name for f in fields(cls)]
        try:
            with np.load(path, allow_pickle=False) as data:
                values: dict[str, Any] = {name: data[name] for name in names if name in data}
        except (OSError, EOFError, ValueError, TypeError, BadZipFile) as error:
            raise FileProblem(path, f"is not a symdyn recording ({error}).") from error
        lacking = ", ".join(name for name in names if name not in values)
        if lacking:
            raise FileProblem(path, f"was made by another version of symdyn (it lacks {lacking}); record it again.")
        scalars: dict[str, Any] = {name: float(value) for name, value in values.items() if value.ndim == 0}
        return cls(**(values | scalars))
