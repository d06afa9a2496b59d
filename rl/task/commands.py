"""What the robot is told to do: gait, velocity, and when they change."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Literal

import numpy as np
import torch

from symdyn.errors import InvalidValue
from symdyn.gait.library import PAPER_GAITS, get
from symdyn.gait.phase import wrapped
from symdyn.gait.symmetry import classify, phase_groups

NEVER = float("inf")


@dataclass(frozen=True)
class CommandConfig:
    """How commands are drawn; the defaults are the paper's (section III-E).

    Attributes:
        gaits: names from the library.
        choose: ``class`` draws a symmetry class first and then one of its gaits; ``gait`` draws a gait.
        weights: how much oftener than by that each gait is drawn, in the order of ``gaits``; empty for all alike.
        offset_noise: half-width of the uniform noise on each offset, strides.
        noise_keeps_class: legs in phase share their noise, so that K and the pairs sigma(i, j) of the gait survive;
            False draws it leg by leg (paper), with which a pair survives in 44% of the draws (epsilon_sigma 0.01).
        velocity_x: range of forward velocity, m/s.
        forward_share: share of commands with v_x > 0, where the range has both signs; None draws uniformly from the
            range (paper). Forward running is learned later than backward running.
        velocity_y: range of lateral velocity, m/s.
        yaw_rate: rad/s.
        velocity_first_s: time into the episode of the first change of velocity, drawn from this range, s.
        velocity_again_s: time between later changes, s; empty for none.
        gait_first_s: as for the velocity.
        gait_again_s: as for the velocity.
        time_reversal: the map of the paper's eq. (7) for v < 0; False is an ablation of the paper.
    """

    gaits: tuple[str, ...] = PAPER_GAITS
    choose: Literal["class", "gait"] = "gait"
    weights: tuple[float, ...] = ()
    offset_noise: float = 0.02
    noise_keeps_class: bool = False
    velocity_x: tuple[float, float] = (-2.0, 2.0)
    forward_share: float | None = None
    velocity_y: tuple[float, float] = (0.0, 0.0)
    yaw_rate: tuple[float, float] = (0.0, 0.0)
    velocity_first_s: tuple[float, float] = (10.0, 10.0)
    velocity_again_s: tuple[float, float] | None = None
    gait_first_s: tuple[float, float] = (20.0, 20.0)
    gait_again_s: tuple[float, float] | None = None
    time_reversal: bool = True

    def __post_init__(self) -> None:
        if not self.gaits:
            raise InvalidValue("The list of gaits to train", self.gaits, "at least one name")
        for name in self.gaits:
            get(name)
        if self.weights and not (
            len(self.weights) == len(self.gaits) and all(0.0 < weight < NEVER for weight in self.weights)
        ):
            raise InvalidValue("weights", self.weights, f"{len(self.gaits)} numbers > 0, one a gait")
        if not 0.0 <= self.offset_noise < 0.5:
            raise InvalidValue("offset_noise", self.offset_noise, "in [0, 0.5)")
        for field in fields(self):
            value = getattr(self, field.name)
            if field.name.endswith(("_s", "_x", "_y", "_rate")) and value is not None:
                low, high = value
                if not (np.isfinite(low) and np.isfinite(high) and low <= high):
                    raise InvalidValue(field.name, value, "two finite numbers, the smaller first")
                if field.name.endswith("_s") and low <= 0.0:
                    raise InvalidValue(field.name, value, "times > 0")
        if self.forward_share is not None:
            if not 0.0 <= self.forward_share <= 1.0:
                raise InvalidValue("forward_share", self.forward_share, "in [0, 1]")
            if not self.velocity_x[0] < 0.0 < self.velocity_x[1]:
                raise InvalidValue("velocity_x", self.velocity_x, "a range with both signs, for a forward_share")


class GaitSampler:
    """Draws gaits by class, with noise on their offsets.

    Args:
        config: what to draw from.
        device: of the tensors.
    """

    def __init__(self, config: CommandConfig, device: str = "cpu") -> None:
        self.config = config
        gaits = [get(name) for name in config.gaits]
        self.offsets = torch.tensor([g.offsets for g in gaits], device=device)
        groups = [phase_groups(g) if config.noise_keeps_class else tuple(range(len(g.offsets))) for g in gaits]
        self._groups = torch.tensor(groups, device=device)
        self.probability = torch.tensor(_probabilities(config), device=device)

    def draw(self, n: int, generator: torch.Generator) -> tuple[torch.Tensor, torch.Tensor]:
        """n gaits: their index into ``config.gaits``, (n,) int64, and their noisy offsets, (n, 4) in [0, 1)."""
        device = self.offsets.device
        index = torch.multinomial(self.probability, n, replacement=True, generator=generator)
        noise = torch.rand((n, self.offsets.shape[1]), generator=generator, device=device) * 2.0 - 1.0
        shared = torch.gather(noise, 1, self._groups[index])
        return index, wrapped(self.offsets[index] + self.config.offset_noise * shared)


def _probabilities(config: CommandConfig) -> list[float]:
    shares = config.weights or (1.0,) * len(config.gaits)
    if config.choose == "class":
        groups = [classify(get(name)).group for name in config.gaits]
        shares = tuple(share / groups.count(group) for share, group in zip(shares, groups, strict=True))
    return [share / sum(shares) for share in shares]


def uniform(
    bounds: tuple[float, float], shape: tuple[int, ...], generator: torch.Generator, device: str = "cpu"
) -> torch.Tensor:
    """Uniform numbers in a range. Shape as given."""
    low, high = bounds
    return low + (high - low) * torch.rand(shape, generator=generator, device=device)


class Commands:
    """The commands of N robots, and when each changes next.

    Attributes:
        gait_index: (N,) into ``config.gaits``.
        offsets: (N, 4).
        velocity: (N, 3) v_x, v_y, yaw rate.
        period_delta, duty_delta: (N,) in [-1, 1], the deltas of the paper's eq. (1), drawn anew with every velocity.
        velocity_due, gait_due: (N,) episode times of the next change, s.
    """

    def __init__(self, config: CommandConfig, num_envs: int, generator: torch.Generator, device: str = "cpu") -> None:
        self.config = config
        self._sampler = GaitSampler(config, device)
        self._generator = generator
        self._device = device
        self.gait_index = torch.zeros(num_envs, dtype=torch.int64, device=device)
        self.offsets = torch.zeros((num_envs, self._sampler.offsets.shape[1]), device=device)
        self.velocity = torch.zeros((num_envs, 3), device=device)
        self.period_delta = torch.zeros(num_envs, device=device)
        self.duty_delta = torch.zeros(num_envs, device=device)
        self.velocity_due = torch.zeros(num_envs, device=device)
        self.gait_due = torch.zeros(num_envs, device=device)

    def reset(self, ids: torch.Tensor) -> None:
        """New commands for robots whose episode begins. ``ids``: (n,)."""
        self._new_velocity(ids)
        self._new_gait(ids)
        self.velocity_due[ids] = self._uniform(self.config.velocity_first_s, len(ids))
        self.gait_due[ids] = self._uniform(self.config.gait_first_s, len(ids))

    def update(self, time: torch.Tensor) -> None:
        """Change what is due at these episode times, (N,) s."""
        ids = torch.nonzero(time >= self.velocity_due).flatten()
        if len(ids):
            self._new_velocity(ids)
            self.velocity_due[ids] = time[ids] + self._interval(self.config.velocity_again_s, len(ids))
        ids = torch.nonzero(time >= self.gait_due).flatten()
        if len(ids):
            self._new_gait(ids)
            self.gait_due[ids] = time[ids] + self._interval(self.config.gait_again_s, len(ids))

    def state_dict(self) -> dict[str, torch.Tensor]:
        """All tensors, copied."""
        return {name: value.clone() for name, value in vars(self).items() if isinstance(value, torch.Tensor)}

    def load_state_dict(self, state: dict[str, torch.Tensor]) -> None:
        """Go on from :meth:`state_dict`."""
        for name, value in state.items():
            getattr(self, name).copy_(value)

    def _new_velocity(self, ids: torch.Tensor) -> None:
        n = len(ids)
        bounds = (self.config.velocity_x, self.config.velocity_y, self.config.yaw_rate)
        velocity = torch.stack([self._uniform(bound, n) for bound in bounds], dim=1)
        if self.config.forward_share is not None:
            low, high = self.config.velocity_x
            share = self._uniform((0.0, 1.0), n)
            forward = self._uniform((0.0, 1.0), n) < self.config.forward_share
            velocity[:, 0] = torch.where(forward, high * share, low * share)
        self.velocity[ids] = velocity
        self.period_delta[ids] = self._uniform((-1.0, 1.0), n)
        self.duty_delta[ids] = self._uniform((-1.0, 1.0), n)

    def _new_gait(self, ids: torch.Tensor) -> None:
        self.gait_index[ids], self.offsets[ids] = self._sampler.draw(len(ids), self._generator)

    def _interval(self, bounds: tuple[float, float] | None, n: int) -> torch.Tensor | float:
        return NEVER if bounds is None else self._uniform(bounds, n)

    def _uniform(self, bounds: tuple[float, float], n: int) -> torch.Tensor:
        return uniform(bounds, (n,), self._generator, self._device)
