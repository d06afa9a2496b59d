"""What can be made to go wrong: in what the robot says, in what it is told, and in the robot itself."""

# mujoco is a compiled module without stubs
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from hardware.robot_sim.settings import PERIOD
from hardware.wire.channels import IMU, JOINTS, JOYSTICK, TARGETS
from hardware.wire.messages import pd_tau_targets_lcmt, rc_command_lcmt
from hardware.wire.readings import BUTTONS, SHOULDERS, Targets
from hardware.wire.sdk_order import SDK_JOINTS, unitree_joint_name
from symdyn.errors import UnknownName
from symdyn.robot.legs import JOINTS as JOINT_NAMES

if TYPE_CHECKING:
    from hardware.robot_sim.simulated_robot import SimulatedRobot

FOREIGN_SENDER = 5
"""``robot_id`` of the targets that the second deployer sends."""

_STATE = frozenset({JOINTS, IMU})
_THIGH, _CALF = "LF_thigh", "RF_calf"
_REPORTED = SDK_JOINTS.index(unitree_joint_name(_CALF))
_EVERY = round(0.02 / PERIOD)  # a second sender's period: 50 Hz, as usual for policies


class Effect:
    """What goes wrong while a fault lasts; all that a subclass does not say goes right.

    Args:
        size: how much, in the unit of the fault's entry in :data:`FAULTS`.
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


class _Silent(Effect):
    channels = frozenset({JOINTS, IMU, JOYSTICK})

    def outgoing(self, channel, message):
        return () if channel in self.channels else (message,)


class _SilentState(_Silent):
    channels = _STATE


class _SilentJoints(_Silent):
    channels = frozenset({JOINTS})


class _SilentImu(_Silent):
    channels = frozenset({IMU})


class _SilentJoystick(_Silent):
    channels = frozenset({JOYSTICK})


class _Dropouts(Effect):
    def outgoing(self, channel, message):
        return () if self.rng.random() < self.size else (message,)


class _Late(Effect):
    def begin(self):
        self._waiting = {channel: deque() for channel in (JOINTS, IMU, JOYSTICK)}

    def outgoing(self, channel, message):
        queue = self._waiting[channel]
        queue.append(message)
        return (queue.popleft(),) if len(queue) * PERIOD * 1e3 > self.size else ()


class _Frozen(Effect):
    def begin(self):
        self._last: dict[str, Any] = {}

    def outgoing(self, channel, message):
        return (self._last.setdefault(channel, message),) if channel in _STATE else (message,)


class _EmergencyStop(Effect):
    def outgoing(self, channel, message):
        if channel == JOYSTICK:
            setattr(message, SHOULDERS["L2"], 1)
        return (message,)


class _BridgeStop(_EmergencyStop):
    def begin(self):
        self.robot.stop_bridge()

    def outgoing(self, channel, message):
        if channel == JOYSTICK:
            message.mode = BUTTONS.index("B")
        return super().outgoing(channel, message)


class _NanStick(Effect):
    def outgoing(self, channel, message):
        if channel == JOYSTICK:
            message.left_stick = [math.nan, math.nan]
        return (message,)


class _Field(Effect):
    """Another value in one joint's number of a joint message."""

    field = "q"

    def value(self, was: float) -> float:
        return was

    def outgoing(self, channel, message):
        if channel == JOINTS:
            values = getattr(message, self.field)
            values[_REPORTED] = self.value(values[_REPORTED])
        return (message,)


class _NanJoint(_Field):
    def value(self, was):
        return math.nan


class _InfiniteVelocity(_Field):
    field = "qd"

    def value(self, was):
        return math.inf


class _OutOfRange(_Field):
    def value(self, was):
        return self.robot.joint_range[JOINT_NAMES.index(_CALF), 1] + self.size


class _VelocitySpike(_Field):
    field = "qd"

    def value(self, was):
        return self.size


class _TorqueSpike(_Field):
    field = "tau_est"

    def value(self, was):
        return self.size


