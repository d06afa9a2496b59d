"""The seven numbers of a quadrupedal SLIP."""

from __future__ import annotations

import math
from dataclasses import astuple, dataclass

import numpy as np
from numpy.typing import NDArray

from symdyn.errors import InvalidValue


@dataclass(frozen=True)
class SlipParameters:
    """Dimensionless parameters of the model of Gan et al. (2016) and Ding & Gan (2024).

    Units: torso mass M = 1, gravity g = 1, torso length (hind hip to front hip) 1. The defaults are the reference set
    of the literature, whose legs are as long as the torso.

    The order of the fields is the order of the parameter vector of :func:`slip.orbits.orbit.residual`.

    Attributes:
        stiffness: k, mean stiffness of a leg [M g / torso length].
        swing_stiffness: k_s, of the spring that swings a leg about its hip; the swing frequency is sqrt(k_s) / l.
        pitch_inertia: J, of the torso about its centre of mass [M torso length^2].
        rest_length: l, of a leg [torso length].
        resting_angle: of a swinging leg at rest, relative to the torso's normal, positive forwards [rad].
        hind_distance: l_b, from the hind hip forwards to the centre of mass [torso length]; 0.5 is a symmetric torso.
        stiffness_ratio: k_r, hind over front leg stiffness.
    """

    stiffness: float = 10.0
    swing_stiffness: float = 20.0
    pitch_inertia: float = 2.0
    rest_length: float = 1.0
    resting_angle: float = 0.0
    hind_distance: float = 0.5
    stiffness_ratio: float = 1.0

    def __post_init__(self) -> None:
        for name in ("stiffness", "swing_stiffness", "pitch_inertia", "rest_length", "stiffness_ratio"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0.0):
                raise InvalidValue(name, value, "a finite number > 0")
        if not (math.isfinite(self.hind_distance) and 0.0 < self.hind_distance < 1.0):
            raise InvalidValue(
                "hind_distance", self.hind_distance, "between 0 and 1 (the centre of mass, between hips)"
            )
        if not abs(self.resting_angle) < math.pi / 2:
            raise InvalidValue("resting_angle", self.resting_angle, "within (-pi/2, pi/2)")

    @property
    def hind_stiffness(self) -> float:
        """Stiffness of a hind leg, 2 k k_r / (1 + k_r)."""
        return 2.0 * self.stiffness * self.stiffness_ratio / (1.0 + self.stiffness_ratio)

    @property
    def front_stiffness(self) -> float:
        """Stiffness of a front leg, 2 k / (1 + k_r)."""
        return 2.0 * self.stiffness / (1.0 + self.stiffness_ratio)

    @property
    def front_hind_symmetric(self) -> bool:
        """Whether front and hind of the model are each other's mirror image."""
        return self.hind_distance == 0.5 and self.stiffness_ratio == 1.0 and self.resting_angle == 0.0

    def vector(self) -> NDArray[np.float64]:
        """All seven, (7,), in the order of the fields."""
        return np.array(astuple(self), dtype=np.float64)

    @classmethod
    def from_vector(cls, vector: NDArray[np.float64]) -> SlipParameters:
        """The parameters of a (7,) vector. Raises InvalidValue."""
        if np.shape(vector) != (7,):
            raise InvalidValue("parameters", np.shape(vector), "seven numbers: k, ks, J, l, resting angle, lb, kr")
        return cls(*(float(value) for value in vector))


REFERENCE = SlipParameters()
"""k 10, ks 20, J 2 (Gan et al. 2016; Ding & Gan 2024)."""
