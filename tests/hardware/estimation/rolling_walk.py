"""A trunk that moves as a formula says over feet that roll on the ground without slip: what sensors show, exactly."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from scipy.spatial.transform import Rotation

from hardware.estimation.kinematics import LegKinematics
from hardware.wire.readings import Imu, Joints
from symdyn.robot.legs import LEGS
from tests.robots import GO2

UP_W = np.array([0.0, 0.0, 1.0])
GRAVITY = 9.81


@cache
def legs() -> LegKinematics:
    """Of the Go2."""
    return LegKinematics(GO2)


@dataclass(frozen=True)
class Sample:
    """A moment: truth, and what sensors without noise show.

    Attributes:
        time: s.
        position_w: (3,) of the trunk, m.
        velocity_w: (3,) m/s.
        imu: attitude, angular velocity, acceleration.
        joints: positions and velocities.
    """

    time: float
    position_w: np.ndarray
    velocity_w: np.ndarray
    imu: Imu
    joints: Joints


@dataclass(frozen=True)
class Motion:
    """The trunk sways: constant velocity and sines, about the default stance.

    Attributes:
        velocity: (3,) constant part, m/s.
        sway: (3,) amplitude of each coordinate, m.
        tilt: (3,) amplitude of rotation about each axis, rad.
        rate: of the sines, rad/s; each coordinate a bit different.
    """

    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    sway: tuple[float, float, float] = (0.04, 0.03, 0.02)
    tilt: tuple[float, float, float] = (0.05, 0.08, 0.1)
    rate: float = 6.0

    def position(self, t: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Position from the start, velocity and acceleration in the world, (3,) each."""
        w = self.rate * np.array([1.0, 1.2, 1.5])
        a, phase = np.array(self.sway), np.array([0.0, 1.0, 2.0])
        v = np.array(self.velocity)
        return (
            v * t + a * (np.sin(w * t + phase) - np.sin(phase)),
            v + a * w * np.cos(w * t + phase),
            -a * w**2 * np.sin(w * t + phase),
        )

    def attitude(self, t: float) -> Rotation:
        """Of the body in the world."""
        w = self.rate * np.array([1.1, 0.9, 0.7])
        return Rotation.from_rotvec(np.array(self.tilt) * np.sin(w * t))

    def turn_b(self, t: float) -> np.ndarray:
        """Angular velocity in the body frame, (3,), by central differences of the attitude."""
        h = 1e-5
        return (self.attitude(t - h).inv() * self.attitude(t + h)).as_rotvec() / (2.0 * h)


def walk(motion: Motion, seconds: float, dt: float) -> list[Sample]:
    """Samples every ``dt``, s. All feet stay on the ground; joint angles are integrated (Runge-Kutta, 4th order)."""
    height = np.max(legs().feet(GO2.default_joint_pos).radius - legs().feet(GO2.default_joint_pos).centre_b[:, 2])
    joint_pos, found = GO2.default_joint_pos, []
    for k in range(round(seconds / dt) + 1):
        t = k * dt
        offset, velocity_w, acceleration_w = motion.position(t)
        attitude = motion.attitude(t)
        imu = Imu(
            quat_w=attitude.as_quat(scalar_first=True),
            angular_velocity_b=motion.turn_b(t),
            acceleration_b=attitude.inv().apply(acceleration_w + GRAVITY * UP_W),
            foot_force=np.full(len(LEGS), 100.0),
        )
        joints = Joints(joint_pos, joint_vel(motion, t, joint_pos), np.zeros(len(joint_pos)))
        found.append(Sample(t, height * UP_W + offset, velocity_w, imu, joints))
        joint_pos = _runge_kutta(motion, t, joint_pos, dt)
    return found


def joint_vel(motion: Motion, t: float, joint_pos: np.ndarray) -> np.ndarray:
    """(12,) joint velocities for which the lowest points of all feet stand still in the world."""
    attitude = motion.attitude(t)
    up_b = attitude.inv().apply(UP_W)
    velocity_b = attitude.inv().apply(motion.position(t)[1])
    feet = legs().feet(joint_pos)
    carried = velocity_b + np.cross(motion.turn_b(t), feet.sole_b(up_b))
    return -np.linalg.solve(feet.sole_jacobian_b(up_b), carried[..., None]).ravel()


def _runge_kutta(motion: Motion, t: float, q: np.ndarray, h: float) -> np.ndarray:
    k1 = joint_vel(motion, t, q)
    k2 = joint_vel(motion, t + h / 2, q + h / 2 * k1)
    k3 = joint_vel(motion, t + h / 2, q + h / 2 * k2)
    k4 = joint_vel(motion, t + h, q + h * k3)
    return q + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)


def turned(sample: Sample, angle: float) -> Sample:
    """The same in a world turned about the vertical by an angle, rad."""
    turn = Rotation.from_rotvec(angle * UP_W)
    quat_w = (turn * Rotation.from_quat(sample.imu.quat_w, scalar_first=True)).as_quat(scalar_first=True)
    return replace(
        sample,
        position_w=turn.apply(sample.position_w),
        velocity_w=turn.apply(sample.velocity_w),
        imu=replace(sample.imu, quat_w=quat_w),
    )
