"""When a robot counts as fallen: in training, evaluation and every experiment."""

from __future__ import annotations

import torch

from rl.physics.protocol import RobotState
from rl.task.settings import TerminationConfig
from symdyn.robot.frames import projected_gravity


def fallen(state: RobotState, limits: TerminationConfig, ground: torch.Tensor | float = 0.0) -> torch.Tensor:
    """Which of N robots have fallen, (N,) bool.

    Args:
        state: of the robots.
        limits: what counts as a fall.
        ground: height of the ground under each trunk, (N,) m, or that of all.
    """
    gravity = projected_gravity(state.base_quat_w)
    roll = torch.atan2(gravity[:, 1], gravity[:, 2].neg()).abs()
    pitch = torch.asin(gravity[:, 0].clamp(-1.0, 1.0)).abs()
    return (state.base_pos_w[:, 2] - ground < limits.height) | (roll > limits.roll) | (pitch > limits.pitch)
