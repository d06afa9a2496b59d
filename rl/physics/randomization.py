"""Domain randomisation and observation noise: Table III of the paper, and what deployed projects add to it."""

from __future__ import annotations

import math
from dataclasses import dataclass

from symdyn.errors import InvalidValue


@dataclass(frozen=True)
class RandomizationConfig:
    """Ranges; the defaults are the paper's Table III. All but pushes and noise is drawn once for each simulation.

    Attributes:
        added_mass: kg, added to the trunk.
        friction: factor on the default friction.
        push: change of each horizontal component of the trunk's velocity in a push, m/s.
        push_interval_s: time between pushes, s (the paper gives none).
        observation_noise: whether the noise of the observation table is added.
        mass_pos_b: half-widths of where the added mass sits, m from the trunk's centre of mass (not in the paper).
        com_shift_b: half-widths of the displacement of the trunk's centre of mass, m (not in the paper; HIMLoco has
            0.05, mjlab 0.03).
        strength: factor on the torque of every motor of a robot (not in the paper; HIMLoco and walk-these-ways have 0.9
            to 1.1, parkour 0.8 to 1.2).
        gains: factor on kp and on kd, drawn for each joint (not in the paper; HIMLoco has 0.9 to 1.1).
        joint_offset: half-width of the error of the encoders' zero, rad (not in the paper; walk-these-ways has 0.02,
            mjlab 0.015).
        delay_s: from observation to motor response, s, counted in physics steps (not in the paper; walk-these-ways has
            about 0.03, parkour 0.005 to 0.045).
        slope: steepest slope of the floor, rad; drawn uniformly in size and direction (not in the paper).
    """

    added_mass: tuple[float, float] = (-1.5, 1.5)
    friction: tuple[float, float] = (0.3, 2.0)
    push: tuple[float, float] = (-0.25, 0.25)
    push_interval_s: tuple[float, float] = (5.0, 10.0)
    observation_noise: bool = True
    mass_pos_b: tuple[float, float, float] = (0.0, 0.0, 0.0)
    com_shift_b: tuple[float, float, float] = (0.0, 0.0, 0.0)
    strength: tuple[float, float] = (1.0, 1.0)
    gains: tuple[float, float] = (1.0, 1.0)
    joint_offset: float = 0.0
    delay_s: tuple[float, float] = (0.0, 0.0)
    slope: float = 0.0

    def __post_init__(self) -> None:
        for name in ("added_mass", "push"):
            low, high = getattr(self, name)
            if not -math.inf < low <= high < math.inf:
                raise InvalidValue(name, (low, high), "two finite numbers, the smaller first")
        for name in ("friction", "push_interval_s", "strength", "gains"):
            low, high = getattr(self, name)
            if not 0.0 < low <= high < math.inf:
                raise InvalidValue(name, (low, high), "two numbers > 0, the smaller first")
        if not 0.0 <= self.delay_s[0] <= self.delay_s[1] <= 0.5:
            raise InvalidValue("delay_s", self.delay_s, "two times from 0 to 0.5 s, the shorter first")
        for name in ("mass_pos_b", "com_shift_b"):
            if not all(0.0 <= value < math.inf for value in getattr(self, name)):
                raise InvalidValue(name, getattr(self, name), "three lengths >= 0")
        if not 0.0 <= self.joint_offset < 1.0:
            raise InvalidValue("joint_offset", self.joint_offset, "in [0, 1) rad")
        if not 0.0 <= self.slope < 0.6:
            raise InvalidValue("slope", self.slope, "in [0, 0.6) rad")


NOMINAL = RandomizationConfig(
    added_mass=(0.0, 0.0), friction=(1.0, 1.0), push=(0.0, 0.0), push_interval_s=(1e9, 1e9), observation_noise=False
)
"""The model as it is, seen without noise."""
