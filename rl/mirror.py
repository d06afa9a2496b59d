"""Left-right mirror augmentation for rsl_rl: half of every mini-batch is learned from as its mirror image under g_s.

The maps come from symdyn.observation and symdyn.symmetry; nothing about order or signs stands here. rsl_rl's own augmentation
doubles the mini-batch instead; a random half costs nothing, and over the epochs of an update most samples are seen both ways.
"""

from __future__ import annotations

import copy
from typing import Any

import torch
from rsl_rl.algorithms import PPO
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


def mirror_observations(obs: TensorDict) -> TensorDict:
    """The mirror image of every observation group, (n,)."""
    mirrored = {}
    for name, value in obs.items():
        index, sign = _LAYOUTS[name].mirror(G_S)
        assert isinstance(value, torch.Tensor)
        mirrored[name] = _apply(value, torch.as_tensor(index), torch.as_tensor(sign))
    return TensorDict(mirrored, batch_size=obs.batch_size)


class RandomMirror(Symmetry):
    """rsl_rl's symmetry extension with a random half of each mini-batch replaced by its mirror image.

    A mirrored sample keeps its return and advantage. What the policy that acted thinks of it (log probability, mean and
    standard deviation, value) is asked anew of a copy of that policy, so that the probability ratio and the KL divergence
    begin an update at one and zero. Taking over the original's instead, as for an equivariant policy, lets every asymmetry of
    the networks count as a step already taken: the adaptive learning rate then sinks and half of the samples are clipped.
    """

    def __init__(self) -> None:
        super().__init__(env=None, data_augmentation_func=mirror_observations, use_data_augmentation=True)  # pyright: ignore[reportArgumentType]
        self._actor: MLPModel | None = None
        self._critic: MLPModel | None = None

    def remember(self, actor: MLPModel, critic: MLPModel) -> None:
        """Copy the networks as they were when they acted; to be called before every update."""
        self._actor, self._critic = copy.deepcopy(actor), copy.deepcopy(critic)

    def augment_batch(self, batch: RolloutStorage.Batch, original_batch_size: int) -> None:
        """Mirror a random half of the mini-batch in place."""
        assert self._actor is not None and self._critic is not None
        assert batch.observations is not None and batch.actions is not None and batch.values is not None
        assert batch.old_actions_log_prob is not None and batch.old_distribution_params is not None
        chosen = torch.randperm(original_batch_size, device=batch.actions.device)[: original_batch_size // 2]
        obs = mirror_observations(batch.observations[chosen])
        actions = mirror_actions(batch.actions[chosen])
        with torch.inference_mode():
            self._actor(obs, stochastic_output=True)
            log_prob = self._actor.get_output_log_prob(actions)
            params = self._actor.output_distribution_params
            values = self._critic(obs)
        for name, value in obs.items():
            batch.observations[name][chosen] = value
        batch.actions[chosen] = actions
        batch.values[chosen] = values
        batch.old_actions_log_prob[chosen] = log_prob.unsqueeze(-1)
        for old, new in zip(batch.old_distribution_params, params, strict=True):
            old[chosen] = new

    def compute_loss(self, actor: MLPModel, batch: RolloutStorage.Batch, original_batch_size: int) -> torch.Tensor:
        """No mirror loss is used; rsl_rl would run another forward pass only to log it."""
        return torch.zeros(())


class MirrorPPO(PPO):
    """rsl_rl's PPO that learns from each sample or from its mirror image, at random."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self.symmetry: RandomMirror = RandomMirror()

    def update(self) -> dict[str, float]:
        """One update of the networks; rsl_rl's losses by name."""
        self.symmetry.remember(self._raw_actor, self._raw_critic)
        return super().update()


def _apply(values: torch.Tensor, index: torch.Tensor, sign: torch.Tensor) -> torch.Tensor:
    return values[..., index.to(values.device)] * sign.to(values.device, values.dtype)
