"""Worlds other than that of training, and a robot without a bridge before it."""

from __future__ import annotations

import numpy as np
import pytest

from hardware.robot_sim.sensors import NO_NOISE
from hardware.robot_sim.simulated_robot import PERIOD
from hardware.robot_sim.world import UNITREE, World
from hardware.wire.readings import Joints, Targets
from tests.hardware.robot_sim.simulated import go2
from tests.robots import GO2

ONES = np.ones(12)


def test_an_explicit_motor_holds_the_torque_of_the_state_in_which_the_period_began():
    robot = go2(start="standing", noise=NO_NOISE, world=World(explicit=True))
    targets = Targets(GO2.default_joint_pos + 0.1, 30.0 * ONES, 1.0 * ONES)
    robot.command(targets.message(1, 1))
    for _ in range(20):
        before = robot.measured_joints
        robot.step()
        law = targets.kp * (targets.pos - before.pos) - targets.kd * before.vel
        limited = np.clip(law, -robot.torque_limit, robot.torque_limit)
        assert robot.measured_joints.torque == pytest.approx(limited, abs=1e-9)


def test_a_torque_below_the_joints_friction_moves_nothing():
    moved = []
    for friction in (0.0, 6.0):
        robot = go2(start="hung", noise=NO_NOISE, world=World(joint_friction=friction))
        robot.command(Targets(GO2.default_joint_pos, 0.0 * ONES, 0.5 * ONES).message(1, 1))
        for _ in range(round(3.0 / PERIOD)):
            robot.step()
        before = robot.measured_joints.pos
        message = Targets(before, 0.0 * ONES, 0.0 * ONES).message(1, 1)
        message.tau_ff = [1.2 if i % 3 == 0 else 0.0 for i in range(12)]
        robot.command(message)
        for _ in range(round(0.2 / PERIOD)):
            robot.step()
        moved.append(np.abs(robot.measured_joints.pos - before).max())
    assert moved[1] < 0.02 < 0.1 < moved[0]


def test_feet_without_sensors_show_nothing_and_the_truth_is_still_true():
    robot = go2(start="standing", world=UNITREE)
    for _ in range(100):
        robot.step()
    assert not any(robot.imu().contact_estimate)
    assert all(robot.truth().contact_estimate)


def test_without_a_bridge_the_motors_are_limp_before_the_first_targets_and_no_tilt_stops_them():
    robot = go2(start="lying", noise=NO_NOISE, bridge=False, wakes_at=5.0)
    assert np.linalg.norm(robot.imu().quat) == pytest.approx(1.0, abs=1e-6), "it speaks from the start"
    for _ in range(50):
        robot.step()
        assert not Joints.of(robot.joints()).torque.any()
    robot = go2(start="standing", noise=NO_NOISE, bridge=False)
    robot.wrench_w[3] = 80.0
    while robot.tilt < 1.0:
        robot.step()
    assert not robot.bridge_stopped
    robot.command(Targets(GO2.default_joint_pos, 0.0 * ONES, 0.0 * ONES).message(1, 1))
    robot.step()
    assert not Joints.of(robot.joints()).torque.any()
