"""A robot whose commands arrive late."""

from __future__ import annotations

import torch
from numpy.typing import NDArray

from rl.batch_physics import BatchPhysics
from rl.physics import Pose


class LatePhysics(BatchPhysics):
    """:class:`rl.batch_physics.BatchPhysics` whose joint targets take effect one control step after they are given.

    In the first step after a reset the joints are held where the reset put them.
    """

    _late: torch.Tensor | None = None

    def reset(self, ids: NDArray, pose: Pose) -> None:
        super().reset(ids, pose)
        if self._late is None:
            self._late = torch.zeros(self.num_envs, pose.joint_pos.shape[1])
        self._late[torch.from_numpy(ids)] = torch.from_numpy(pose.joint_pos).to(self._late.dtype)

    def step(self, joint_targets: torch.Tensor) -> None:
        due, self._late = self._late, joint_targets.clone()
        super().step(joint_targets if due is None else due)

    def state_dict(self) -> dict[str, torch.Tensor]:
        late = {} if self._late is None else {"late": self._late.clone()}
        return super().state_dict() | late

    def load_state_dict(self, state: dict[str, torch.Tensor]) -> None:
        super().load_state_dict(state)
        self._late = state["late"].clone() if "late" in state else None
