"""What a robot is told: in which mode, how often, and whether within its limits."""

from __future__ import annotations

import math
from collections import deque
from typing import Literal

import numpy as np

from hardware.robot_sim.effects import FOREIGN_SENDER
from hardware.wire.messages import pd_tau_targets_lcmt
from hardware.wire.readings import Floats, Joints, Targets
from symdyn.robot.definition import Robot
from symdyn.robot.legs import JOINTS

Mode = Literal["untold", "limp", "damping", "standing", "running"]
"""By the gains of the last targets. ``untold``: none yet. ``limp``: none. ``damping``: kp 0. ``running``: the kp that
policies of this robot are trained with, and at most their kd. ``standing``: others."""

MEMORY = 50
"""States of the joints of which the sender may have used any. 100 ms: the 50 ms after which a deployer must call a
state stale, and as much for a busy computer between the two."""

TORQUE_TOLERANCE = 1e-3
"""N m; the wire's float32."""

_SAME = 1e-9  # of gains, which the wire carries in full


def mode_of(targets: Targets, robot: Robot) -> Mode:
    """What gains stand for; see :data:`Mode`."""
    if not targets.kp.any():
        return "damping" if targets.kd.any() else "limp"
    running = (np.abs(targets.kp - robot.kp) < _SAME).all() and (targets.kd <= robot.kd + _SAME).all()
    return "running" if running else "standing"


class TargetMonitor:
    """Watches the targets of one sender; those with ``robot_id`` FOREIGN_SENDER are left out.

    Args:
        robot: for its gains.
        joint_range: (12, 2) rad.
        torque_limit: (12,) N m.

    Attributes:
        mode: of the last targets.
        kp: the largest gain of the last targets, N m/rad.
        mode_since: when it became so, s of the sender's clock.
        history: (time, mode) of every change.
        count: targets received.
        not_finite: how many held NaN or infinity.
        first: when the first came, s, or None.
        last: when the last came, s, or None.
        longest_gap: between two, s.
        range_excess: furthest target beyond a joint's range, rad.
        torque_excess: by how much |kp (pos - q) - kd qd| was over the motor's limit, at most, N m; 0 if it never was.
            Of the last states of the joints, true or said, that one counts which forgives the sender most: it knows no
            other than those said, and only the true ones matter to the motors.
        torque_excesses: how many targets were over.
    """

    def __init__(self, robot: Robot, joint_range: Floats, torque_limit: Floats) -> None:
        self._robot, self._range, self._torque_limit = robot, joint_range, torque_limit
        # positions and velocities of the joints, true ones and said ones, each in a ring; NaN where there is none yet
        self._states = np.full((2, 2, MEMORY, len(JOINTS)), np.nan)
        self._counts = [0, 0]
        self._recent: deque[float] = deque()
        self.mode: Mode = "untold"
        self.kp = 0.0
        self.mode_since = -math.inf
        self.history: list[tuple[float, Mode]] = []
        self.count = self.not_finite = self.torque_excesses = 0
        self.first: float | None = None
        self.last: float | None = None
        self.longest_gap = self.range_excess = self.torque_excess = 0.0

    def measured(self, joints: Joints) -> None:
        """Take note of how the joints are."""
        self._keep(0, joints)

    def said(self, joints: Joints) -> None:
        """Take note of what was published of the joints instead."""
        self._keep(1, joints)

    def received(self, now: float, message: pd_tau_targets_lcmt) -> None:
        """Judge targets that came at ``now``, s."""
        if message.robot_id == FOREIGN_SENDER:
            return
        self.count += 1
        self.first = now if self.first is None else self.first
        self.longest_gap = max(self.longest_gap, now - (now if self.last is None else self.last))
        self.last = now
        self._recent.append(now)
        self._forget(now)
        targets = Targets.of(message)
        if not all(np.isfinite(array).all() for array in (targets.pos, targets.kp, targets.kd)):
            self.not_finite += 1
            return
        self.kp = float(targets.kp.max())
        mode = mode_of(targets, self._robot)
        if mode != self.mode:
            self.mode, self.mode_since = mode, now
            self.history.append((now, mode))
        if targets.kp.any():
            beyond = np.maximum(self._range[:, 0] - targets.pos, targets.pos - self._range[:, 1])
            self.range_excess = max(self.range_excess, float(beyond.max()))
        excess = self._torque_excess(targets)
        if excess > TORQUE_TOLERANCE:
            self.torque_excesses += 1
            self.torque_excess = max(self.torque_excess, excess)

    def rate(self, now: float) -> float:
        """Targets in the last second."""
        self._forget(now)
        return float(len(self._recent))

    def _forget(self, now: float) -> None:
        while self._recent and self._recent[0] <= now - 1.0:
            self._recent.popleft()

    def _keep(self, ring: int, joints: Joints) -> None:
        self._states[:, ring, self._counts[ring] % MEMORY] = joints.pos, joints.vel
        self._counts[ring] += 1

    def _torque_excess(self, targets: Targets) -> float:
        pos, vel = self._states
        excess = (np.abs(targets.kp * (targets.pos - pos) - targets.kd * vel) - self._torque_limit).max(axis=-1)
        # a state that is not there, or not finite as a fault may say it, forgives nothing
        known = excess[np.isfinite(excess)]
        return float(known.min()) if len(known) else 0.0
