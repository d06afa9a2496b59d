"""A late robot does what a punctual one does when it is told a step later."""

from __future__ import annotations

import numpy as np
import torch

from rl.batch_physics import BatchPhysics
from rl.late_physics import LatePhysics
from rl.model import build_model
from rl.physics import Pose
from symdyn.robot import GO2

N = 3


def _pose() -> Pose:
    quat = np.tile([1.0, 0.0, 0.0, 0.0], (N, 1))
    return Pose(np.tile([0.0, 0.0, 0.4], (N, 1)), quat, np.zeros((N, 3)), np.tile(GO2.default_joint_pos, (N, 1)))


def _targets(steps: int) -> list[torch.Tensor]:
    generator = torch.Generator().manual_seed(0)
    default = torch.from_numpy(GO2.default_joint_pos).float()
    return [default + 0.2 * torch.randn(N, 12, generator=generator) for _ in range(steps)]


def test_targets_take_effect_one_step_later():
    late = LatePhysics(build_model(GO2), GO2, N, 1)
    punctual = BatchPhysics(build_model(GO2), GO2, N, 1)
    for physics in (late, punctual):
        physics.reset(np.arange(N), _pose())
    given = _targets(6)
    shifted = [torch.from_numpy(_pose().joint_pos).float(), *given[:-1]]
    for now, then in zip(given, shifted, strict=True):
        late.step(now)
        punctual.step(then)
        assert torch.equal(late.read().joint_pos, punctual.read().joint_pos)
    assert not torch.equal(given[-1], shifted[-1])


def test_it_goes_on_from_its_state_as_if_nothing_had_happened():
    first, second = (LatePhysics(build_model(GO2), GO2, N, 1) for _ in range(2))
    first.reset(np.arange(N), _pose())
    given = _targets(5)
    for targets in given[:3]:
        first.step(targets)
    second.load_state_dict(first.state_dict())
    for targets in given[3:]:
        first.step(targets)
        second.step(targets)
    assert torch.equal(first.read().joint_pos, second.read().joint_pos)
