"""What is derived from the state of a robot alone."""

from __future__ import annotations

import numpy as np
import torch
from scipy.spatial.transform import Rotation

from rl.physics.protocol import RobotState, heading_velocity


def test_heading_velocity_is_that_of_a_frame_that_turns_with_the_yaw_alone() -> None:
    rng, n = np.random.default_rng(0), 200
    attitude = Rotation.from_euler("ZYX", rng.uniform([-3, -0.9, -0.7], [3, 0.9, 0.7], (n, 3)))
    velocity_w, angular_b = rng.normal(size=(2, n, 3))
    zeros = torch.zeros(n, 12)
    state = RobotState(
        base_pos_w=torch.zeros(n, 3),
        base_quat_w=torch.from_numpy(attitude.as_quat(scalar_first=True)),
        base_lin_vel_w=torch.from_numpy(velocity_w),
        base_ang_vel_b=torch.from_numpy(angular_b),
        joint_pos=zeros, joint_vel=zeros, joint_torque=zeros,
        foot_force_w=zeros.view(n, 4, 3), foot_pos_w=zeros.view(n, 4, 3), foot_vel_w=zeros.view(n, 4, 3),
    )  # fmt: skip
    heading = Rotation.from_euler("Z", attitude.as_euler("ZYX")[:, :1])
    expected = np.column_stack([heading.inv().apply(velocity_w)[:, :2], attitude.apply(angular_b)[:, 2]])
    np.testing.assert_allclose(heading_velocity(state).numpy(), expected, atol=1e-12)
