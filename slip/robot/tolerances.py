"""How exact a symmetry of a robot must be."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

from symdyn.errors import InvalidValue


@dataclass(frozen=True)
class Tolerances:
    """How far off an element may be and count as a symmetry.

    Attributes:
        kinematics: foot position, relative to the largest distance of a foot from its hip.
        mass: mass matrix, relative.
        limits: joint limits, rad.
    """

    kinematics: float = 1e-3
    mass: float = 1e-2
    limits: float = 1e-2

    def __post_init__(self) -> None:
        for item in fields(self):
            value = getattr(self, item.name)
            if not 0.0 <= value < math.inf:
                raise InvalidValue(f"tolerances.{item.name}", value, "a finite number >= 0")
