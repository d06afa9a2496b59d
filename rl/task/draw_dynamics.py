"""Robots drawn at random: each as a :class:`rl.physics.dynamics.Dynamics` says."""

from __future__ import annotations

import math

import numpy as np
import torch
from numpy.typing import NDArray

from rl.physics.dynamics import Dynamics
from rl.physics.randomization import RandomizationConfig
from rl.task.commands import uniform
from symdyn.robot.legs import JOINTS


def draw(config: RandomizationConfig, n: int, generator: torch.Generator) -> Dynamics:
    """n robots from these ranges."""

    def drawn(bounds: tuple[float, float], *shape: int) -> NDArray[np.float64]:
        return uniform(bounds, (n, *shape), generator).double().numpy()

    def around_zero(half_widths: tuple[float, ...]) -> NDArray[np.float64]:
        return drawn((-1.0, 1.0), len(half_widths)) * np.array(half_widths)

    joints = len(JOINTS)
    steepness = np.tan(drawn((0.0, config.slope)))
    direction = drawn((-math.pi, math.pi))
    added_mass = drawn(config.added_mass)
    # a load may sit anywhere; what a lighter trunk lacks is taken from its centre, or its inertia could vanish
    mass_pos_b = around_zero(config.mass_pos_b) * (added_mass > 0.0)[:, None]
    return Dynamics(
        added_mass=added_mass,
        mass_pos_b=mass_pos_b,
        com_shift_b=around_zero(config.com_shift_b),
        friction=drawn(config.friction),
        strength=np.repeat(drawn(config.strength)[:, None], joints, axis=1),
        kp=drawn(config.gains, joints),
        kd=drawn(config.gains, joints),
        joint_offset=drawn((-config.joint_offset, config.joint_offset), joints),
        delay=drawn(config.delay_s),
        slope=steepness[:, None] * np.column_stack([np.cos(direction), np.sin(direction)]),
    )
