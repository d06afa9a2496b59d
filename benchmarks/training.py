"""Training against the sum of what it cannot do without: bare physics, inference, forward and backward passes."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path

import torch

from benchmarks.environment import bare_batch
from benchmarks.result import Result, in_turns
from rl.learning.config import TrainConfig
from rl.learning.presets import preset
from rl.learning.trainer import Trainer
from rl.physics.batch import BatchPhysics

_ROUNDS = 5


def measure() -> list[Result]:
    """End to end against the parts, and bfloat16 against float32."""
    with tempfile.TemporaryDirectory() as folder:
        config = preset("cpu")
        automatic = Trainer(config, Path(folder))
        full = Trainer(_with_precision(config, "off"), Path(folder))
        parts = _Parts(automatic)
        whole_s, parts_s, full_s = in_turns([automatic.update, parts.run, full.update], _ROUNDS)
    samples = automatic.config.samples_per_iteration
    details = {"samples_per_s": samples / whole_s, "samples_per_s_of_parts": samples / parts_s}
    precision = {"samples_per_s_float32": samples / full_s}
    return [
        Result("training / (physics + inference + forward and backward)", parts_s / whole_s, "", 0.75, details=details),
        Result("training, default precision / float32", full_s / whole_s, "", details=precision),
    ]


def _with_precision(config: TrainConfig, value: str) -> TrainConfig:
    assert value in ("on", "off")
    return replace(config, ppo=replace(config.ppo, mixed_precision=value))


class _Parts:
    """One update's worth of physics, inference and network passes, without environment, reward or optimiser."""

    def __init__(self, trainer: Trainer) -> None:
        self._ppo = trainer.config.ppo
        self._algorithm = trainer.ppo
        self._obs = trainer.env.get_observations()
        physics = trainer.env.physics
        assert isinstance(physics, BatchPhysics)
        self._physics = physics
        self._bare = bare_batch(trainer.env)
        size = trainer.config.samples_per_iteration // self._ppo.mini_batches
        rows = torch.randint(0, trainer.config.num_envs, (size,), generator=torch.Generator().manual_seed(0))
        self._batch = self._obs[rows]

    def run(self) -> None:
        """The work of one update."""
        actor, critic = self._algorithm.actor, self._algorithm.critic
        self._bare.state[:] = self._physics.batch.state
        with torch.inference_mode():
            for _ in range(self._ppo.steps):
                actor(self._obs)
                critic(self._obs)
                self._bare.step(nstep=self._physics.substeps)
        for _ in range(self._ppo.epochs * self._ppo.mini_batches):
            with torch.autocast("cpu", dtype=torch.bfloat16, enabled=self._algorithm.use_mixed_precision):
                loss = actor(self._batch).square().mean() + critic(self._batch).square().mean()
            self._algorithm.optimizer.zero_grad()
            loss.backward()
