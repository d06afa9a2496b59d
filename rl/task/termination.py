"""When a robot counts as fallen: in training, evaluation and every experiment."""

from __future__ import annotations

import math
from dataclasses import dataclass

import torch

from rl.physics.protocol import RobotState
from symdyn.errors import InvalidValue
from symdyn.robot.frames import projected_gravity


@dataclass(frozen=True)
class TerminationConfig:
    """When an episode ends before its time.

    Attributes:
        height: trunk origin lower than this above the ground, m.
        roll: trunk rolled further than this, rad.
        pitch: trunk pitched further than this, rad.
    """

    height: float = 0.18
    roll: float = 0.8
    pitch: float = 1.0

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not 0.0 < value < math.inf:
                raise InvalidValue(f"termination.{name}", value, "a number > 0")


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
