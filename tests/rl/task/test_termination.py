"""When a robot has fallen."""

from __future__ import annotations

import math

import pytest
import torch
from scipy.spatial.transform import Rotation

from rl.physics.protocol import RobotState
from rl.task.settings import TerminationConfig
from rl.task.termination import fallen


@pytest.mark.parametrize(
    ("height", "attitude", "expected"),
    [
        (0.181, (0.0, 0.0, 0.0), False),
        (0.179, (0.0, 0.0, 0.0), True),
        (0.4, (2.0, 0.0, 0.79), False),
        (0.4, (2.0, 0.0, -0.81), True),
        (0.4, (-1.0, 0.99, 0.0), False),
        (0.4, (-1.0, 1.01, 0.0), True),
        (0.4, (-1.0, -1.01, 0.0), True),
        (0.4, (0.0, 0.0, math.pi), True),
        (0.4, (0.0, math.pi, 0.0), True),
    ],
)
def test_fallen(height: float, attitude: tuple[float, float, float], expected: bool) -> None:
    # yaw, pitch, roll
    quat = Rotation.from_euler("ZYX", attitude).as_quat(scalar_first=True)
    zeros, legs = torch.zeros(1, 12), torch.zeros(1, 4, 3)
    state = RobotState(
        torch.tensor([[0.0, 0.0, height]]), torch.from_numpy(quat)[None].float(), torch.zeros(1, 3), torch.zeros(1, 3),
        zeros, zeros, zeros, legs, legs, legs,
    )  # fmt: skip
    assert fallen(state, TerminationConfig()).tolist() == [expected]
