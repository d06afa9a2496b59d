"""Batches of robots on the real simulator, and what tests put into them."""

from __future__ import annotations

import copy
import functools
from dataclasses import fields

import mujoco
import numpy as np
import torch

from rl.physics.batch import BatchPhysics
from rl.physics.dynamics import Dynamics
from rl.physics.model import build_model
from rl.physics.protocol import Pose, RobotState
from rl.physics.randomization import RandomizationConfig
from rl.task.draw_dynamics import draw
from tests.robots import GO2

STAND = torch.from_numpy(GO2.default_joint_pos)


@functools.cache
def _compiled() -> mujoco.MjModel:
    return build_model(GO2)


def fresh_model() -> mujoco.MjModel:
    return copy.copy(_compiled())


def poses(n: int, seed: int = 0, height: float = 0.38) -> Pose:
    rng = np.random.default_rng(seed)
    yaw = rng.uniform(-np.pi, np.pi, n)
    return Pose(
        base_pos_w=np.column_stack([rng.normal(size=(n, 2)), np.full(n, height)]),
        base_quat_w=np.column_stack([np.cos(yaw / 2), np.zeros((n, 2)), np.sin(yaw / 2)]),
        base_vel_w=rng.uniform(-0.3, 0.3, (n, 3)),
        joint_pos=GO2.default_joint_pos + rng.uniform(-0.1, 0.1, (n, 12)),
    )


def standing(n: int) -> Pose:
    upright = np.tile([1.0, 0.0, 0.0, 0.0], (n, 1))
    position = np.tile([0.0, 0.0, 0.36], (n, 1))
    return Pose(position, upright, np.zeros((n, 3)), np.tile(GO2.default_joint_pos, (n, 1)))


def some(pose: Pose, ids: np.ndarray) -> Pose:
    return Pose(**{name: value[ids] for name, value in vars(pose).items()})


def targets(rng: np.random.Generator, n: int) -> torch.Tensor:
    return STAND + torch.from_numpy(rng.uniform(-0.4, 0.4, (n, 12)))


def make(n: int, num_threads: int = 1, seed: int = 0) -> BatchPhysics:
    physics = BatchPhysics(fresh_model(), GO2, n, num_threads)
    physics.reset(np.arange(n), poses(n, seed))
    return physics


def bits(state: RobotState) -> dict[str, bytes]:
    return {f.name: getattr(state, f.name).numpy().tobytes() for f in fields(state)}


def varied(n: int, seed: int) -> Dynamics:
    """Robots that differ from the model in everything."""
    ranges = RandomizationConfig(
        mass_pos_b=(0.1, 0.05, 0.05),
        com_shift_b=(0.03, 0.02, 0.02),
        strength=(0.8, 1.1),
        gains=(0.8, 1.2),
        joint_offset=0.02,
        delay_s=(0.0, 0.03),
        slope=0.1,
    )
    return draw(ranges, n, torch.Generator().manual_seed(seed))
