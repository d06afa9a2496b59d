"""What can go wrong, in one table: the display, the log, the tests and docs/robot.md take it from here."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class FaultKind:
    """A reason to leave Stand or Run for Damp.

    Attributes:
        name: as in logs.
        limit: when it strikes; a template over the fields of :class:`hardware.control.settings.SafetyConfig`.
        means: what it usually means.
        help: what to do.
    """

    name: str
    limit: str
    means: str
    help: str


FAULTS: dict[str, FaultKind] = {
    kind.name: kind
    for kind in (
        FaultKind(
            "stop_requested",
            "SIGINT (Ctrl-C) or SIGTERM",
            "the operator ended the deployer",
            "press Ctrl-C again, or L1, to end the damping",
        ),
        FaultKind(
            "emergency_stop", "a stop button of the joystick is held", "the operator stopped the robot", "L1, then R1"
        ),
        FaultKind(
            "receiver_dead",
            "the receiving thread has ended",
            "a defect or a lost network interface",
            "read the messages on the terminal; restart the deployer",
        ),
        FaultKind(
            "no_joint_state",
            "no message on leg_control_data for {stale_s} s",
            "the bridge, the cable or the network is down",
            "check cable and bridge: docs/robot.md, 'Network'",
        ),
        FaultKind(
            "no_imu_state",
            "no message on state_estimator_data for {stale_s} s",
            "the bridge, the cable or the network is down",
            "check cable and bridge: docs/robot.md, 'Network'",
        ),
        FaultKind(
            "frozen_state",
            "messages arrive, but no number of joints and IMU changes for {frozen_s} s",
            "the bridge runs, but gets no new data from the robot",
            "restart the bridge; check its link to the robot",
        ),
        FaultKind(
            "no_joystick",
            "no message on rc_command for {joystick_s} s",
            "the remote control is off or out of range, or the bridge is down",
            "charge it, come closer",
        ),
        FaultKind(
            "state_not_finite",
            "NaN or infinity in joints, IMU or sticks",
            "a broken sensor or bridge",
            "do not run; look at the log with symdyn analyze",
        ),
        FaultKind(
            "quaternion",
            "length of the quaternion differs from 1 by more than {quaternion_tolerance}",
            "the bridge has no data from the robot yet (length 0), or sends another order",
            "wait; check the bridge",
        ),
        FaultKind(
            "tilt",
            "trunk tilted by more than {tilt} rad",
            "the robot falls",
            "put it down flat, then stand up again",
        ),
        FaultKind(
            "joint_position",
            "a joint further than {position_margin} rad beyond its range (URDF)",
            "wrong joint order or zero, a loose encoder, or a hard landing",
            "check the order with the joints moved by hand in Passive",
        ),
        FaultKind(
            "joint_velocity",
            "a joint faster than {velocity_factor} times its limit (URDF) for {velocity_s} s",
            "wrong order or units, an encoder that jumps, or a fall",
            "look at the log",
        ),
        FaultKind(
            "joint_torque",
            "a joint reports more than {torque_factor} times its limit (URDF) for {torque_s} s",
            "a blocked joint, or a wrong unit",
            "look at the log; turn the joint by hand with motors off",
        ),
        FaultKind(
            "joint_order",
            "a joint moved by {wiggle} rad at stand follows by less than {wiggle_answer} of it, or another one moves",
            "joints are permuted, a sign is flipped, or a motor does not answer",
            "the message names the joint; check order and signs of the bridge",
        ),
        FaultKind(
            "leg_order",
            "while the knees are moved at stand, another order of the legs explains the tilt of the trunk better,"
            " and at least {tilt_explained} of it",
            "legs are exchanged in both state and commands, or the IMU has other axes or an inverse quaternion",
            "the message names the legs; move them and tilt the trunk by hand in Passive, check the bridge",
        ),
        FaultKind(
            "not_standing",
            "at the end of Stand a joint is off by more than {stand_error} rad",
            "the robot is blocked, carried or too heavy",
            "clear its legs, then stand up again",
        ),
        FaultKind(
            "policy_failed",
            "the policy raises an error, or gives actions that are not finite",
            "a damaged file or memory",
            "check the file with symdyn evaluate; copy it again",
        ),
        FaultKind(
            "overrun",
            "{overruns} ticks in a row begin more than one tick late",
            "the computer is too slow or busy",
            "close other programs; see --realtime",
        ),
        FaultKind(
            "second_deployer",
            "targets of another sender on the channel",
            "two deployers command one robot",
            "end the other one",
        ),
        FaultKind(
            "second_robot",
            "more than {rate_factor} times {message_rate:g} messages/s of joints or IMU, as the median over 0.2 s",
            "two robots, or a robot and a simulated one, publish on the same URL",
            "end one of them, or give each its own --url; a faster bridge: --safety.message-rate",
        ),
        FaultKind(
            "watchdog",
            "the watchdog has taken over, or has died",
            "the deployer hung for a while, or the watchdog was killed",
            "restart the deployer",
        ),
        FaultKind(
            "internal_error",
            "an exception inside the controller",
            "a defect of symdyn",
            "report it with the traceback on the terminal",
        ),
    )
}
"""By name."""


@dataclass(frozen=True)
class Fault:
    """One that has struck.

    Attributes:
        name: of :data:`FAULTS`.
        detail: what exactly, for people: numbers and joints.
    """

    name: str
    detail: str = ""

    def __post_init__(self) -> None:
        assert self.name in FAULTS

    def __str__(self) -> str:
        return f"{self.name}: {self.detail}" if self.detail else self.name


def table_rows(limits: Mapping[str, object]) -> list[list[str]]:
    """The table for people: name, when it strikes, what it means, what to do. ``limits``: SafetyConfig's fields."""
    return [[f"`{k.name}`", k.limit.format(**limits), k.means, k.help] for k in FAULTS.values()]
