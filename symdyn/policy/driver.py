"""A policy file at work: its clock, what it observes, what it asks of the joints. The simulator and the robot call it.

Training has the same functions on tensors (rl.task.env); a test holds the two together.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from symdyn.errors import InvalidValue
from symdyn.gait import phase as clock
from symdyn.policy.file import Policy
from symdyn.policy.observation import SENSORS, Sensed, Situation, check_supplied, observe
from symdyn.robot.legs import JOINTS, LEGS

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Timing:
    """What the commands of n robots ask of their legs at this moment.

    Attributes:
        period: (n,) stride period, s.
        duty: (n,) duty factor.
        leg_phases: (n, 4) in [0, 1), in the order of symdyn.robot.legs.LEGS.
    """

    period: Floats
    duty: Floats
    leg_phases: Floats

    @property
    def desired_stance(self) -> NDArray[np.bool_]:
        """Which feet should be on the ground, (n, 4)."""
        return ~clock.in_swing(self.leg_phases, self.duty)


class PolicyDriver:
    """Clock and memory of n robots that one policy drives.

    A control step is :meth:`act`, whose targets hold for ``metadata.control_dt``; meanwhile :meth:`advance`, once or in
    parts, moves the clock on.

    Args:
        policy: to run.
        phase: (n,) initial stride phases in [0, 1).
        sensors: that the caller has, of :data:`symdyn.policy.observation.SENSORS`.

    Attributes:
        phase: (n,) stride phase.
        offsets: (n, 4) theta of the commanded gaits.
        velocity: (n, 3) commanded v_x, v_y (m/s) and yaw rate (rad/s).
        action: (n, 12) the policy's last actions; zero before the first.

    Raises:
        InvalidValue: if phases are not in [0, 1).
        PolicyMismatch: if the policy observes what these sensors do not tell.
    """

    def __init__(self, policy: Policy, phase: ArrayLike = (0.0,), sensors: Collection[str] = SENSORS) -> None:
        check_supplied(policy.metadata.observation, sensors, "The driver")
        self.policy = policy
        self.phase = np.array(phase, dtype=np.float64)
        if self.phase.ndim != 1 or not ((self.phase >= 0.0) & (self.phase < 1.0)).all():
            raise InvalidValue("The initial stride phase", self.phase.tolist(), "a list of numbers in [0, 1)")
        n = len(self.phase)
        self.offsets = np.zeros((n, len(LEGS)))
        self.velocity = np.zeros((n, 3))
        self.action = np.zeros((n, len(JOINTS)))
        self._default_joint_pos = np.array(policy.metadata.default_joint_pos)
        self._curves_for: Floats | None = None
        self._period = self._duty = np.zeros(n)

    def timing(self) -> Timing:
        """Period, duty factor and leg phases under the present commands."""
        period, duty = self._curves()
        v_x, reversal = self.velocity[:, 0], self.policy.metadata.time_reversal
        return Timing(period, duty, clock.leg_phase(self.phase, self.offsets, v_x, reversal))

    def observe(self, sensed: Sensed) -> Floats:
        """The policy's input, (n, size of its observation).

        Args:
            sensed: of the n robots.
        """
        timing = self.timing()
        situation = Situation(
            sensed=sensed,
            default_joint_pos=self._default_joint_pos,
            last_action=self.action,
            offsets=self.offsets,
            velocity=self.velocity,
            leg_phases=timing.leg_phases,
            duty=timing.duty,
        )
        return observe(self.policy.metadata.observation, situation)

    def act(self, sensed: Sensed) -> Floats:
        """Run the policy on :meth:`observe`, remember its actions, and return the joint targets, (n, 12) rad."""
        self.action = self.policy.act(self.observe(sensed)).astype(np.float64)
        return self.policy.targets(self.action)

    def advance(self, dt: float) -> None:
        """Move the clock on by dt, s."""
        period, _ = self._curves()
        self.phase = clock.advance(self.phase, period, dt)

    def _curves(self) -> tuple[Floats, Floats]:
        """Period (s) and duty factor, (n,) each; computed anew only when a velocity has changed."""
        v_x = self.velocity[:, 0]
        if self._curves_for is None or not np.array_equal(self._curves_for, v_x):
            meta, timing = self.policy.metadata, self.policy.timing
            self._period = timing.period(v_x, meta.leg_length)
            self._duty = timing.duty(v_x, meta.leg_length)
            self._curves_for = v_x.copy()
        return self._period, self._duty
