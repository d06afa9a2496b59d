"""The last seconds of a running robot, written by one thread and read by others."""

from __future__ import annotations

import threading
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from rl.viewer.shown import Pose
from symdyn.analysis.recording import Recording


class History:
    """A ring of samples, from which :class:`symdyn.analysis.recording.Recording` s are cut.

    Args:
        seconds: how far it reaches back, s.
        dt: time between samples, s.
        gravity: m/s^2.

    Attributes:
        mass: of the robot now, kg.
    """

    def __init__(self, seconds: float, dt: float, gravity: float) -> None:
        self._capacity = round(seconds / dt)
        self._dt = dt
        self._gravity = gravity
        self.mass = 0.0
        self._columns: dict[str, NDArray] = {}
        self._count = 0
        self._lock = threading.Lock()

    def restart(self, mass: float) -> None:
        """Forget everything; time begins anew, with a robot of so much mass, kg."""
        with self._lock:
            self._count = 0
            self.mass = mass

    def append(self, sample: Mapping[str, NDArray]) -> None:
        """Add a sample: the arrays of a recording by name, one robot each, (1, ...)."""
        with self._lock:
            if not self._columns:
                self._columns = {
                    name: np.zeros((self._capacity, *value.shape[1:]), value.dtype) for name, value in sample.items()
                }
            for name, column in self._columns.items():
                column[self._count % self._capacity] = sample[name][0]
            self._count += 1

    def last(self, seconds: float) -> Recording | None:
        """The last ``seconds``, s, or what there is of them; None if there is nothing."""
        with self._lock:
            wanted = min(self._count, round(seconds / self._dt), self._capacity)
            if not wanted:
                return None
            rows = np.arange(self._count - wanted, self._count) % self._capacity
            return Recording(
                dt=self._dt,
                mass=self.mass,
                gravity=self._gravity,
                **{name: column[rows] for name, column in self._columns.items()},
            )

    def pose(self, time: float) -> Pose | None:
        """The robot at a time, s since the restart: at the sample next to it, of those that there are."""
        with self._lock:
            if not self._count:
                return None
            # the first sample is that of the time dt
            oldest, newest = max(0, self._count - self._capacity), self._count - 1
            sample = min(max(round(time / self._dt) - 1, oldest), newest)
            position, orientation, joints, contact = (
                self._columns[name][sample % self._capacity].copy()
                for name in ("base_pos_w", "base_quat_w", "joint_pos", "contact")
            )
            return Pose((sample + 1) * self._dt, position, orientation, joints, contact)
