"""The motors' torque range and the delay of commands, against their definitions and against the simulated robot."""

from __future__ import annotations

from collections import deque
from dataclasses import replace

import mujoco
import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from hardware.estimation.kinematics import JointLimits
from rl.physics.batch import BatchPhysics
from rl.physics.delay_line import DelayLine
from rl.physics.dynamics import Dynamics
from symdyn.robot.descriptions import velocity_limits
from symdyn.robot.legs import JOINTS
from symdyn.robot.torque_speed import torque_range
from tests.rl.physics.batches import fresh_model, make, poses, targets
from tests.robots import GO2

PEAK, FREE = np.array([23.7]), np.array([30.0])


def test_torque_falls_linearly_from_the_knee_to_the_no_load_speed() -> None:
    speeds = np.array([[-31.0], [-30.0], [-22.5], [-15.0], [0.0], [15.0], [22.5], [30.0], [31.0]])
    low, high = torque_range(speeds, PEAK, FREE, knee=0.5)
    along = PEAK[0] * np.array([0.0, 0.0, 0.5, 1.0, 1.0, 1.0, 0.5, 0.0, 0.0])
    moving_up, moving_down = speeds[:, 0] > 0.0, speeds[:, 0] < 0.0
    np.testing.assert_allclose(high[:, 0], np.where(moving_up, along, PEAK[0]))
    np.testing.assert_allclose(low[:, 0], np.where(moving_down, -along, -PEAK[0]))


@given(st.floats(-60.0, 60.0), st.floats(0.0, 0.99))
def test_power_is_bounded_and_braking_is_not_weakened(speed: float, knee: float) -> None:
    (low,), (high,) = torque_range(np.array([speed]), PEAK, FREE, knee)
    assert low <= 0.0 <= high
    assert max(low * speed, high * speed) <= PEAK[0] * FREE[0] + 1e-9
    assert min(low * speed, high * speed) == pytest.approx(-PEAK[0] * abs(speed))


@given(st.integers(1, 5), st.lists(st.integers(0, 12), min_size=1, max_size=4), st.integers(0, 2**31))
def test_a_command_acts_so_many_physics_steps_after_it_was_given(substeps: int, delays: list[int], seed: int) -> None:
    n = len(delays)
    line, rng = DelayLine(n, 2, substeps), np.random.default_rng(seed)
    line.set_delay(np.array(delays))
    line.fill(np.arange(n), np.zeros((n, 2)))
    queues = [deque([np.zeros(2)] * delay) for delay in delays]  # one entry a physics step
    for _ in range(8):
        commands = rng.normal(size=(n, 2))
        line.push(commands)
        for substep in range(substeps):
            for k, queue in enumerate(queues):
                queue.append(commands[k])
                np.testing.assert_array_equal(line.at(substep)[k], queue.popleft())


def test_no_motor_of_a_running_robot_exceeds_its_range() -> None:
    knee, rng = 0.5, np.random.default_rng(0)
    physics = BatchPhysics(fresh_model(), replace(GO2, torque_knee=knee), 6, 1)
    physics.reset(np.arange(6), poses(6))
    peak, free = physics.model.actuator_forcerange[:, 1], velocity_limits(GO2)
    columns = [physics.model.actuator(joint).id for joint in JOINTS]
    joints = [physics.model.joint(name).dofadr[0] for name in GO2.joint_names]
    limited = 0
    for _ in range(40):
        physics.set_targets(targets(rng, 6).numpy() + rng.uniform(-1.0, 1.0, (6, 12)))
        for _ in range(physics.substeps):
            speed = physics.batch.qvel[:, joints].copy()
            physics.substep()
            torque = physics.batch.actuator_force[:, columns]
            share = np.clip((1.0 - np.abs(speed) / free) / (1.0 - knee), 0.0, 1.0)
            bound = np.where(torque * speed > 0.0, share * peak[columns], peak[columns])
            assert (np.abs(torque) <= bound + 1e-9).all()
            limited += int((np.abs(torque) >= bound - 1e-9)[share < 1.0].sum())
    assert limited > 0, "some motor was at its limit"


def test_velocity_limits_are_those_of_the_description() -> None:
    # go2_description: hip and thigh 30.1 rad/s, calf 15.7 rad/s (45.43 N m and 23.7 N m in other revisions)
    limits = dict(zip(JOINTS, velocity_limits(GO2), strict=True))
    assert {round(float(limits[joint]), 2) for joint in JOINTS if joint.endswith("calf")} == {15.70}
    assert {round(float(limits[joint]), 2) for joint in JOINTS if not joint.endswith("calf")} == {30.10}


def test_strength_gains_and_offsets_give_the_torque_of_the_motor_law() -> None:
    # tau = strength * (kp (target - encoder) - kd speed), where the encoder shows the angle and its offset
    n, rng = 4, np.random.default_rng(1)
    physics = make(n)
    dynamics = Dynamics.nominal(
        n,
        strength=np.repeat(rng.uniform(0.8, 1.1, (n, 1)), 12, axis=1),
        kp=rng.uniform(0.8, 1.2, (n, 12)),
        kd=rng.uniform(0.8, 1.2, (n, 12)),
        joint_offset=rng.uniform(-0.02, 0.02, (n, 12)),
    )
    physics.set_dynamics(dynamics)
    pose = poses(n, height=0.6)  # in the air
    physics.reset(np.arange(n), pose)
    wanted = torch.as_tensor(pose.joint_pos) + torch.from_numpy(rng.uniform(-0.1, 0.1, (n, 12)))
    physics.set_targets(wanted.numpy())
    columns = [physics.model.actuator(joint).id for joint in JOINTS]
    q = physics.read().joint_pos.double().numpy()
    for i in range(n):
        model, data = physics.batch.get_model(i), physics.batch.get_data(i)
        data.ctrl[columns] = wanted[i].numpy() - dynamics.joint_offset[i]
        mujoco.mj_forward(model, data)
        law = dynamics.strength[i] * GO2.kp * dynamics.kp[i] * (wanted[i].numpy() - (q[i] + dynamics.joint_offset[i]))
        np.testing.assert_allclose(data.actuator_force[columns], law, atol=1e-4)
        data.qvel[[model.joint(name).dofadr[0] for name in GO2.joint_names]] = 1.0
        mujoco.mj_forward(model, data)
        damped = law - dynamics.strength[i] * GO2.kd * dynamics.kd[i]
        np.testing.assert_allclose(data.actuator_force[columns], damped, atol=1e-4)


def test_velocity_limits_are_those_that_the_deployer_keeps() -> None:
    np.testing.assert_array_equal(velocity_limits(GO2), JointLimits.of(GO2).velocity)