class _Quaternion(Effect):
    factor = math.nan

    def outgoing(self, channel, message):
        if channel == IMU:
            message.quat = [self.factor * number for number in message.quat]
        return (message,)


class _QuaternionTooLong(_Quaternion):
    def begin(self):
        self.factor = self.size


class _QuaternionZero(_Quaternion):
    factor = 0.0


class _QuaternionInverse(Effect):
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


class _SwappedState(Effect):
    order = _exchanged(("FR", "FL"))

    def outgoing(self, channel, message):
        if channel == JOINTS:
            for field in ("q", "qd", "tau_est"):
                setattr(message, field, [getattr(message, field)[i] for i in self.order])
        return (message,)


class _SwappedJoints(_SwappedState):
    order = _exchanged(("RL_thigh", "RL_calf"))


class _SwappedHips(_SwappedState):
    order = _exchanged(("FR_hip", "RR_hip"), ("FL_hip", "RL_hip"))


class _SwappedCommand(Effect):
    order = _exchanged(("FR", "FL"))

    def incoming(self, message):
        for field in ("q_des", "qd_des", "tau_ff", "kp", "kd"):
            setattr(message, field, [getattr(message, field)[i] for i in self.order])
        return message


class _SwappedBoth(_SwappedState, _SwappedCommand):
    pass


class _SignFlipped(Effect):
    def outgoing(self, channel, message):
        if channel == JOINTS:
            for field in ("q", "qd", "tau_est"):
                values = getattr(message, field)
                values[SDK_JOINTS.index("FL_hip_joint")] *= -1.0
        return (message,)


class _WrongType(Effect):
    def begin(self):
        self._count = 0

    def besides(self):
        self._count += 1
        if self._count % _EVERY:
            return ()
        stray = rc_command_lcmt().encode()
        return ((JOINTS, stray), (IMU, stray[:20]), (JOYSTICK, b""), ("another_robots_channel", stray))


