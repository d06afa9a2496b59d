"""The little that the environment asks of a physics engine."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any, Protocol

import numpy as np
import torch
from numpy.typing import NDArray

from rl.physics.dynamics import Dynamics
from symdyn.robot.frames import projected_gravity, to_heading


@dataclass(frozen=True)
class RobotState:
    """State of N robots, fresh tensors on the learner's device: nothing here is a view of the engine's memory.

    Attributes:
        base_pos_w: (N, 3) trunk origin, m.
        base_quat_w: (N, 4) w, x, y, z.
        base_lin_vel_w: (N, 3) m/s.
        base_ang_vel_b: (N, 3) rad/s.
        joint_pos: (N, 12) rad, order of symdyn.robot.legs.JOINTS (as all below).
        joint_vel: (N, 12) rad/s.
        joint_torque: (N, 12) N m, of the last physics step.
        foot_force_w: (N, 4, 3) contact force on each foot, N, order of symdyn.robot.legs.LEGS.
        foot_pos_w: (N, 4, 3) m, centre of the foot's sphere.
        foot_vel_w: (N, 4, 3) m/s.
    """

    base_pos_w: torch.Tensor
    base_quat_w: torch.Tensor
    base_lin_vel_w: torch.Tensor
    base_ang_vel_b: torch.Tensor
    joint_pos: torch.Tensor
    joint_vel: torch.Tensor
    joint_torque: torch.Tensor
    foot_force_w: torch.Tensor
    foot_pos_w: torch.Tensor
    foot_vel_w: torch.Tensor

    def finite(self) -> torch.Tensor:
        """Which robots have only finite numbers, (N,) bool."""
        # a sum is finite exactly when its addends are, short of overflow, which is no state to go on from either
        total = sum(getattr(self, f.name).flatten(1).sum(dim=1) for f in fields(self))
        return torch.isfinite(torch.as_tensor(total))


@dataclass(frozen=True)
class Pose:
    """Where to put robots on reset, for n of them.

    Attributes:
        base_pos_w: (n, 3) m.
        base_quat_w: (n, 4).
        base_vel_w: (n, 3) m/s.
        joint_pos: (n, 12) rad.
    """

    base_pos_w: NDArray[np.float64]
    base_quat_w: NDArray[np.float64]
    base_vel_w: NDArray[np.float64]
    joint_pos: NDArray[np.float64]


class Physics(Protocol):
    """N robots that are stepped together. The CPU's is :class:`rl.physics.batch.BatchPhysics`."""

    num_envs: int
    foot_radius: float
    dynamics: Dynamics

    def reset(self, ids: NDArray[np.int64], pose: Pose) -> None:
        """Put some robots at rest (but for their base velocity) in a pose. ``ids`` are sorted."""
        ...

    def step(self, joint_targets: torch.Tensor) -> None:
        """Advance one control step with these joint targets, (N, 12) rad. A robot that diverges reads as non-finite."""
        ...

    def read(self) -> RobotState:
        """The state after the last reset or step (after :meth:`load_state_dict` without forces and torques)."""
        ...

    def push(self, ids: NDArray[np.int64], velocity_w: NDArray[np.float64]) -> None:
        """Add (n, 3) m/s to the base velocity of some robots."""
        ...

    def set_dynamics(self, dynamics: Dynamics) -> None:
        """Make each robot and its ground other than the model."""
        ...

    def ground(self, position_w: torch.Tensor) -> torch.Tensor:
        """Height of the ground below positions in the world, (N, ..., 3) -> (N, ...), m."""
        ...

    def state_dict(self) -> dict[str, Any]:
        """All that :meth:`load_state_dict` needs to go on bit by bit as if nothing had happened."""
        ...

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Go on from :meth:`state_dict`."""
        ...

    def dump(self, env: int) -> dict[str, Any]:
        """One robot's full state as numbers, to replay what went wrong."""
        ...


def heading_velocity(state: RobotState) -> torch.Tensor:
    """Forward and lateral velocity (m/s) and yaw rate (rad/s) in the heading frame, (N, 3)."""
    planar = to_heading(state.base_quat_w, state.base_lin_vel_w)[:, :2]
    gravity = projected_gravity(state.base_quat_w)
    # the vertical component of the angular velocity: minus its projection on gravity's direction
    yaw_rate = -(gravity * state.base_ang_vel_b).sum(dim=1, keepdim=True)
    return torch.cat([planar, yaw_rate], dim=1)
