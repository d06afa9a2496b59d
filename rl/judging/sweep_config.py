"""Settings of a timing sweep."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import product

from rl.judging.paper_protocol import SETTLE_S
from symdyn.errors import InvalidValue
from symdyn.gait import library as gaits
from symdyn.gait.library import PAPER_GAITS

CELL = ("period_factor", "duty_factor")


@dataclass(frozen=True)
class SweepConfig:
    """What a timing sweep tries.

    Attributes:
        period_factors: factors on the stride period of the policy's curve.
        duty_factors: factors on its duty factor.
        speeds: commanded forward velocities, m/s; none is 0, where there is no cost of transport.
        gaits: names from the library.
        seeds: seeds of the initial stride phase.
        seconds: length of a trial from a stand, s; the first second is not judged.
    """

    period_factors: tuple[float, ...] = (0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3)
    duty_factors: tuple[float, ...] = (0.85, 0.925, 1.0, 1.075, 1.15)
    speeds: tuple[float, ...] = (-2.0, -1.5, -1.0, -0.5, -0.2, 0.2, 0.5, 1.0, 1.5, 2.0)
    gaits: tuple[str, ...] = PAPER_GAITS
    seeds: tuple[int, ...] = (0,)
    seconds: float = 6.0

    def __post_init__(self) -> None:
        for name in ("period_factors", "duty_factors", "speeds", "gaits", "seeds"):
            values = getattr(self, name)
            if not values or len(set(values)) != len(values):
                raise InvalidValue(name, values, "at least one value, without duplicates")
        for name in CELL:
            values = getattr(self, f"{name}s")
            if not all(0.0 < value < math.inf for value in values):
                raise InvalidValue(f"{name}s", values, "finite numbers > 0")
        if not all(math.isfinite(speed) and speed != 0.0 for speed in self.speeds):
            raise InvalidValue("speeds", self.speeds, "finite numbers other than 0")
        for name in self.gaits:
            gaits.get(name)
        if min(self.seeds) < 0:
            raise InvalidValue("seeds", self.seeds, "whole numbers >= 0")
        if not SETTLE_S + 1.0 < self.seconds < math.inf:
            raise InvalidValue("seconds", self.seconds, f"a finite number > {SETTLE_S + 1.0:g}")

    @property
    def cells(self) -> list[tuple[float, float]]:
        """Pairs of factors, (period, duty)."""
        return list(product(self.period_factors, self.duty_factors))

    @property
    def trials(self) -> int:
        """Rows of the whole table."""
        return len(self.cells) * len(self.speeds) * len(self.gaits) * len(self.seeds)
