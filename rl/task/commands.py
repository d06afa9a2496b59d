"""What the robot is told to do: gait, velocity, and when they change."""

from __future__ import annotations

import torch

from rl.task.settings import CommandConfig
from symdyn.gait.library import get
from symdyn.gait.phase import wrapped
from symdyn.gait.symmetry import classify, phase_groups

NEVER = float("inf")


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
        """n gaits: their index into ``config.gaits``, (n,) int64, and their noisy offsets, (n, 4) in [0, 1).

        The index of a mixture is that of the gait it starts from.
        """
        device = self.offsets.device
        index = torch.multinomial(self.probability, n, replacement=True, generator=generator)
        noise = torch.rand((n, self.offsets.shape[1]), generator=generator, device=device) * 2.0 - 1.0
        shared = torch.gather(noise, 1, self._groups[index])
        drawn = self.offsets[index] + self.config.offset_noise * shared
        if self.config.mixture_share > 0.0:
            drawn = torch.where(self._mixed(n, generator)[:, None], self._towards_another(drawn, generator), drawn)
        return index, wrapped(drawn)

    def _mixed(self, n: int, generator: torch.Generator) -> torch.Tensor:
        return torch.rand(n, generator=generator, device=self.offsets.device) < self.config.mixture_share

    def _towards_another(self, drawn: torch.Tensor, generator: torch.Generator) -> torch.Tensor:
        """A random part of the way to another drawn gait, each leg the shorter way round the circle. (n, 4)."""
        n, device = len(drawn), drawn.device
        other = torch.multinomial(self.probability, n, replacement=True, generator=generator)
        part = torch.rand((n, 1), generator=generator, device=device)
        return drawn + part * (wrapped(self.offsets[other] - drawn + 0.5) - 0.5)


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
        self._generator = generator
        self._device = device
        self.configure(config)
        self.gait_index = torch.zeros(num_envs, dtype=torch.int64, device=device)
        self.offsets = torch.zeros((num_envs, self._sampler.offsets.shape[1]), device=device)
        self.velocity = torch.zeros((num_envs, 3), device=device)
        self.period_delta = torch.zeros(num_envs, device=device)
        self.duty_delta = torch.zeros(num_envs, device=device)
        self.velocity_due = torch.zeros(num_envs, device=device)
        self.gait_due = torch.zeros(num_envs, device=device)

    def configure(self, config: CommandConfig) -> None:
        """Draw from other ranges from now on."""
        self.config = config
        self._sampler = GaitSampler(config, self._device)

    def reset(self, ids: torch.Tensor) -> None:
        """New commands for robots whose episode begins. ``ids``: (n,)."""
        self._new_velocity(ids)
        self._new_gait(ids)
        self.velocity_due[ids] = self._uniform(self.config.velocity_first_s, len(ids))
        self.gait_due[ids] = self._uniform(self.config.gait_first_s, len(ids))

    def update(self, time: torch.Tensor) -> bool:
        """Change what is due at these episode times, (N,) s. Returns whether anything was."""
        before = torch.minimum(self.velocity_due, self.gait_due)
        if not bool((time >= before).any()):
            return False
        ids = torch.nonzero(time >= self.velocity_due).flatten()
        if len(ids):
            self._new_velocity(ids)
            self.velocity_due[ids] = time[ids] + self._interval(self.config.velocity_again_s, len(ids))
        ids = torch.nonzero(time >= self.gait_due).flatten()
        if len(ids):
            self._new_gait(ids)
            self.gait_due[ids] = time[ids] + self._interval(self.config.gait_again_s, len(ids))
        return True

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
        self.velocity[ids] = self._restrict(velocity)
        self.period_delta[ids] = self._uniform((-1.0, 1.0), n)
        self.duty_delta[ids] = self._uniform((-1.0, 1.0), n)

    def _restrict(self, velocity: torch.Tensor) -> torch.Tensor:
        """Some stand, step in place, or run straight; none turns too fast. (n, 3) -> (n, 3)."""
        c, n = self.config, len(velocity)
        if not c.steered:
            return velocity
        kind, turns, sidesteps = (self._uniform((0.0, 1.0), n) for _ in range(3))
        stands, in_place = kind < c.stand_share, kind < c.stand_share + c.in_place_share
        x = torch.where(in_place, 0.0, velocity[:, 0])
        y = torch.where(sidesteps < c.sidestep_share, velocity[:, 1], 0.0)
        yaw = torch.where(turns < c.turn_share, velocity[:, 2], 0.0)
        if c.lateral_acceleration is not None:
            yaw = yaw * (c.lateral_acceleration / x.abs().clamp(min=1e-6) / yaw.abs().clamp(min=1e-6)).clamp(max=1.0)
        drawn = torch.where(stands[:, None], 0.0, torch.stack([x, y, yaw], dim=1))
        return c.steering.dead_band.apply(drawn, torch.zeros_like(drawn))

    def _new_gait(self, ids: torch.Tensor) -> None:
        self.gait_index[ids], self.offsets[ids] = self._sampler.draw(len(ids), self._generator)

    def _interval(self, bounds: tuple[float, float] | None, n: int) -> torch.Tensor | float:
        return NEVER if bounds is None else self._uniform(bounds, n)

    def _uniform(self, bounds: tuple[float, float], n: int) -> torch.Tensor:
        return uniform(bounds, (n,), self._generator, self._device)
