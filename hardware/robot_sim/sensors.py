"""What a Go2's sensors make of the truth: noise, and feet that weigh in a unit of their own."""

# mujoco is a compiled module without stubs
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

import math
from dataclasses import dataclass, fields

import mujoco
import numpy as np
from numpy.typing import NDArray

from symdyn.errors import InvalidValue
from symdyn.robot.legs import JOINTS, LEGS

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class SensorNoise:
    """Standard deviations of white Gaussian noise in every message, and of what is drawn once and stays.

    No data sheet of the Go2 says them. Those of gyroscope and accelerometer are the square roots of the covariances
    that configuration files for Unitree's robots in the family of legged_control give (0.0004 and 0.01). The others are
    assumptions, a fifth or less of the half-widths that training is hardened against (symdyn.policy.observation).

    Attributes:
        joint_pos: rad.
        joint_vel: rad/s.
        torque: N m.
        attitude: of each component of a small rotation, rad.
        attitude_bias: of roll and pitch, drawn once, rad.
        angular_velocity: rad/s.
        angular_velocity_bias: of each component, drawn once, rad/s.
        acceleration: m/s^2.
        foot_force: in the feet's own unit.
    """

    joint_pos: float = 0.002
    joint_vel: float = 0.1
    torque: float = 0.2
    attitude: float = 0.002
    attitude_bias: float = 0.005
    angular_velocity: float = 0.02
    angular_velocity_bias: float = 0.002
    acceleration: float = 0.1
    foot_force: float = 2.0

    def __post_init__(self) -> None:
        for field in fields(self):
            if not 0.0 <= getattr(self, field.name) < np.inf:
                raise InvalidValue(f"noise.{field.name}", getattr(self, field.name), "a number >= 0")


NO_NOISE = SensorNoise(**{field.name: 0.0 for field in fields(SensorNoise)})
"""Sensors that show the truth; the feet's, in their own unit."""

FOOT_GAIN = (1.6, 2.4)
"""Raw units per N. A standing foot bears 25 to 50 N and a trotting one 75 on average, so that thresholds from 20 to 60
part stance from swing and 200, the Go1's, is not reached in a walk: what users of the Go2 report."""

FOOT_OFFSET = (-5.0, 12.0)
"""Raw units that a foot shows in the air; with noise below 20."""


def _slices(*sizes: int) -> list[slice]:
    ends = np.cumsum(sizes).tolist()
    return [slice(end - size, end) for size, end in zip(sizes, ends, strict=True)]


_SIZES = (3, len(LEGS), len(JOINTS), len(JOINTS), len(JOINTS), 3, 3)
_ATTITUDE, _FEET, _POS, _VEL, _TORQUE, _TURN, _ACCELERATION = _slices(*_SIZES)
_NUMBERS = sum(_SIZES)


@dataclass(frozen=True)
class Truth:
    """What there is to be measured. Joints in the order of JOINTS, legs in that of LEGS.

    Attributes:
        joint_pos: (12,) rad.
        joint_vel: (12,) rad/s.
        torque: (12,) N m.
        quat_w: (4,) w, x, y, z.
        angular_velocity_b: (3,) rad/s.
        acceleration_b: (3,) what an accelerometer shows, m/s^2.
        foot_force: (4,) N.
    """

    joint_pos: Floats
    joint_vel: Floats
    torque: Floats
    quat_w: Floats
    angular_velocity_b: Floats
    acceleration_b: Floats
    foot_force: Floats


class Sensors:
    """A robot's sensors. The same seed gives the same robot and the same noise.

    Args:
        noise: how good they are.
        seed: decides noise, biases, and gain and offset of each foot.
    """

    def __init__(self, noise: SensorNoise, seed: int) -> None:
        self._noise = noise
        self._rng = np.random.default_rng(seed)
        self._foot_gain = self._rng.uniform(*FOOT_GAIN, len(LEGS))
        self._foot_offset = self._rng.uniform(*FOOT_OFFSET, len(LEGS))
        self._tilt = noise.attitude_bias * np.append(self._rng.standard_normal(2), 0.0)
        self._drift = noise.angular_velocity_bias * self._rng.standard_normal(3)

    def measure(self, truth: Truth) -> Truth:
        """The truth as the sensors see it; ``foot_force`` in raw, whole units."""
        noise, white = self._noise, self._rng.standard_normal(_NUMBERS)
        quat_w = truth.quat_w.copy()
        mujoco.mju_quatIntegrate(quat_w, self._tilt + noise.attitude * white[_ATTITUDE], 1.0)
        raw = self._foot_offset + self._foot_gain * truth.foot_force + noise.foot_force * white[_FEET]
        return Truth(
            joint_pos=truth.joint_pos + noise.joint_pos * white[_POS],
            joint_vel=truth.joint_vel + noise.joint_vel * white[_VEL],
            torque=truth.torque + noise.torque * white[_TORQUE],
            quat_w=quat_w,
            angular_velocity_b=truth.angular_velocity_b + self._drift + noise.angular_velocity * white[_TURN],
            acceleration_b=truth.acceleration_b + noise.acceleration * white[_ACCELERATION],
            foot_force=np.rint(raw),
        )


def roll_pitch_yaw(quat_w: Floats) -> tuple[float, float, float]:
    """Angles in rad of the rotation Rz(yaw) Ry(pitch) Rx(roll) that (4,) w, x, y, z stands for."""
    w, x, y, z = quat_w.tolist()
    return (
        math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y)),
        math.asin(min(1.0, max(-1.0, 2.0 * (w * y - z * x)))),
        math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)),
    )


def rotate(quat_w: Floats, vector_b: Floats) -> Floats:
    """A body vector in the world frame, (3,), from (4,) and (3,)."""
    vector_w = np.empty(3)
    mujoco.mju_rotVecQuat(vector_w, vector_b, quat_w)
    return vector_w


def rotate_inverse(quat_w: Floats, vector_w: Floats) -> Floats:
    """A world vector in the body frame, (3,); symdyn.robot.frames has it for arrays, MuJoCo is fifty times faster."""
    inverse, vector_b = np.empty(4), np.empty(3)
    mujoco.mju_negQuat(inverse, quat_w)
    mujoco.mju_rotVecQuat(vector_b, vector_w, inverse)
    return vector_b
