"""Is what the robot says fresh, finite and within its limits?"""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from hardware.control.faults import Fault
from hardware.control.message_rate import MessageRate
from hardware.control.settings import SafetyConfig
from hardware.estimation.kinematics import JointLimits
from hardware.wire.link import Received
from hardware.wire.readings import Imu, Joints, Joystick
from symdyn.robot.legs import JOINTS


def tilt(imu: Imu) -> float:
    """Angle between the trunk's z axis and the vertical, rad."""
    return math.acos(min(1.0, max(-1.0, -float(imu.gravity_b[2]))))


class Health:
    """Judges the newest messages at every tick; remembers what it needs of the ticks before.

    Args:
        limits: of the robot.
        config: what is allowed.
    """

    def __init__(self, limits: JointLimits, config: SafetyConfig) -> None:
        self._config = config
        self._speed, torque = config.velocity_factor * limits.velocity, config.torque_factor * limits.torque
        # of pos, vel, torque of all joints: beyond these a position is a fault, speed and torque are if they last
        self._lower = np.concatenate([limits.lower - config.position_margin, -self._speed, -torque])
        self._upper = np.concatenate([limits.upper + config.position_margin, self._speed, torque])
        self._suspect_at = -math.inf
        self._fast: deque[tuple[float, np.ndarray]] = deque()
        self._strong_since: np.ndarray = np.full(len(JOINTS), math.inf)
        self._last_numbers: np.ndarray | None = None
        self._changed_at = -math.inf
        self._rates = {"joint": MessageRate(), "IMU": MessageRate()}

    def state_fault(
        self, now: float, joints_at: Received | None, imu_at: Received | None, joints: Joints | None, imu: Imu | None
    ) -> Fault | None:
        """What is wrong with joints and IMU, or None.

        Args:
            now: s of the clock of the arrivals.
            joints_at: the newest joint message.
            imu_at: the newest IMU message.
            joints: what it says.
            imu: what it says.
        """
        if joints_at is None or joints is None or now - joints_at.arrival > self._config.stale_s:
            return Fault("no_joint_state", _age(now, joints_at))
        if imu_at is None or imu is None or now - imu_at.arrival > self._config.stale_s:
            return Fault("no_imu_state", _age(now, imu_at))
        if (fault := self._two_robots(now, joints_at, imu_at)) is not None:
            return fault
        numbers = np.concatenate([joints.pos, joints.vel, joints.torque, *imu.parts])
        if not np.isfinite(numbers).all():
            return Fault("state_not_finite", "IMU" if joints.finite() else "joints")
        length = math.hypot(*imu.quat_w.tolist())
        if abs(length - 1.0) > self._config.quaternion_tolerance:
            return Fault("quaternion", f"its length is {length:.3f}")
        return self._frozen(now, joints, imu) or self._tilted(imu) or self._beyond_limits(now, joints, numbers)

    def joystick_fault(self, now: float, joystick_at: Received | None, joystick: Joystick | None) -> Fault | None:
        """What is wrong with the joystick, or None."""
        if joystick_at is None or joystick is None or now - joystick_at.arrival > self._config.joystick_s:
            return Fault("no_joystick", _age(now, joystick_at))
        if not joystick.finite():
            return Fault("state_not_finite", "joystick")
        return None

    def _two_robots(self, now: float, joints_at: Received, imu_at: Received) -> Fault | None:
        """Nothing in a message names its sender, but two senders double the rate."""
        for what, newest in (("joint", joints_at), ("IMU", imu_at)):
            rate = self._rates[what].update(now, newest)
            if rate is not None and rate > self._config.rate_factor * self._config.message_rate:
                return Fault("second_robot", f"{rate:.0f} {what} messages/s")
        return None

    def _frozen(self, now: float, joints: Joints, imu: Imu) -> Fault | None:
        numbers = np.concatenate([joints.pos, joints.vel, imu.angular_velocity_b, imu.acceleration_b])
        if self._last_numbers is None or not np.array_equal(numbers, self._last_numbers):
            self._last_numbers, self._changed_at = numbers, now
        still = now - self._changed_at
        return Fault("frozen_state", f"for {still:.2f} s") if still > self._config.frozen_s else None

    def _tilted(self, imu: Imu) -> Fault | None:
        angle = tilt(imu)
        return Fault("tilt", f"{angle:.2f} rad") if angle > self._config.tilt else None

    def _beyond_limits(self, now: float, joints: Joints, numbers: np.ndarray) -> Fault | None:
        """Each joint's position, its speed over a while, its torque over a while."""
        self._fast.append((now, joints.vel))
        while now - self._fast[0][0] > self._config.velocity_s + 1e-9:
            self._fast.popleft()
        limited = numbers[: len(self._lower)]
        beyond = (limited < self._lower) | (limited > self._upper)
        if beyond.any():
            self._suspect_at = now
        # a mean that is too high has a sample that is; so all is well if none has been for as long as means are taken
        if now - self._suspect_at > max(self._config.velocity_s, self._config.torque_s):
            self._strong_since[:] = math.inf
            return None
        out_of_range, _, strong = np.split(beyond, 3)
        self._strong_since = np.where(strong, np.minimum(self._strong_since, now), math.inf)
        if out_of_range.any():
            worst = int(np.argmax(np.maximum(self._lower - limited, limited - self._upper)[: len(JOINTS)]))
            return Fault("joint_position", f"{JOINTS[worst]} is at {joints.pos[worst]:.2f} rad")
        return self._too_fast() or self._too_strong(now, joints)

    def _too_fast(self) -> Fault | None:
        speed = np.mean([np.abs(vel) for _, vel in self._fast], axis=0)
        over = speed / self._speed
        worst = int(np.argmax(over))
        whole = self._fast[-1][0] - self._fast[0][0] > 0.5 * self._config.velocity_s
        if not whole or over[worst] <= 1.0:
            return None
        return Fault("joint_velocity", f"{JOINTS[worst]} at {speed[worst]:.1f} rad/s")

    def _too_strong(self, now: float, joints: Joints) -> Fault | None:
        longest = int(np.argmin(self._strong_since))
        if now - self._strong_since[longest] <= self._config.torque_s:
            return None
        return Fault("joint_torque", f"{JOINTS[longest]} at {joints.torque[longest]:.1f} N m")


def _age(now: float, received: Received | None) -> str:
    return "none has arrived yet" if received is None else f"the last is {now - received.arrival:.3f} s old"