class _SecondDeployer(Effect):
    def begin(self):
        self._count = 0

    def besides(self):
        self._count += 1
        if self._count % _EVERY:
            return ()
        robot, n = self.robot.robot, len(JOINT_NAMES)
        targets = Targets(robot.default_joint_pos, np.full(n, robot.kp), np.full(n, robot.kd))
        return ((TARGETS, targets.message(self._count // _EVERY, FOREIGN_SENDER).encode()),)


class _Tilt(Effect):
    def begin(self):
        self.robot.wrench_w[3] = self.size

    def end(self):
        self.robot.wrench_w[3] = 0.0


class _Push(Effect):
    def begin(self):
        self.robot.kick(np.array([0.0, self.size, 0.0]))


class _Payload(Effect):
    def begin(self):
        self.robot.load(self.size)

    def end(self):
        self.robot.load(-self.size)


class _Slippery(Effect):
    def begin(self):
        model = self.robot.model
        self._floor = np.flatnonzero(model.geom_bodyid == 0)
        self._before = model.geom_friction[self._floor, 0].copy()
        model.geom_friction[self._floor, 0] = self.size

    def end(self):
        self.robot.model.geom_friction[self._floor, 0] = self._before


class _Stuck(Effect):
    def begin(self):
        name = self.robot.robot.joint_names[JOINT_NAMES.index(_THIGH)]
        self._dof = self.robot.model.joint(name).dofadr[0]
        self.robot.model.dof_damping[self._dof] += self.size

    def end(self):
        self.robot.model.dof_damping[self._dof] -= self.size


class _DeadMotor(Effect):
    def begin(self):
        self._motor = self.robot.model.actuator(_THIGH).id
        self._before = self.robot.model.actuator_forcerange[self._motor].copy()
        self.robot.model.actuator_forcerange[self._motor] = 0.0

    def end(self):
        self.robot.model.actuator_forcerange[self._motor] = self._before


@dataclass(frozen=True)
class FaultKind:
    """Something that can be made to go wrong.

    Attributes:
        help: one line.
        effect: what it does.
        size: how much, if nobody says.
        unit: of the size; "" if it has none.
        lasts: how long, if nobody says, s.
    """

    help: str
    effect: Callable[[float, SimulatedRobot, int], Effect]
    size: float = 0.0
    unit: str = ""
    lasts: float = math.inf


FAULTS: dict[str, FaultKind] = {
    "silent": FaultKind("nothing is published any more", _Silent),
    "silent_state": FaultKind("neither joints nor IMU are published, but the joystick is", _SilentState),
    "silent_joints": FaultKind("no joint message", _SilentJoints),
    "silent_imu": FaultKind("no IMU message", _SilentImu),
    "silent_joystick": FaultKind("no joystick message", _SilentJoystick),
    "dropouts": FaultKind("this share of the messages is lost, at random", _Dropouts, 0.5),
    "late": FaultKind("messages come this much later", _Late, 10.0, "ms"),
    "frozen": FaultKind("joints and IMU are published as they were", _Frozen),
    "joystick_estop": FaultKind("L2 of the joystick is held", _EmergencyStop),
    "bridge_estop": FaultKind("L2+B: the bridge stops, and motors keep their last command", _BridgeStop),
    "nan_stick": FaultKind("sticks at NaN", _NanStick),
    "nan_joint": FaultKind("NaN for a calf's position", _NanJoint),
    "inf_velocity": FaultKind("infinity for a calf's velocity", _InfiniteVelocity),
    "joint_out_of_range": FaultKind("a calf is reported so far beyond its range", _OutOfRange, 0.5, "rad"),
    "joint_velocity_spike": FaultKind("a calf is reported to be so fast", _VelocitySpike, 80.0, "rad/s"),
    "torque_spike": FaultKind("a calf's motor is reported to be so strong", _TorqueSpike, 90.0, "N m"),
    "nan_quat": FaultKind("NaN for the quaternion", _Quaternion),
    "quat_not_unit": FaultKind("a quaternion of this length", _QuaternionTooLong, 1.1),
    "quat_zero": FaultKind("a quaternion of zeros, as before the bridge has heard of the robot", _QuaternionZero),
    "quat_inverse": FaultKind("the quaternion from world to trunk, not from trunk to world", _QuaternionInverse),
    "swapped_legs_state": FaultKind("joints of front left and right are reported for each other", _SwappedState),
    "swapped_legs_command": FaultKind("joints of front left and right get each other's targets", _SwappedCommand),
    "swapped_legs_both": FaultKind(
        "front left and right, for each other in what is reported and in targets", _SwappedBoth
    ),
    "swapped_joints_state": FaultKind("a thigh and its calf are reported for each other", _SwappedJoints),
    "swapped_hips_state": FaultKind("front and rear hips, alike at stand, are reported for each other", _SwappedHips),
    "sign_flipped": FaultKind("a hip is reported with the other sign", _SignFlipped),
    "wrong_type": FaultKind("stray bytes on the robot's channels and on another", _WrongType),
    "second_deployer": FaultKind("another program sends targets, too, at 50 Hz", _SecondDeployer),
    "tilt": FaultKind("a torque about the robot's long axis rolls it over", _Tilt, 60.0, "N m", 0.5),
    "push": FaultKind("a sudden sideways velocity", _Push, 0.8, "m/s", PERIOD),
    "payload": FaultKind("a mass on the trunk", _Payload, 4.0, "kg"),
    "slippery": FaultKind("a floor of this friction", _Slippery, 0.2),
    "joint_stuck": FaultKind("a thigh's gear seizes: it resists motion", _Stuck, 1000.0, "N m s/rad"),
    "motor_dead": FaultKind("a thigh's motor gives no torque", _DeadMotor),
}
"""By name."""


def get_fault(name: str) -> FaultKind:
    """The fault of that name. Raises UnknownName."""
    try:
        return FAULTS[name]
    except KeyError:
        raise UnknownName("fault", name, FAULTS) from None
