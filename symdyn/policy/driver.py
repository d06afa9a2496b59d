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
from symdyn.policy.steering import STANDING_DUTY, stands
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
        velocity: (n, 3) v_x, v_y (m/s) and yaw rate (rad/s) asked for; taken over by the next :meth:`act`.
        command: (n, 3) the velocity that is followed: ``velocity`` after the dead band of the policy's steering.
        told: (n, 3) what the policy was told: ``command`` with the yaw rate of heading hold.
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
        self.command = np.zeros((n, 3))
        self.told = np.zeros((n, 3))
        self._heading: Floats | None = None  # to hold
        self.action = np.zeros((n, len(JOINTS)))
        self._default_joint_pos = np.array(policy.metadata.default_joint_pos)
        self._curves_for: Floats | None = None
        self._period = self._duty = np.zeros(n)

    def timing(self) -> Timing:
        """Period, duty factor and leg phases under the present commands."""
        period, duty = self._curves()
        v_x, reversal = self.command[:, 0], self.policy.metadata.time_reversal
        return Timing(period, duty, clock.leg_phase(self.phase, self.offsets, v_x, reversal))

    def observe(self, sensed: Sensed) -> Floats:
        """Take over the velocities; the policy's input, (n, size of its observation).

        Args:
            sensed: of the n robots.
        """
        self._steer(sensed)
        timing = self.timing()
        situation = Situation(
            sensed=sensed,
            default_joint_pos=self._default_joint_pos,
            last_action=self.action,
            offsets=self.offsets,
            velocity=self.told,
            leg_phases=timing.leg_phases,
            duty=timing.duty,
        )
        return observe(self.policy.metadata.observation, situation)

    def act(self, sensed: Sensed) -> Floats:
        """Run the policy on :meth:`observe`, remember its actions, and return the joint targets, (n, 12) rad."""
        self.action = self.policy.act(self.observe(sensed)).astype(np.float64)
        return self.policy.targets(self.action)

    def advance(self, dt: float) -> None:
        """Move the clock on by dt, s. That of a robot that stands does not move."""
        period, _ = self._curves()
        self.phase = clock.advance(self.phase, period, np.where(self.standing, 0.0, dt))

    @property
    def standing(self) -> NDArray[np.bool_]:
        """Which robots are told to stand still, (n,). A policy without steering steps in place instead."""
        return stands(self.command) & (self.policy.metadata.steering is not None)

    def _steer(self, sensed: Sensed) -> None:
        steering = self.policy.metadata.steering
        if steering is None:
            self.command = self.velocity.copy()
            self.told = self.command
            return
        self.command = steering.dead_band.apply(self.velocity, self.command)
        self.told = self.command
        if sensed.heading is not None:
            reference = sensed.heading if self._heading is None else self._heading
            self.told, self._heading = steering.heading_hold.apply(self.command, sensed.heading, reference)

    def _curves(self) -> tuple[Floats, Floats]:
        """Period (s) and duty factor, (n,) each; computed anew only when a velocity has changed."""
        if self._curves_for is None or not np.array_equal(self._curves_for, self.command):
            v_x, meta, timing = self.command[:, 0], self.policy.metadata, self.policy.timing
            self._period = timing.period(v_x, meta.leg_length)
            self._duty = np.where(self.standing, STANDING_DUTY, timing.duty(v_x, meta.leg_length))
            self._curves_for = self.command.copy()
        return self._period, self._duty
