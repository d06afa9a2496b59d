"""What faults do: to what the robot says, to what it is told, and to the robot itself."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from hardware.robot_sim.settings import PERIOD
from hardware.wire.channels import IMU, JOINTS, JOYSTICK, TARGETS
from hardware.wire.messages import pd_tau_targets_lcmt, rc_command_lcmt
from hardware.wire.readings import BUTTONS, SHOULDERS, Targets
from hardware.wire.sdk_order import SDK_JOINTS, unitree_joint_name
from symdyn.robot.legs import JOINTS as JOINT_NAMES

if TYPE_CHECKING:
    from hardware.robot_sim.simulated_robot import SimulatedRobot

FOREIGN_SENDER = 5
"""``robot_id`` of the targets that the second deployer, or the second writer of LowCmd, sends."""

_STATE = frozenset({JOINTS, IMU})
_THIGH, _CALF = "LF_thigh", "RF_calf"
_REPORTED = SDK_JOINTS.index(unitree_joint_name(_CALF))
_EVERY = round(0.02 / PERIOD)  # a second sender's period: 50 Hz, as usual for policies


class Effect:
    """What goes wrong while a fault lasts; all that a subclass does not say goes right.

    Args:
        size: how much, in the unit of the fault's entry in :data:`hardware.robot_sim.faults.FAULTS`.
        robot: that it happens to.
        seed: of what is random.
    """

    def __init__(self, size: float, robot: SimulatedRobot, seed: int) -> None:
        self.size, self.robot = size, robot
        self.rng = np.random.default_rng(seed)

    def begin(self) -> None:
        """Once, when it begins."""

    def end(self) -> None:
        """Once, when it is over."""

    def outgoing(self, channel: str, message: Any) -> Sequence[Any]:
        """What the robot publishes instead of a message; it may be changed."""
        return (message,)

    def incoming(self, message: pd_tau_targets_lcmt) -> pd_tau_targets_lcmt:
        """What reaches the motors instead of targets; they may be changed."""
        return message

    def besides(self) -> Sequence[tuple[str, bytes]]:
        """What somebody else publishes in this period: channel and bytes."""
        return ()

    def damaged(self, low_state: bytes) -> bytes:
        """What goes over DDS instead of a LowState."""
        return low_state


class Silent(Effect):
    channels = frozenset({JOINTS, IMU, JOYSTICK})

    def outgoing(self, channel, message):
        return () if channel in self.channels else (message,)


class SilentState(Silent):
    channels = _STATE


class SilentJoints(Silent):
    channels = frozenset({JOINTS})


class SilentImu(Silent):
    channels = frozenset({IMU})


class SilentJoystick(Silent):
    channels = frozenset({JOYSTICK})


class Dropouts(Effect):
    def outgoing(self, channel, message):
        return () if self.rng.random() < self.size else (message,)


class Late(Effect):
    def begin(self):
        self._waiting = {channel: deque() for channel in (JOINTS, IMU, JOYSTICK)}

    def outgoing(self, channel, message):
        queue = self._waiting[channel]
        queue.append(message)
        return (queue.popleft(),) if len(queue) * PERIOD * 1e3 > self.size else ()


class Frozen(Effect):
    def begin(self):
        self._last: dict[str, Any] = {}

    def outgoing(self, channel, message):
        return (self._last.setdefault(channel, message),) if channel in _STATE else (message,)


class EmergencyStop(Effect):
    def outgoing(self, channel, message):
        if channel == JOYSTICK:
            setattr(message, SHOULDERS["L2"], 1)
        return (message,)


class BridgeStop(EmergencyStop):
    def begin(self):
        self.robot.stop_bridge()

    def outgoing(self, channel, message):
        if channel == JOYSTICK:
            message.mode = BUTTONS.index("B")
        return super().outgoing(channel, message)


class NanStick(Effect):
    def outgoing(self, channel, message):
        if channel == JOYSTICK:
            message.left_stick = [math.nan, math.nan]
        return (message,)


class Field(Effect):
    """Another value in one joint's number of a joint message."""

    field = "q"

    def value(self, was: float) -> float:
        return was

    def outgoing(self, channel, message):
        if channel == JOINTS:
            values = getattr(message, self.field)
            values[_REPORTED] = self.value(values[_REPORTED])
        return (message,)


class NanJoint(Field):
    def value(self, was):
        return math.nan


class InfiniteVelocity(Field):
    field = "qd"

    def value(self, was):
        return math.inf


class OutOfRange(Field):
    def value(self, was):
        return self.robot.joint_range[JOINT_NAMES.index(_CALF), 1] + self.size


class VelocitySpike(Field):
    field = "qd"

    def value(self, was):
        return self.size


