"""What can be made to go wrong: in what the robot says, in what it is told, and in the robot itself."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from hardware.robot_sim import effects
from hardware.robot_sim.settings import PERIOD
from symdyn.errors import UnknownName

if TYPE_CHECKING:
    from hardware.robot_sim.simulated_robot import SimulatedRobot

Protocol = Literal["lcm", "dds"]
"""Of the walk-these-ways-go2 bridge, or the robot's own."""


@dataclass(frozen=True)
class FaultKind:
    """Something that can be made to go wrong.

    Attributes:
        help: one line.
        effect: what it does.
        size: how much, if nobody says.
        unit: of the size; "" if it has none.
        lasts: how long, if nobody says, s.
        only: the protocol that it needs, or None if it can happen with any.
    """

    help: str
    effect: Callable[[float, SimulatedRobot, int], effects.Effect]
    size: float = 0.0
    unit: str = ""
    lasts: float = math.inf
    only: Protocol | None = None


FAULTS: dict[str, FaultKind] = {
    "silent": FaultKind("nothing is published", effects.Silent),
    "silent_state": FaultKind("neither joints nor IMU are published, but the joystick is", effects.SilentState),
    "silent_joints": FaultKind("no joint message", effects.SilentJoints),
    "silent_imu": FaultKind("no IMU message", effects.SilentImu),
    "silent_joystick": FaultKind("no joystick message", effects.SilentJoystick),
    "dropouts": FaultKind("this share of the messages is lost, at random", effects.Dropouts, 0.5),
    "late": FaultKind("messages arrive this much later", effects.Late, 10.0, "ms"),
    "frozen": FaultKind("the last joints and IMU are published again and again", effects.Frozen),
    "joystick_estop": FaultKind("L2 of the joystick is held", effects.EmergencyStop),
    "bridge_estop": FaultKind(
        "L2+B: the bridge stops, and motors keep their last command", effects.BridgeStop, only="lcm"
    ),
    "nan_stick": FaultKind("sticks at NaN", effects.NanStick),
    "nan_joint": FaultKind("NaN for a calf's position", effects.NanJoint),
    "inf_velocity": FaultKind("infinity for a calf's velocity", effects.InfiniteVelocity),
    "joint_out_of_range": FaultKind("a calf is reported this far beyond its range", effects.OutOfRange, 0.5, "rad"),
    "joint_velocity_spike": FaultKind("a calf is reported at this speed", effects.VelocitySpike, 80.0, "rad/s"),
    "torque_spike": FaultKind("a calf's motor is reported at this torque", effects.TorqueSpike, 90.0, "N m"),
    "nan_quat": FaultKind("NaN for the quaternion", effects.Quaternion),
    "quat_not_unit": FaultKind("a quaternion of this length", effects.QuaternionTooLong, 1.1),
    "quat_zero": FaultKind(
        "a quaternion of zeros, as before the bridge has data from the robot", effects.QuaternionZero
    ),
    "quat_inverse": FaultKind("the quaternion from world to trunk, not from trunk to world", effects.QuaternionInverse),
    "swapped_legs_state": FaultKind(
        "the reported joints of the front left and right leg are swapped", effects.SwappedState
    ),
    "swapped_legs_command": FaultKind("targets of the front left and right leg are swapped", effects.SwappedCommand),
    "swapped_legs_both": FaultKind(
        "reported joints and targets of the front left and right leg are swapped", effects.SwappedBoth
    ),
    "swapped_joints_state": FaultKind("reported states of a thigh and its calf are swapped", effects.SwappedJoints),
    "swapped_hips_state": FaultKind(
        "reported states of front and rear hips, alike at stand, are swapped", effects.SwappedHips
    ),
    "sign_flipped": FaultKind("a hip is reported with the wrong sign", effects.SignFlipped),
    "wrong_type": FaultKind("stray bytes on the robot's channels and on another", effects.WrongType, only="lcm"),
    "wrong_crc": FaultKind("the checksum of every LowState is wrong", effects.WrongChecksum, only="dds"),
    "second_deployer": FaultKind("another program also sends targets, at 50 Hz", effects.SecondDeployer),
    "tilt": FaultKind("a torque about the robot's long axis rolls it over", effects.Tilt, 60.0, "N m", 0.5),
    "push": FaultKind("a sudden sideways velocity", effects.Push, 0.8, "m/s", PERIOD),
    "payload": FaultKind("a mass on the trunk", effects.Payload, 4.0, "kg"),
    "slippery": FaultKind("a floor of this friction", effects.Slippery, 0.2),
    "joint_stuck": FaultKind("a thigh's gear seizes: it resists motion", effects.Stuck, 1000.0, "N m s/rad"),
    "motor_dead": FaultKind("a thigh's motor gives no torque", effects.DeadMotor),
}
"""By name."""


def get_fault(name: str) -> FaultKind:
    """The fault of that name. Raises UnknownName."""
    try:
        return FAULTS[name]
    except KeyError:
        raise UnknownName("fault", name, FAULTS) from None
