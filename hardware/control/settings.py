"""Every number of the deployer that a user may set."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields
from typing import Literal

from hardware.control.joystick import JoystickConfig
from hardware.estimation.settings import ContactConfig, EstimatorConfig
from symdyn.errors import InvalidValue

TICK_HZ = 200.0
"""Ticks a second: limits are checked and targets sent at each; the policy runs at its own rate, in every fourth."""


@dataclass(frozen=True)
class SafetyConfig:
    """When to leave Stand or Run for Damp, and what targets are let through. ``docs/robot.md`` has the table.

    Attributes:
        stale_s: largest age of the newest joint or IMU message, s; 0.05 is ten messages at the bridge's 500 Hz.
        frozen_s: longest time without a change in any number, s; the last digits of a real encoder and gyroscope always
            change.
        message_rate: rate of the bridge's messages on each channel of the state, 1/s; 500 for a Go2.
        rate_factor: largest multiple of ``message_rate``, as the median over 0.2 s; two robots on one URL send twice as
            many.
        joystick_s: largest age of the newest joystick message, s.
        tilt: largest angle between the trunk's z axis and the vertical, rad; below the bridge's own 0.8, and above the
            0.52 of the shipped policy's hardest reversals in simulation.
        quaternion_tolerance: largest deviation of the quaternion's length from 1.
        position_margin: how far beyond its range a joint may read, rad; in simulation calves reach 0.11 at touchdown.
        velocity_factor: largest multiple of the URDF's velocity limit, as a mean over ``velocity_s``. The shipped
            policy's peaks in simulation, which has no such limit, are three times the calf's.
        velocity_s: time over which a joint's speed is averaged, s.
        torque_factor: largest multiple of the URDF's torque limit, during all of ``torque_s``.
        torque_s: time for which a torque must be too large, s.
        overruns: number of late ticks in a row that is a fault.
        target_rate: fastest change of a joint target, rad/s; one and a half times what the shipped policy asks for in
            99.9% of its steps.
        target_lead: how far beyond its range a joint's target may lie, in multiples of the joint's own distance from
            that end. So a joint is never driven into its stop, and can still push off through a stretching knee.
        damping_kd: velocity gain of damping, N m s/rad; less for a joint so fast that its torque limit would be
            exceeded.
        wiggle: angle by which each joint is moved at stand, rad.
        wiggle_answer: smallest share of ``wiggle`` by which the joint must follow, and largest by which another may.
        tilt_explained: smallest share of the trunk's tilt at stand, while the knees are moved, that another order of
            the legs must explain to be taken for the true one.
        stand_error: largest deviation of a joint from the stance at the end of Stand, rad.
    """

    stale_s: float = 0.05
    frozen_s: float = 0.1
    message_rate: float = 500.0
    rate_factor: float = 1.5
    joystick_s: float = 0.5
    tilt: float = 0.7
    quaternion_tolerance: float = 0.02
    position_margin: float = 0.15
    velocity_factor: float = 2.0
    velocity_s: float = 0.02
    torque_factor: float = 1.2
    torque_s: float = 0.05
    overruns: int = 3
    target_rate: float = 100.0
    target_lead: float = 2.0
    damping_kd: float = 4.0
    wiggle: float = 0.08
    wiggle_answer: float = 0.4
    tilt_explained: float = 0.25
    stand_error: float = 0.25

    def __post_init__(self) -> None:
        _check_positive(self, "safety")


@dataclass(frozen=True)
class StandConfig:
    """How the robot stands up.

    Attributes:
        rise_s: time from the measured pose to the stance, s.
        ramp_s: time in which the gains rise from zero, s.
        settle_s: time to come to rest before the joints are moved one by one, s.
        wiggle_s: time for which each joint is moved, s.
        kp: position gain, N m/rad; above the policy's, so that the robot reaches its stance from the floor.
        kd: velocity gain, N m s/rad.
    """

    rise_s: float = 2.0
    ramp_s: float = 0.5
    settle_s: float = 0.5
    wiggle_s: float = 0.2
    kp: float = 60.0
    kd: float = 3.0

    def __post_init__(self) -> None:
        _check_positive(self, "stand")


@dataclass(frozen=True)
class Settings:
    """All of them.

    Attributes:
        safety: faults and limits.
        stand: standing up.
        joystick: sticks and buttons.
        contact: contact of the feet.
        estimator: estimate of the trunk's velocity, for display and log only.
        identify: instead of running the policy, move every joint by a script of two minutes, for symdyn identify;
            "hung" with the feet in the air (tells everything), "standing" with the feet on the floor (tells delays and
            gains). The policy's gains hold, and every check and limit.
    """

    safety: SafetyConfig = field(default_factory=SafetyConfig)
    stand: StandConfig = field(default_factory=StandConfig)
    joystick: JoystickConfig = field(default_factory=JoystickConfig)
    contact: ContactConfig = field(default_factory=ContactConfig)
    estimator: EstimatorConfig = field(default_factory=EstimatorConfig)
    identify: Literal["no", "hung", "standing"] = "no"

    def __post_init__(self) -> None:
        if self.identify not in ("no", "hung", "standing"):
            raise InvalidValue("identify", self.identify, "'no', 'hung' or 'standing'")


def _check_positive(config: object, prefix: str) -> None:
    for item in fields(config):  # type: ignore[arg-type]
        value = getattr(config, item.name)
        if not 0.0 < value < math.inf:
            raise InvalidValue(f"{prefix}.{item.name}", value, "a number > 0")
