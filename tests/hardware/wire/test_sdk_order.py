"""The wire's order of joints and legs, against the SDK's own list written out by hand."""

from __future__ import annotations

import numpy as np
import pytest

from hardware.wire import sdk_order
from hardware.wire.messages import leg_control_data_lcmt, state_estimator_lcmt
from hardware.wire.readings import Imu, Joints, Targets
from hardware.wire.sdk_order import unitree_joint_name
from symdyn.robot.legs import JOINTS, LEGS

# unitree_sdk2, example/go2: FR_0 = 0, FR_1, FR_2, FL_0, ..., RL_2 = 11
MOTORS = [
    "FR_hip", "FR_thigh", "FR_calf", "FL_hip", "FL_thigh", "FL_calf",
    "RR_hip", "RR_thigh", "RR_calf", "RL_hip", "RL_thigh", "RL_calf",
]  # fmt: skip
# where symdyn's joints (LH, LF, RF, RH) are among them
OURS = ["RL", "FL", "FR", "RR"]


def test_the_wire_names_its_motors_as_the_sdk_numbers_them():
    assert [name.removesuffix("_joint") for name in sdk_order.SDK_JOINTS] == MOTORS
    assert list(sdk_order.SDK_LEGS) == ["FR", "FL", "RR", "RL"]


def test_every_joint_of_a_message_lands_where_its_name_is():
    message = leg_control_data_lcmt()
    message.q = [float(i) for i in range(12)]
    message.qd = [10.0 * i for i in range(12)]
    message.tau_est = [100.0 * i for i in range(12)]
    joints = Joints.of(message)
    for ours, name in enumerate(JOINTS):
        theirs = MOTORS.index(unitree_joint_name(name).removesuffix("_joint"))
        assert (joints.pos[ours], joints.vel[ours], joints.torque[ours]) == (theirs, 10.0 * theirs, 100.0 * theirs)


def test_every_foot_lands_where_its_leg_is():
    message = state_estimator_lcmt()
    message.contact_estimate = [1.0, 2.0, 3.0, 4.0]  # FR, FL, RR, RL
    by_leg = dict(zip(LEGS, Imu.of(message).foot_force, strict=True))
    assert by_leg == {"RF": 1.0, "LF": 2.0, "RH": 3.0, "LH": 4.0}


def test_targets_go_out_where_state_comes_from():
    targets = Targets(pos=np.arange(12.0), kp=20.0 + np.arange(12.0), kd=1.0 + np.arange(12.0))
    message = targets.message(number=7, sender=3)
    for theirs, motor in enumerate(MOTORS):
        leg, joint = motor.split("_")
        ours = 3 * OURS.index(leg) + ["hip", "thigh", "calf"].index(joint)
        assert message.q_des[theirs] == ours
        assert message.kp[theirs] == 20.0 + ours
        assert message.kd[theirs] == 1.0 + ours
    assert (message.id, message.robot_id) == (7, 3)


@pytest.mark.parametrize(("there", "back"), [("JOINTS_TO_SDK", "JOINTS_FROM_SDK"), ("LEGS_TO_SDK", "LEGS_FROM_SDK")])
def test_there_and_back_is_the_identity_and_there_is_not(there, back):
    to_sdk, from_sdk = np.array(getattr(sdk_order, there)), np.array(getattr(sdk_order, back))
    identity = np.arange(len(to_sdk))
    assert np.array_equal(identity[to_sdk][from_sdk], identity)
    assert not np.array_equal(to_sdk, identity)
