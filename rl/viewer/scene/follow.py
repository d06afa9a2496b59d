"""Where the eye is: with the robot, smoothly, whatever it does in a stride."""

from __future__ import annotations

import math

import numpy as np

from rl.pictures.side_camera import FOLLOW_S, TURN_S
from symdyn.analysis.recording import Floats
from symdyn.robot.frames import yaw

_JUMP = 0.5
"""m in one frame: nobody runs that far; the robot was put elsewhere."""


class Follower:
    """Tracks place and heading of a robot without lagging behind one that runs steadily.

    An alpha-beta filter (a Kalman filter of constant gains for constant velocity) for the place, critically damped; a
    low pass for the heading, which changes little. The time constants are those of the films' camera.

    Attributes:
        place: (2,) m in the world.
        heading: rad.
    """

    def __init__(self) -> None:
        self.place: Floats = np.zeros(2)
        self.heading = 0.0
        self._velocity: Floats = np.zeros(2)
        self._known = False

    def update(self, base_pos_w: Floats, base_quat_w: Floats, dt: float) -> None:
        """Take in where the robot is.

        Args:
            base_pos_w: (3,) m.
            base_quat_w: (4,).
            dt: since the last call, s of simulated time; nothing moves on in none.
        """
        seen, heading = base_pos_w[:2], float(yaw(base_quat_w))
        if not (np.isfinite(seen).all() and math.isfinite(heading)):
            return
        if not self._known or float(np.linalg.norm(seen - self.place - dt * self._velocity)) > _JUMP:
            self.place, self.heading, self._velocity, self._known = seen.copy(), heading, np.zeros(2), True
            return
        if dt <= 0.0:
            return
        keep = math.exp(-dt / FOLLOW_S)
        predicted = self.place + dt * self._velocity
        error = seen - predicted
        self.place = predicted + (1.0 - keep**2) * error
        self._velocity = self._velocity + (1.0 - keep) ** 2 * error / dt
        turn = math.remainder(heading - self.heading, 2.0 * math.pi)
        self.heading = math.remainder(self.heading + (1.0 - math.exp(-dt / TURN_S)) * turn, 2.0 * math.pi)
