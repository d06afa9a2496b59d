"""A number beside its goal."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Target:
    """A measured number with its goal and the paper's value.

    Attributes:
        what: the number in words, with its unit.
        here: as measured; inf or nan if there is no value.
        goal: the limit that it should keep.
        at_least: whether it should be at least the goal; at most if False.
        paper: the paper's figure, as the paper words it.
        hypothesis: the limit is the paper's finding, to be confirmed or not; it is no goal of this project.
    """

    what: str
    here: float
    goal: float
    at_least: bool = False
    paper: str = "-"
    hypothesis: bool = False

    @property
    def limit(self) -> str:
        """The goal in words."""
        return f"{'at least' if self.at_least else 'at most'} {self.goal:g}"

    @property
    def met(self) -> bool:
        """Whether the goal is met; a missing value meets none."""
        if math.isnan(self.here):
            return False
        return self.here >= self.goal if self.at_least else self.here <= self.goal
