"""A reward that changes while training: first to move, then to keep time.

With the paper's weights a robot learns to follow a velocity within a few million samples, but runs asymmetric gaits as
bounds; with weights that insist on the gait from the start it steps on the spot and learns to move late
(docs/results.md). So the weights go from the one set to the other, over a range of samples in which the action noise is
still wide.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields

from rl.task.rewards import RewardConfig
from symdyn.errors import InvalidValue


@dataclass(frozen=True)
class RewardCurriculum:
    """Where the reward goes, and when.

    Attributes:
        active: whether the reward changes at all; False keeps the initial one.
        start: samples up to which the initial reward holds.
        end: samples from which the final one does; between the two, every number moves linearly.
        final: the final reward. kappa and the switch of the morphological term stay those of the initial one.
    """

    active: bool = False
    start: float = 6e6
    end: float = 10e6
    final: RewardConfig = field(default_factory=RewardConfig)

    def __post_init__(self) -> None:
        if not 0.0 <= self.start < self.end < math.inf:
            raise InvalidValue("The curriculum's samples", (self.start, self.end), "0 <= start < end")

    def at(self, initial: RewardConfig, samples: float) -> RewardConfig:
        """The reward after so many samples, begun with ``initial``."""
        if not self.active:
            return initial
        share = min(max((samples - self.start) / (self.end - self.start), 0.0), 1.0)
        values = {}
        for item in fields(RewardConfig):
            first, last = getattr(initial, item.name), getattr(self.final, item.name)
            values[item.name] = first if item.name in _KEPT else (1.0 - share) * first + share * last
        return RewardConfig(**values)


_KEPT = ("kappa", "morphological_term")
