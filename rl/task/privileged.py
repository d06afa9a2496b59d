"""What the critic sees besides the policy's observation: quantities that a simulator knows and a robot does not.

It serves learning alone and is no part of the policy's input. It has the form of symdyn.policy.observation, so that
its mirror image is derived in the same way.
"""

from __future__ import annotations

import numpy as np
import torch

from rl.physics.dynamics import Dynamics
from rl.physics.protocol import RobotState
from symdyn.policy.layout import Layout, Term
from symdyn.robot.frames import projected_gravity, rotate_inverse
from symdyn.robot.legs import JOINTS, LEGS

_XYZ = ("x", "y", "z")

PRIVILEGED = Layout(
    (
        Term("gravity_b", _XYZ, "1", 1.0, 0.0, "polar_b", "unit vector of gravity, without noise"),
        Term("joint_pos_rel", JOINTS, "rad", 1.0, 0.0, "joint", "joint positions minus the default pose, no noise"),
        Term("joint_vel", JOINTS, "rad/s", 0.05, 0.0, "joint", "joint velocities, without noise"),
        Term("base_lin_vel_b", _XYZ, "m/s", 1.0, 0.0, "polar_b", "trunk velocity"),
        Term("base_ang_vel_b", _XYZ, "rad/s", 0.25, 0.0, "axial_b", "trunk angular velocity"),
        Term(
            "velocity_h", ("v_x", "v_y", "yaw_rate"), "m/s, m/s, rad/s", 1.0, 0.0, "planar_velocity_b",
            "the velocities that the reward judges",
        ),
        Term("base_height", ("z",), "m", 5.0, 0.0, "invariant", "trunk height above ground minus Robot.base_height"),
        Term("foot_force", LEGS, "N", 0.01, 0.0, "leg", "magnitude of the ground reaction force"),
        Term("foot_height", LEGS, "m", 10.0, 0.0, "leg", "sole above ground"),
        Term("foot_speed", LEGS, "m/s", 0.5, 0.0, "leg", "speed of the foot"),
        Term("clock_cos", LEGS, "1", 1.0, 0.0, "leg", "cos(2 pi phi_i)"),
        Term(
            "dynamics", ("added_mass", "friction", "strength"), "kg, 1, 1", 1.0, 0.0, "invariant", "what was randomised"
        ),
        Term("delay", ("delay",), "s", 50.0, 0.0, "invariant", "from command to motor response"),
        Term("com_shift_b", _XYZ, "m", 20.0, 0.0, "polar_b", "displacement of the trunk's centre of mass"),
    )
)  # fmt: skip


def privileged_terms(
    state: RobotState,
    velocity_h: torch.Tensor,
    leg_phases: torch.Tensor,
    default_joint_pos: torch.Tensor,
    base_height: torch.Tensor,
    foot_height: torch.Tensor,
) -> dict[str, torch.Tensor]:
    """The values of :data:`PRIVILEGED`.

    Args:
        state: of N robots.
        velocity_h: (N, 3).
        leg_phases: (N, 4).
        default_joint_pos: (12,) rad.
        base_height: (N,) of the trunk above the ground minus Robot.base_height, m.
        foot_height: (N, 4) of the soles above the ground, m.

    Those of :func:`constant_terms` are to be added.
    """
    return {
        "gravity_b": projected_gravity(state.base_quat_w),
        "joint_pos_rel": state.joint_pos - default_joint_pos,
        "joint_vel": state.joint_vel,
        "base_lin_vel_b": rotate_inverse(state.base_quat_w, state.base_lin_vel_w),
        "base_ang_vel_b": state.base_ang_vel_b,
        "velocity_h": velocity_h,
        "base_height": base_height[:, None],
        "foot_force": state.foot_force_w.norm(dim=-1),
        "foot_height": foot_height,
        "foot_speed": state.foot_vel_w.norm(dim=-1),
        "clock_cos": torch.cos(2.0 * np.pi * leg_phases),
    }


def constant_terms(dynamics: Dynamics) -> dict[str, torch.Tensor]:
    """The values of :data:`PRIVILEGED` that do not change while a robot runs."""
    columns = (dynamics.added_mass, dynamics.friction, dynamics.strength.mean(axis=1))
    return {
        "dynamics": torch.from_numpy(np.column_stack(columns)).float(),
        "delay": torch.from_numpy(dynamics.delay[:, None].copy()).float(),
        "com_shift_b": torch.from_numpy(dynamics.com_shift_b.copy()).float(),
    }
