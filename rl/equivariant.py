"""Networks that cannot tell left from right: equivariant under g_s by construction.

For any network f, the actor (f(s) + M f(M s)) / 2 maps the mirror image of an observation to the mirror image of the
action, and the critic (f(s) + f(M s)) / 2 gives both the same value (group averaging, e.g. Ordonez-Apraez et al. 2023;
Su et al. 2024). The maps M come from symdyn.observation and symdyn.symmetry; nothing about order or signs stands here.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from rsl_rl.models import MLPModel
from rsl_rl.modules import GaussianDistribution
from tensordict import TensorDict
from torch import nn
from torch.distributions import Normal

from rl.privileged import PRIVILEGED
from symdyn.observation import OBSERVATION
from symdyn.symmetry import G_S

_LAYOUTS = {"policy": OBSERVATION, "privileged": PRIVILEGED}

Mirror = tuple[NDArray[np.int64], NDArray[np.float64]]
"""(index, sign): the mirror image of x is ``sign * x[..., index]``."""


def mirror_of_actions() -> Mirror:
    """Mirror map of actions, (12,) each."""
    return np.array(G_S.joint_index), G_S.joint_signs


def mirror_of_groups(groups: Sequence[str]) -> Mirror:
    """Mirror map of observation groups laid end to end."""
    indices, signs, start = [], [], 0
    for name in groups:
        index, sign = _LAYOUTS[name].mirror(G_S)
        indices.append(start + index)
        signs.append(sign)
        start += len(index)
    return np.concatenate(indices), np.concatenate(signs)


class GroupAverage(nn.Module):
    """(f(x) + M_out f(M_in x)) / 2.

    Args:
        network: f.
        mirror_in: map of its input.
        mirror_out: map of its output; None where the output is invariant.
    """

    in_index: torch.Tensor
    in_sign: torch.Tensor
    out_index: torch.Tensor
    out_sign: torch.Tensor

    def __init__(self, network: nn.Module, mirror_in: Mirror, mirror_out: Mirror | None) -> None:
        super().__init__()
        self.network = network
        self._register("in", mirror_in)
        self._invariant = mirror_out is None
        if mirror_out is not None:
            self._register("out", mirror_out)

    def _register(self, name: str, mirror: Mirror) -> None:
        index, sign = mirror
        self.register_buffer(f"{name}_index", torch.as_tensor(index), persistent=False)
        self.register_buffer(f"{name}_sign", torch.as_tensor(sign, dtype=torch.float32), persistent=False)

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        """(n, inputs) -> (n, outputs)."""
        straight = self.network(x)
        mirrored = self.network(x[..., self.in_index] * self.in_sign)
        if not self._invariant:
            mirrored = mirrored[..., self.out_index] * self.out_sign
        return 0.5 * (straight + mirrored)


class EquivariantGaussian(GaussianDistribution):
    """rsl_rl's Gaussian action noise with the same standard deviation on both sides: the mean of the learned two."""

    def update(self, mlp_output: torch.Tensor) -> None:
        """Take new means, (n, 12)."""
        index, _ = mirror_of_actions()
        log_std = 0.5 * (self.log_std_param + self.log_std_param[torch.as_tensor(index)])
        std = torch.exp(log_std.clamp(self.log_std_range[0], self.log_std_range[1]))
        self._distribution = Normal(mlp_output, std)


class EquivariantModel(MLPModel):
    """rsl_rl's MLP model, averaged over {e, g_s}: equivariant as an actor, invariant as a critic."""

    def __init__(
        self, obs: TensorDict, obs_groups: dict[str, list[str]], obs_set: str, *args: Any, **kwargs: Any
    ) -> None:
        super().__init__(obs, obs_groups, obs_set, *args, **kwargs)
        mirror_out = mirror_of_actions() if obs_set == "actor" else None
        self.mlp = GroupAverage(self.mlp, mirror_of_groups(self.obs_groups), mirror_out)
