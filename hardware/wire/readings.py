"""What the robot says, as arrays in symdyn's order; and what it is told, as a message in the wire's."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from hardware.wire.messages import leg_control_data_lcmt, pd_tau_targets_lcmt, rc_command_lcmt, state_estimator_lcmt
from hardware.wire.sdk_order import JOINTS_FROM_SDK, JOINTS_TO_SDK, LEGS_FROM_SDK
from symdyn.robot.frames import gravity_components

Floats = NDArray[np.float64]

_JOINTS_FROM_SDK = np.array(JOINTS_FROM_SDK)
_JOINTS_TO_SDK = np.array(JOINTS_TO_SDK)
_LEGS_FROM_SDK = np.array(LEGS_FROM_SDK)

BUTTONS = ("A", "B", "X", "Y", "up", "right", "down", "left")
"""What ``mode`` of the controller's message counts."""

SHOULDERS = {
    "L1": "left_upper_switch",
    "L2": "left_lower_left_switch",
    "R1": "right_upper_switch",
    "R2": "right_lower_right_switch",
}
"""Fields of the controller's message by the button's name (bridge of walk-these-ways-go2)."""


@dataclass(frozen=True)
class Joints:
    """Joints in the order of symdyn.robot.legs.JOINTS.

    Attributes:
        pos: (12,) rad.
        vel: (12,) rad/s.
        torque: (12,) N m, as the motors estimate it.
    """

    pos: Floats
    vel: Floats
    torque: Floats

    @classmethod
    def of(cls, message: leg_control_data_lcmt) -> Joints:
        """From the wire."""
        return cls(*np.array([message.q, message.qd, message.tau_est])[:, _JOINTS_FROM_SDK])

    def finite(self) -> bool:
        """Whether all numbers are."""
        return bool(np.isfinite(np.concatenate([self.pos, self.vel, self.torque])).all())


@dataclass(frozen=True)
class Imu:
    """Trunk and feet; legs in the order of symdyn.robot.legs.LEGS.

    Attributes:
        quat_w: (4,) w, x, y, z of the trunk in the world; of length 1, or 0 before the bridge has heard of the robot.
        angular_velocity_b: (3,) rad/s.
        acceleration_b: (3,) m/s^2, what an accelerometer shows: at rest, gravity's reaction, upwards.
        foot_force: (4,) in the robot's own unit, which is not documented.
    """

    quat_w: Floats
    angular_velocity_b: Floats
    acceleration_b: Floats
    foot_force: Floats

    @classmethod
    def of(cls, message: state_estimator_lcmt) -> Imu:
        """From the wire."""
        return cls(
            quat_w=np.array(message.quat),
            angular_velocity_b=np.array(message.omegaBody),
            acceleration_b=np.array(message.aBody),
            foot_force=np.array(message.contact_estimate)[_LEGS_FROM_SDK],
        )

    def finite(self) -> bool:
        """Whether all numbers are."""
        return bool(np.isfinite(np.concatenate(self.parts)).all())

    @property
    def parts(self) -> tuple[Floats, Floats, Floats, Floats]:
        """All arrays, as they stand above."""
        return self.quat_w, self.angular_velocity_b, self.acceleration_b, self.foot_force

    @cached_property
    def gravity_b(self) -> Floats:
        """Unit vector of gravity in the body frame, (3,)."""
        return np.array(gravity_components(*self.quat_w.tolist()))


@dataclass(frozen=True)
class Joystick:
    """The wireless controller.

    Attributes:
        left: (x, y) of the left stick in [-1, 1]; right and forward are positive.
        right: the same of the right stick.
        button: of :data:`BUTTONS`, the one pressed last; ``A`` before any was.
        held: of :data:`SHOULDERS`, those held down now.
    """

    left: tuple[float, float]
    right: tuple[float, float]
    button: str
    held: frozenset[str]

    @classmethod
    def of(cls, message: rc_command_lcmt) -> Joystick:
        """From the wire. A ``mode`` that is no button counts as the first."""
        button = BUTTONS[message.mode] if 0 <= message.mode < len(BUTTONS) else BUTTONS[0]
        held = frozenset(name for name, field in SHOULDERS.items() if getattr(message, field))
        (left_x, left_y), (right_x, right_y) = message.left_stick, message.right_stick
        return cls((left_x, left_y), (right_x, right_y), button, held)

    def finite(self) -> bool:
        """Whether all numbers are."""
        return bool(np.isfinite([*self.left, *self.right]).all())


@dataclass(frozen=True)
class Targets:
    """What each motor shall do: torque = kp (pos - q) - kd qd. Joints in the order of symdyn.robot.legs.JOINTS.

    Attributes:
        pos: (12,) rad.
        kp: (12,) N m/rad.
        kd: (12,) N m s/rad.
    """

    pos: Floats
    kp: Floats
    kd: Floats

    def message(self, number: int, sender: int) -> pd_tau_targets_lcmt:
        """For the wire.

        Args:
            number: counts the messages of a sender; the wire's ``id``.
            sender: who sends; the wire's ``robot_id``. The bridge reads neither.
        """
        message = pd_tau_targets_lcmt()
        message.q_des = self.pos[_JOINTS_TO_SDK].tolist()
        message.kp = self.kp[_JOINTS_TO_SDK].tolist()
        message.kd = self.kd[_JOINTS_TO_SDK].tolist()
        message.id, message.robot_id = number, sender
        return message

    @classmethod
    def of(cls, message: pd_tau_targets_lcmt) -> Targets:
        """From the wire."""
        return cls(*(np.array(array)[_JOINTS_FROM_SDK] for array in (message.q_des, message.kp, message.kd)))
