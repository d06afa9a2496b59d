"""LowState and LowCmd as the LCM messages that the deployer knows, and the other way round.

Both sides count motors, legs and quaternion alike (hardware.wire.sdk_order), so that nothing changes places here.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from hardware.dds.codec import Codec
from hardware.dds.types import LowCmd, LowState
from hardware.wire.messages import leg_control_data_lcmt, pd_tau_targets_lcmt, state_estimator_lcmt
from hardware.wire.sdk_order import SDK_JOINTS

LOW_STATE_CODEC, LOW_CMD_CODEC = Codec(LowState), Codec(LowCmd)

MOTOR_ON = 1
"""A motor that follows its command (unitree_sdk2's examples: PMSM mode)."""

POS_STOP, VEL_STOP = 2.146e9, 16000.0
"""Position and velocity that stand for none (unitree_sdk2, go2: PosStopF, VelStopF)."""

_HEAD = (0xFE, 0xEF)
_LOW_LEVEL = 0xFF
_JOINTS = slice(0, len(SDK_JOINTS))


def joints_message(state: Any) -> leg_control_data_lcmt:
    """Of the joints in a LowState record."""
    motors = state["motor_state"][_JOINTS]
    message = leg_control_data_lcmt()
    message.q, message.qd, message.tau_est = (motors[name].tolist() for name in ("q", "dq", "tau_est"))
    return message


def imu_message(state: Any) -> state_estimator_lcmt:
    """Of the trunk and the feet in a LowState record."""
    imu = state["imu_state"]
    message = state_estimator_lcmt()
    message.quat, message.rpy = imu["quaternion"].tolist(), imu["rpy"].tolist()
    message.omegaBody, message.aBody = imu["gyroscope"].tolist(), imu["accelerometer"].tolist()
    message.contact_estimate = state["foot_force"].astype(float).tolist()
    return message


def low_state(joints: leg_control_data_lcmt, imu: state_estimator_lcmt, remote: bytes, tick: int) -> Any:
    """A LowState record. The feet's numbers are whole, as the robot's are.

    Args:
        joints: positions, velocities and torques.
        imu: of the trunk and the feet.
        remote: 40 bytes.
        tick: ms since the robot was switched on.
    """
    state = LOW_STATE_CODEC.new()
    state["head"], state["level_flag"] = _HEAD, _LOW_LEVEL
    motors = state["motor_state"][_JOINTS]
    motors["mode"] = MOTOR_ON
    motors["q"], motors["dq"], motors["tau_est"] = joints.q, joints.qd, joints.tau_est
    its = state["imu_state"]
    its["quaternion"], its["rpy"], its["gyroscope"], its["accelerometer"] = imu.quat, imu.rpy, imu.omegaBody, imu.aBody
    state["foot_force"] = np.rint(imu.contact_estimate)
    state["wireless_remote"] = np.frombuffer(remote, np.uint8)
    state["tick"] = tick
    return state


def low_cmd(message: pd_tau_targets_lcmt) -> Any:
    """A LowCmd record of targets."""
    command = _idle()
    motors = command["motor_cmd"][_JOINTS]
    motors["q"], motors["dq"], motors["tau"] = message.q_des, message.qd_des, message.tau_ff
    motors["kp"], motors["kd"] = message.kp, message.kd
    return command


def damping(kd: float) -> Any:
    """A LowCmd record that damps all joints. ``kd``: N m s/rad."""
    command = _idle()
    motors = command["motor_cmd"][_JOINTS]
    motors["q"], motors["dq"], motors["kd"] = 0.0, 0.0, kd
    return command


def damps(command: Any) -> bool:
    """Whether a LowCmd record lets no joint hold a position or push."""
    motors = command["motor_cmd"][_JOINTS]
    return not motors["kp"].any() and not motors["tau"].any()


def targets_message(command: Any) -> pd_tau_targets_lcmt:
    """Of a LowCmd record; a motor that is not switched on has no gains."""
    motors = command["motor_cmd"][_JOINTS]
    on = motors["mode"] == MOTOR_ON
    message = pd_tau_targets_lcmt()
    message.q_des, message.qd_des = motors["q"].astype(float).tolist(), motors["dq"].astype(float).tolist()
    message.tau_ff, message.kp, message.kd = (
        np.where(on, motors[name], 0.0).astype(float).tolist() for name in ("tau", "kp", "kd")
    )
    return message


def _idle() -> Any:
    command = LOW_CMD_CODEC.new()
    command["head"], command["level_flag"] = _HEAD, _LOW_LEVEL
    command["motor_cmd"]["mode"] = MOTOR_ON
    command["motor_cmd"]["q"], command["motor_cmd"]["dq"] = POS_STOP, VEL_STOP
    return command
