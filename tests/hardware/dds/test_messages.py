"""From LowState to what the deployer reads, and from targets to LowCmd."""

from __future__ import annotations

import numpy as np
import pytest

from hardware.dds.messages import (
    LOW_CMD_CODEC,
    LOW_STATE_CODEC,
    MOTOR_ON,
    damping,
    damps,
    imu_message,
    joints_message,
    low_cmd,
    low_state,
    targets_message,
)
from hardware.wire.messages import pd_tau_targets_lcmt

TARGETS = ("q_des", "qd_des", "tau_ff", "kp", "kd")


def drawn_targets() -> pd_tau_targets_lcmt:
    rng, message = np.random.default_rng(1), pd_tau_targets_lcmt()
    for name in TARGETS:
        setattr(message, name, np.float32(rng.uniform(0.1, 50.0, 12)).astype(float).tolist())
    return message


def state():
    rng, record = np.random.default_rng(2), LOW_STATE_CODEC.new()
    for name in ("q", "dq", "tau_est"):
        record["motor_state"][name] = rng.normal(size=20)
    for name in ("quaternion", "gyroscope", "accelerometer", "rpy"):
        record["imu_state"][name] = rng.normal(size=record["imu_state"][name].shape)
    record["foot_force"] = [-3, 20, 40, 300]
    return record


def test_every_number_of_the_state_is_where_the_deployer_looks_for_it():
    record = state()
    joints, imu = joints_message(record), imu_message(record)
    for there, here in (("q", "q"), ("dq", "qd"), ("tau_est", "tau_est")):
        assert getattr(joints, here) == record["motor_state"][there][:12].tolist()
    for there, here in (("quaternion", "quat"), ("gyroscope", "omegaBody"), ("accelerometer", "aBody"), ("rpy", "rpy")):
        assert getattr(imu, here) == record["imu_state"][there].tolist()
    assert imu.contact_estimate == [-3.0, 20.0, 40.0, 300.0]
    joints.encode()
    imu.encode()


def test_nan_is_passed_on_for_the_deployer_to_see():
    record = state()
    record["motor_state"]["q"][5] = np.nan
    assert np.isnan(joints_message(record).q[5])


def test_the_simulated_robots_state_comes_back():
    record = state()
    joints, imu = joints_message(record), imu_message(record)
    remote = bytes(range(40))
    its = LOW_STATE_CODEC.decode(LOW_STATE_CODEC.encode(low_state(joints, imu, remote, 1234)))
    assert LOW_STATE_CODEC.crc_fits(its)
    assert joints_message(its).encode() == joints.encode()
    assert imu_message(its).encode() == imu.encode()
    assert its["wireless_remote"].tobytes() == remote and its["tick"] == 1234


def test_targets_come_back_from_a_command():
    message = drawn_targets()
    command = LOW_CMD_CODEC.decode(LOW_CMD_CODEC.encode(low_cmd(message)))
    assert [getattr(targets_message(command), name) for name in TARGETS] == [getattr(message, name) for name in TARGETS]
    assert command["head"].tolist() == [0xFE, 0xEF] and command["level_flag"] == 0xFF
    assert not command["motor_cmd"]["kp"][12:].any() and not command["motor_cmd"]["kd"][12:].any()


def test_a_motor_that_is_off_has_no_torque():
    command = low_cmd(drawn_targets())
    command["motor_cmd"]["mode"][4] = 0
    message = targets_message(command)
    assert [message.kp[4], message.kd[4], message.tau_ff[4]] == [0.0, 0.0, 0.0]
    assert min(message.kp[:4] + message.kp[5:]) > 0.0
    assert MOTOR_ON == 1


@pytest.mark.parametrize("kd", [3.0, 8.0])
def test_damping_is_a_torque_against_the_speed_and_nothing_else(kd):
    command = damping(kd)
    message = targets_message(command)
    q, qd = np.linspace(-2.0, 2.0, 12), np.linspace(-9.0, 9.0, 12)
    pull = np.multiply(message.kp, np.subtract(message.q_des, q))
    torque = pull + np.multiply(message.kd, np.subtract(message.qd_des, qd)) + message.tau_ff
    assert torque == pytest.approx(-kd * qd)
    assert damps(command) and not damps(low_cmd(drawn_targets()))
