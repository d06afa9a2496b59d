"""Domain randomisation and observation noise: Table III of the paper."""

from __future__ import annotations

from dataclasses import dataclass

from symdyn.errors import InvalidValue


@dataclass(frozen=True)
class RandomizationConfig:
    """Ranges; the defaults are the paper's Table III. Mass and friction are drawn once for each simulation.

    Attributes:
        added_mass: kg, added to the trunk.
        friction: factor on the default friction.
        push: change of each horizontal component of the trunk's velocity in a push, m/s.
        push_interval_s: time between pushes, s (the paper gives none).
        observation_noise: whether the noise of the observation table is added.
        late_share: share of the robots, the first ones, whose joint targets take effect one control step late (the
            paper has no such delay).
    """

    added_mass: tuple[float, float] = (-1.5, 1.5)
    friction: tuple[float, float] = (0.3, 2.0)
    push: tuple[float, float] = (-0.25, 0.25)
    push_interval_s: tuple[float, float] = (5.0, 10.0)
    observation_noise: bool = True
    late_share: float = 0.0

    def __post_init__(self) -> None:
        if not 0.0 < self.friction[0] <= self.friction[1]:
            raise InvalidValue("The range of friction factors", self.friction, "two numbers > 0, the smaller first")
        if not 0.0 < self.push_interval_s[0] <= self.push_interval_s[1]:
            raise InvalidValue("push_interval_s", self.push_interval_s, "two times > 0, the smaller first")
        if not 0.0 <= self.late_share <= 1.0:
            raise InvalidValue("late_share", self.late_share, "in [0, 1]")


NOMINAL = RandomizationConfig(
    added_mass=(0.0, 0.0), friction=(1.0, 1.0), push=(0.0, 0.0), push_interval_s=(1e9, 1e9), observation_noise=False
)
"""The model as it is, seen without noise."""
