"""Small environments on the real simulator, and what tests do with them."""

from __future__ import annotations

import copy
import functools
import math
from pathlib import Path
from typing import Any

import mujoco
import torch

from rl.physics.batch import BatchPhysics
from rl.physics.model import build_model
from rl.task.env import GaitEnv
from rl.task.settings import CommandConfig, EnvConfig
from symdyn.gait.timing import TimingCurve
from tests.robots import GO2

LIVELY = CommandConfig(
    velocity_first_s=(0.1, 0.3), velocity_again_s=(0.1, 0.3), gait_first_s=(0.1, 0.3), gait_again_s=(0.1, 0.3)
)
"""Commands that change all the time."""


@functools.cache
def compiled() -> mujoco.MjModel:
    return build_model(GO2)


def make(n: int = 4, seed: int = 0, num_threads: int = 1, dump_dir: Path | None = None, **config: Any) -> GaitEnv:
    physics = BatchPhysics(copy.copy(compiled()), GO2, n, num_threads)
    return GaitEnv(EnvConfig(**config), physics, TimingCurve(), GO2, seed=seed, dump_dir=dump_dir)


def physics_of(env: GaitEnv) -> BatchPhysics:
    assert isinstance(env.physics, BatchPhysics)
    return env.physics


def random_actions(n: int, steps: int, seed: int = 0, scale: float = 1.0) -> torch.Tensor:
    return scale * torch.randn((steps, n, 12), generator=torch.Generator().manual_seed(seed))


def bits(*tensors: torch.Tensor) -> list[bytes]:
    return [tensor.numpy().tobytes() for tensor in tensors]


def trajectory(env: GaitEnv, actions: torch.Tensor) -> list[list[bytes]]:
    """Everything that the learner gets, step by step, to the last bit."""
    found = []
    for action in actions:
        obs, reward, done, extras = env.step(action.clone())
        found.append(bits(obs["policy"], obs["privileged"], reward, done, extras["time_outs"]))
    return found


def diverge(env: GaitEnv, k: int, value: float = math.nan) -> None:
    physics_of(env).batch.qvel[k, 7] = value