class TorqueSpike(Field):
    field = "tau_est"

    def value(self, was):
        return self.size


class Quaternion(Effect):
    factor = math.nan

    def outgoing(self, channel, message):
        if channel == IMU:
            message.quat = [self.factor * number for number in message.quat]
        return (message,)


class QuaternionTooLong(Quaternion):
    def begin(self):
        self.factor = self.size


class QuaternionZero(Quaternion):
    factor = 0.0


class QuaternionInverse(Effect):
    def outgoing(self, channel, message):
        if channel == IMU:
            w, *vector = message.quat
            message.quat = [w, *(-part for part in vector)]
        return (message,)


def _exchanged(*pairs: tuple[str, str]) -> list[int]:
    # which number of the wire stands where, if these joints, or all joints of these legs, are taken for each other
    renamed = list(SDK_JOINTS)
    for a, b in pairs:
        renamed = [
            b + name.removeprefix(a) if name.startswith(a) else a + name.removeprefix(b) if name.startswith(b) else name
            for name in renamed
        ]
    return [SDK_JOINTS.index(name) for name in renamed]


class SwappedState(Effect):
    order = _exchanged(("FR", "FL"))

    def outgoing(self, channel, message):
        if channel == JOINTS:
            for field in ("q", "qd", "tau_est"):
                setattr(message, field, [getattr(message, field)[i] for i in self.order])
        return (message,)


class SwappedJoints(SwappedState):
    order = _exchanged(("RL_thigh", "RL_calf"))


class SwappedHips(SwappedState):
    order = _exchanged(("FR_hip", "RR_hip"), ("FL_hip", "RL_hip"))


class SwappedCommand(Effect):
    order = _exchanged(("FR", "FL"))

    def incoming(self, message):
        for field in ("q_des", "qd_des", "tau_ff", "kp", "kd"):
            setattr(message, field, [getattr(message, field)[i] for i in self.order])
        return message


class SwappedBoth(SwappedState, SwappedCommand):
    pass


class SignFlipped(Effect):
    def outgoing(self, channel, message):
        if channel == JOINTS:
            for field in ("q", "qd", "tau_est"):
                values = getattr(message, field)
                values[SDK_JOINTS.index("FL_hip_joint")] *= -1.0
        return (message,)


class WrongType(Effect):
    def begin(self):
        self._count = 0

    def besides(self):
        self._count += 1
        if self._count % _EVERY:
            return ()
        stray = rc_command_lcmt().encode()
        return ((JOINTS, stray), (IMU, stray[:20]), (JOYSTICK, b""), ("another_robots_channel", stray))


class WrongChecksum(Effect):
    def damaged(self, low_state):
        return low_state[:-1] + bytes([low_state[-1] ^ 1])


class SecondDeployer(Effect):
    def begin(self):
        self._count = 0

    def besides(self):
        self._count += 1
        if self._count % _EVERY:
            return ()
        robot, n = self.robot.robot, len(JOINT_NAMES)
        targets = Targets(robot.default_joint_pos, np.full(n, robot.kp), np.full(n, robot.kd))
        return ((TARGETS, targets.message(self._count // _EVERY, FOREIGN_SENDER).encode()),)


class Tilt(Effect):
    def begin(self):
        self.robot.wrench_w[3] = self.size

    def end(self):
        self.robot.wrench_w[3] = 0.0


class Push(Effect):
    def begin(self):
        self.robot.kick(np.array([0.0, self.size, 0.0]))


class Payload(Effect):
    def begin(self):
        self.robot.load(self.size)

    def end(self):
        self.robot.load(-self.size)


class Slippery(Effect):
    def begin(self):
        model = self.robot.model
        self._floor = np.flatnonzero(model.geom_bodyid == 0)
        self._before = model.geom_friction[self._floor, 0].copy()
        model.geom_friction[self._floor, 0] = self.size

    def end(self):
        self.robot.model.geom_friction[self._floor, 0] = self._before


class Stuck(Effect):
    def begin(self):
        name = self.robot.robot.joint_names[JOINT_NAMES.index(_THIGH)]
        self._dof = self.robot.model.joint(name).dofadr[0]
        self.robot.model.dof_damping[self._dof] += self.size

    def end(self):
        self.robot.model.dof_damping[self._dof] -= self.size


class DeadMotor(Effect):
    def begin(self):
        self._motor = self.robot.model.actuator(_THIGH).id
        self._before = self.robot.model.actuator_forcerange[self._motor].copy()
        self.robot.model.actuator_forcerange[self._motor] = 0.0

    def end(self):
        self.robot.model.actuator_forcerange[self._motor] = self._before
