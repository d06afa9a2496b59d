"""Left-right mirror augmentation for rsl_rl: half of every mini-batch is learned from as its mirror image under g_s.

The maps come from symdyn.observation and symdyn.symmetry; nothing about order or signs stands here. rsl_rl's own augmentation
doubles the mini-batch instead; a random half costs nothing, and over the epochs of an update most samples are seen both ways.
"""

from __future__ import annotations

import torch
from rsl_rl.extensions import Symmetry
from rsl_rl.models import MLPModel
from rsl_rl.storage import RolloutStorage
from tensordict import TensorDict

from rl.privileged import PRIVILEGED
from symdyn.observation import OBSERVATION
from symdyn.symmetry import G_S

_LAYOUTS = {"policy": OBSERVATION, "privileged": PRIVILEGED}


def mirror_actions(actions: torch.Tensor) -> torch.Tensor:
    """The mirror image of actions (or of their means), (..., 12)."""
    return _apply(actions, torch.tensor(G_S.joint_index), torch.as_tensor(G_S.joint_signs))


def mirror_action_std(std: torch.Tensor) -> torch.Tensor:
    """The mirror image of standard deviations of actions, (..., 12): permuted, not negated."""
    return std[..., torch.tensor(G_S.joint_index, device=std.device)]


def mirror_observations(obs: TensorDict) -> TensorDict:
    """The mirror image of every observation group, (n,)."""
    mirrored = {}
    for name, value in obs.items():
        index, sign = _LAYOUTS[name].mirror(G_S)
        mirrored[name] = _apply(value, torch.as_tensor(index), torch.as_tensor(sign))
    return TensorDict(mirrored, batch_size=obs.batch_size)


class RandomMirror(Symmetry):
    """rsl_rl's symmetry extension with the mirror image of a random half of each mini-batch in place of that half.

    A sample and its mirror image have the same value, advantage and probability under an equivariant policy; the means and
    standard deviations of the policy that acted are mirrored along, so that the KL divergence compares like with like.
    """

    def __init__(self) -> None:
        super().__init__(env=None, data_augmentation_func=mirror_observations, use_data_augmentation=True)  # pyright: ignore[reportArgumentType]

    def augment_batch(self, batch: RolloutStorage.Batch, original_batch_size: int) -> None:
        """Mirror a random half of the mini-batch in place."""
        assert batch.observations is not None and batch.actions is not None
        assert batch.old_distribution_params is not None
        chosen = torch.rand(original_batch_size, device=batch.actions.device) < 0.5
        obs = mirror_observations(batch.observations)
        batch.observations = TensorDict(
            {k: torch.where(chosen[:, None], obs[k], v) for k, v in batch.observations.items()},
            batch_size=batch.observations.batch_size,
        )
        batch.actions = torch.where(chosen[:, None], mirror_actions(batch.actions), batch.actions)
        mean, std = batch.old_distribution_params
        batch.old_distribution_params = (
            torch.where(chosen[:, None], mirror_actions(mean), mean),
            torch.where(chosen[:, None], mirror_action_std(std), std),
        )

    def compute_loss(self, actor: MLPModel, batch: RolloutStorage.Batch, original_batch_size: int) -> torch.Tensor:
        """No mirror loss is used; rsl_rl would run another forward pass only to log it."""
        return torch.zeros(())


def _apply(values: torch.Tensor, index: torch.Tensor, sign: torch.Tensor) -> torch.Tensor:
    return values[..., index.to(values.device)] * sign.to(values.device, values.dtype)
