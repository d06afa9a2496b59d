"""Motors of one machine, as a fit has them: late, weaker or stronger, each with its own gains."""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import NDArray

from hardware.robot_sim.settings import PERIOD
from symdyn.robot.fit import LONGEST_DELAY, Fit

Floats = NDArray[np.float64]

SUBSTEP = 0.001
"""s; a motor's law holds all the time, and a fit's times are finer than the 2 ms between messages."""


class FittedMotors:
    """Which command acts on which joint when, and what it makes of it.

    Motors have a cycle of their own, which is not in step with the messages: a command takes effect up to half a period
    of the messages earlier or later than after its delay. (In step, a torque that is reported every 2 ms would always
    change just after a report, and look a millisecond late.)

    Args:
        fit: of the machine.
        seed: of when in its cycle a motor hears of a command.

    Attributes:
        strength: (12,) torque at the joint by the torque that the motor reports.
        offset: (12,) what the encoders show too much, rad.
    """

    def __init__(self, fit: Fit, seed: int = 0) -> None:
        self._rng = np.random.default_rng(seed)
        self.strength, self.offset = fit.values("strength"), fit.values("offset")
        self._delay = fit.values("delay")
        self._kp, self._kd = fit.values("kp"), fit.values("kd")
        self._given: deque[tuple[float, Floats]] = deque()

    def command(self, now: float, pos: Floats, kp: Floats, kd: Floats, vel: Floats, torque: Floats) -> None:
        """A command arrives; (12,) each. The first one counts as given long ago."""
        early = (0.5 - self._rng.random()) * PERIOD
        self._given.append((now - early, np.stack([pos, kp, kd, vel, torque])))

    def forget(self, now: float) -> None:
        """What was commanded last has been so for ever, and it is ``now``."""
        self._given = deque([(now - 2.0 * LONGEST_DELAY, self._given[-1][1])])

    def acting(self, now: float) -> tuple[Floats, Floats, Floats, Floats, Floats]:
        """The mean of what acts on each joint during the next :data:`SUBSTEP`.

        Returns:
            Position (of the joint itself, not as its encoder shows it), kp, kd, velocity, torque, (12,) each.
        """
        while len(self._given) > 1 and self._given[1][0] < now - LONGEST_DELAY:
            self._given.popleft()
        if len(self._given) == 1:
            mean = self._given[0][1]
        else:
            begins = np.array([at for at, _ in self._given])[:, None]
            ends = np.append(begins[1:, 0], np.inf)[:, None]
            begins[0] = -np.inf  # the oldest: what was before it is forgotten
            at = now - self._delay
            share = np.clip(np.minimum(ends, at + SUBSTEP) - np.maximum(begins, at), 0.0, None) / SUBSTEP
            mean = np.einsum("ij,ikj->kj", share, np.array([values for _, values in self._given]))
        pos, kp, kd, vel, torque = mean
        strong = self.strength
        return pos - self.offset, strong * self._kp * kp, strong * self._kd * kd, vel, strong * torque

    def reported(self, now: float, pos: Floats, vel: Floats) -> Floats:
        """The torque that each motor takes itself to give at this moment, (12,) N m, without its limit.

        Args:
            now: s.
            pos: (12,) as the encoders show it, rad.
            vel: (12,) rad/s.
        """
        acting = self._given[0][1].copy()
        for at, values in self._given:
            since = at <= now - self._delay
            acting[:, since] = values[:, since]
        target, kp, kd, target_vel, torque = acting
        return self._kp * kp * (target - pos) + self._kd * kd * (target_vel - vel) + torque
