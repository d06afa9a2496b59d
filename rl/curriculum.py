"""A reward that changes while training: first to move, then to keep time.

With the paper's weights a robot learns to follow a velocity within a few million samples, but runs asymmetric gaits as
bounds; with weights that insist on the gait from the start it steps on the spot and learns to move late
(docs/results.md). So the weights go from the one set to the other, over a range of samples in which the action noise is
still wide.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields

from rl.rewards import RewardConfig
from symdyn.errors import InvalidValue


@dataclass(frozen=True)
class RewardCurriculum:
    """Where the reward goes, and when.

    Attributes:
        start: samples up to which the initial settings hold.
        end: samples from which the final ones do; between the two, every number moves linearly.
        final: the final settings. kappa and the switches must be those of the initial ones.
    """

    start: float = 6e6
    end: float = 10e6
    final: RewardConfig = field(default_factory=RewardConfig)

    def __post_init__(self) -> None:
        if not 0.0 <= self.start < self.end:
            raise InvalidValue("The curriculum's samples", (self.start, self.end), "0 <= start < end")

    def at(self, initial: RewardConfig, samples: float) -> RewardConfig:
        """The settings after so many samples.

        Raises:
            InvalidValue: if kappa or a switch differs between initial and final.
        """
        share = min(max((samples - self.start) / (self.end - self.start), 0.0), 1.0)
        values = {}
        for item in fields(RewardConfig):
            first, last = getattr(initial, item.name), getattr(self.final, item.name)
            if item.name in _FIXED:
                if first != last:
                    raise InvalidValue(f"curriculum.final.{item.name}", last, f"the initial reward's, {first!r}")
                values[item.name] = first
            else:
                values[item.name] = first + share * (last - first)
        return RewardConfig(**values)


_FIXED = ("kappa", "morphological_term")
