"""Networks that cannot tell left from right: equivariant under g_s by construction.

Hidden layers carry the regular representation of the group {e, g_s}: two sheets of equal width that the mirror
exchanges. A linear map commutes with that exchange exactly when its matrix is [[P, Q], [Q, P]], and an activation that
acts number by number always does (Cohen & Welling 2016; Su et al. 2024 for legged robots). So the network is a plain
multilayer perceptron of the same widths whose weights are tied: it costs as much to run, and has half as many of them.
The maps M of inputs and outputs come from symdyn.policy.observation and symdyn.gait.symmetry; nothing about order or
signs stands here.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from rsl_rl.models import MLPModel
from rsl_rl.modules import MLP, GaussianDistribution
from tensordict import TensorDict
from torch import nn
from torch.distributions import Normal

from rl.task.privileged import PRIVILEGED
from symdyn.errors import InvalidValue
from symdyn.gait.symmetry import G_S
from symdyn.policy.layout import Layout

Mirror = tuple[NDArray[np.int64], NDArray[np.float64]]
"""(index, sign): the mirror image of x is ``sign * x[..., index]``; applied twice it changes nothing."""


def mirror_of_actions() -> Mirror:
    """Mirror map of actions, (12,) each."""
    return np.array(G_S.joint_index), G_S.joint_signs


def mirror_of_groups(groups: Sequence[str], observation: Layout) -> Mirror:
    """Mirror map of observation groups laid end to end.

    Args:
        groups: of ``policy`` and ``privileged``.
        observation: layout of the group ``policy``.
    """
    layouts = {"policy": observation, "privileged": PRIVILEGED}
    indices, signs, start = [], [], 0
    for name in groups:
        index, sign = layouts[name].mirror(G_S)
        indices.append(start + index)
        signs.append(sign)
        start += len(index)
    return np.concatenate(indices), np.concatenate(signs)


class _Tied(nn.Module):
    """An affine map whose matrix is made of fewer numbers; initialised as torch.nn.Linear of the same sizes.

    Args:
        inputs: width of its input.
        shape: of its free weights.
        biases: number of its free biases.
    """

    def __init__(self, inputs: int, shape: tuple[int, ...], biases: int) -> None:
        super().__init__()
        bound = 1.0 / math.sqrt(inputs)
        self.weight = nn.Parameter(torch.empty(shape).uniform_(-bound, bound))
        self.bias = nn.Parameter(torch.empty(biases).uniform_(-bound, bound))

    def expanded(self) -> tuple[torch.Tensor, torch.Tensor]:
        """The whole matrix, (outputs, inputs), and the whole bias, (outputs,)."""
        raise NotImplementedError

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        """(n, inputs) -> (n, outputs)."""
        return nn.functional.linear(x, *self.expanded())


class _WithMirror(_Tied):
    """A map that knows the mirror on one of its sides."""

    index: torch.Tensor
    sign: torch.Tensor

    def __init__(self, inputs: int, shape: tuple[int, ...], biases: int, mirror: Mirror) -> None:
        super().__init__(inputs, shape, biases)
        index, sign = mirror
        self.register_buffer("index", torch.as_tensor(index), persistent=False)
        self.register_buffer("sign", torch.as_tensor(sign, dtype=torch.float32), persistent=False)


class Lift(_WithMirror):
    """From x to the sheets W x + b and W M x + b. Weight (width / 2, inputs)."""

    def __init__(self, inputs: int, width: int, mirror: Mirror) -> None:
        super().__init__(inputs, (width // 2, inputs), width // 2, mirror)

    def expanded(self) -> tuple[torch.Tensor, torch.Tensor]:
        # (W M) x = W (M x): M is an involution, so that its transpose permutes the columns in the same way
        mirrored = self.weight[:, self.index] * self.sign[self.index]
        return torch.cat([self.weight, mirrored]), self.bias.repeat(2)


class Sheets(_Tied):
    """From sheets to sheets: (P a + Q b + c, Q a + P b + c). Weight (2, width / 2, inputs / 2): P and Q."""

    def __init__(self, inputs: int, width: int) -> None:
        super().__init__(inputs, (2, width // 2, inputs // 2), width // 2)

    def expanded(self) -> tuple[torch.Tensor, torch.Tensor]:
        upper = torch.cat([self.weight[0], self.weight[1]], dim=1)
        lower = torch.cat([self.weight[1], self.weight[0]], dim=1)
        return torch.cat([upper, lower]), self.bias.repeat(2)


class Project(_WithMirror):
    """From the sheets to W a + M W b + (c + M c) / 2, which their exchange mirrors. Weight (outputs, inputs / 2)."""

    def __init__(self, inputs: int, outputs: int, mirror: Mirror) -> None:
        super().__init__(inputs, (outputs, inputs // 2), outputs, mirror)

    def expanded(self) -> tuple[torch.Tensor, torch.Tensor]:
        mirrored = self.weight[self.index] * self.sign[:, None]
        bias = 0.5 * (self.bias + self.bias[self.index] * self.sign)
        return torch.cat([self.weight, mirrored], dim=1), bias


class EquivariantMLP(nn.Sequential):
    """f with f(M_in x) = M_out f(x), ELU between its layers.

    Args:
        mirror_in: M_in.
        mirror_out: M_out, or None for an invariant output, f(M_in x) = f(x).
        hidden: widths of the hidden layers, both sheets together; even.
        outputs: width of the output.

    Raises:
        InvalidValue: for an odd width.
    """

    def __init__(self, mirror_in: Mirror, mirror_out: Mirror | None, hidden: Sequence[int], outputs: int) -> None:
        if any(width % 2 for width in hidden):
            raise InvalidValue("The hidden layers of an equivariant network", tuple(hidden), "even widths")
        inputs = len(mirror_in[0])
        if mirror_out is None:
            mirror_out = np.arange(outputs), np.ones(outputs)
        layers: list[nn.Module] = [Lift(inputs, hidden[0], mirror_in)]
        for before, width in pairwise(hidden):
            layers += [nn.ELU(), Sheets(before, width)]
        super().__init__(*layers, nn.ELU(), Project(hidden[-1], outputs, mirror_out))
        self._sizes = inputs, outputs, tuple(hidden)

    @torch.no_grad()
    def plain(self) -> MLP:
        """The same function as an MLP of untied weights."""
        inputs, outputs, hidden = self._sizes
        network = MLP(inputs, outputs, hidden, "elu")
        for tied, layer in zip(self, network, strict=True):
            if isinstance(tied, _Tied) and isinstance(layer, nn.Linear):
                weight, bias = tied.expanded()
                layer.weight.copy_(weight)
                layer.bias.copy_(bias)
        return network


class EquivariantGaussian(GaussianDistribution):
    """rsl_rl's Gaussian action noise with the same standard deviation on both sides: the mean of the learned two."""

    def update(self, mlp_output: torch.Tensor) -> None:
        """Take new means, (n, 12)."""
        index, _ = mirror_of_actions()
        log_std = 0.5 * (self.log_std_param + self.log_std_param[torch.as_tensor(index)])
        std = torch.exp(log_std.clamp(self.log_std_range[0], self.log_std_range[1]))
        self._distribution = Normal(mlp_output, std)


class EquivariantModel(MLPModel):
    """rsl_rl's model around an :class:`EquivariantMLP`: equivariant as an actor, invariant as a critic."""

    def __init__(
        self,
        obs: TensorDict,
        obs_groups: dict[str, list[str]],
        obs_set: str,
        output_dim: int,
        observation: Layout,
        **kwargs: Any,
    ) -> None:
        super().__init__(obs, obs_groups, obs_set, output_dim, **kwargs)
        mirror_out = mirror_of_actions() if obs_set == "actor" else None
        mirror_in = mirror_of_groups(self.obs_groups, observation)
        self.mlp = EquivariantMLP(mirror_in, mirror_out, kwargs["hidden_dims"], output_dim)
