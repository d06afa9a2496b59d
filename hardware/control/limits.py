"""The last word on what is sent: no torque beyond the motors', no joint driven into its stop."""

from __future__ import annotations

import numpy as np

from hardware.control.settings import SafetyConfig
from hardware.estimation.kinematics import JointLimits
from hardware.wire.readings import Floats, Joints, Targets

_SPARE = 0.5
"""Share of the torque limit that damping may take where it alone would leave no target within the range."""

_LEAST_KP = 1e-6
"""N m/rad; less is no stiffness."""


def target_range(joints: Joints, limits: JointLimits, lead: float) -> tuple[Floats, Floats]:
    """Where targets may lie: the joint's range, and beyond it by ``lead`` times the joint's distance from that end.

    Args:
        joints: as measured.
        limits: of the robot.
        lead: SafetyConfig.target_lead.

    Returns:
        lowest and highest target, (12,) rad each.
    """
    return (
        limits.lower - lead * np.maximum(joints.pos - limits.lower, 0.0),
        limits.upper + lead * np.maximum(limits.upper - joints.pos, 0.0),
    )


def limited(
    targets: Targets, previous: Floats, dt: float, joints: Joints, limits: JointLimits, safety: SafetyConfig
) -> Targets:
    """Targets within every limit.

    |kp (pos - q) - kd qd| <= torque limit, and :func:`target_range`, hold exactly for joints at most
    ``safety.position_margin`` beyond their range (further out is a fault). The rate limit yields to these two. Where
    damping alone would exceed the torque limit, kd is lowered.

    Args:
        targets: wanted.
        previous: the targets sent last, (12,) rad.
        dt: since then, s.
        joints: as measured; finite.
        limits: of the robot.
        safety: how much is allowed.
    """
    low, high = target_range(joints, limits, safety.target_lead)
    step = safety.target_rate * dt
    pos = np.minimum(np.maximum(targets.pos, previous - step), previous + step)
    kp, kd = targets.kp, targets.kd
    weakest, strongest = _torque_band(kp, kd, joints, limits)
    blocked = (weakest > high) | (strongest < low)
    if blocked.any():
        kd = np.where(blocked, np.minimum(kd, _SPARE * limits.torque / np.maximum(np.abs(joints.vel), 1e-9)), kd)
        weakest, strongest = _torque_band(kp, kd, joints, limits)
    pos = np.minimum(np.maximum(pos, np.maximum(low, weakest)), np.minimum(high, strongest))
    return Targets(pos, kp, kd)


def damping(joints: Joints | None, at: Floats, limits: JointLimits, safety: SafetyConfig) -> Targets:
    """No stiffness, and as much damping as the torque limits allow.

    Args:
        joints: as measured, or None if that is not known.
        at: (12,) rad, targets to name; with kp 0 they do nothing.
        limits: of the robot.
        safety: with the gain.
    """
    kd = np.full(len(at), safety.damping_kd)
    if joints is not None:
        speed = np.abs(joints.vel)
        kd = np.where(speed * kd > limits.torque, limits.torque / np.maximum(speed, 1e-9), kd)
    return Targets(pos=np.clip(at, limits.lower, limits.upper), kp=np.zeros(len(at)), kd=kd)


def _torque_band(kp: Floats, kd: Floats, joints: Joints, limits: JointLimits) -> tuple[Floats, Floats]:
    """The targets that ask for the lowest and the highest torque; far away without stiffness."""
    softness = 1.0 / np.maximum(kp, _LEAST_KP)
    middle, half = joints.pos + kd * joints.vel * softness, limits.torque * softness
    return middle - half, middle + half
