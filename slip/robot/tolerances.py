"""How exact a symmetry of a robot must be."""

from __future__ import annotations

from dataclasses import dataclass


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
