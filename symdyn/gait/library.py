"""A gait: when, within a stride, each leg begins its cycle.

A gait is four phase offsets ``theta`` (fractions of a stride, order :data:`symdyn.robot.legs.LEGS`). The phase of leg
``i`` is ``phi + theta_i`` (:func:`symdyn.gait.phase.leg_phase`), so its touchdown comes ``-theta_i`` of a stride later
than that
of a leg with offset zero: the *touchdown delay* of a leg is minus its offset. With the commanded forward velocity the
four offsets are Gamma of the paper (section III-A).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from symdyn.errors import InvalidValue, UnknownName
from symdyn.gait.phase import wrapped
from symdyn.robot.legs import LEGS


def wrap(difference: NDArray[np.float64] | float) -> NDArray[np.float64]:
    """A difference of phases as the signed shortest way round the circle, in [-0.5, 0.5)."""
    return np.mod(np.asarray(difference, dtype=np.float64) + 0.5, 1.0) - 0.5


@dataclass(frozen=True)
class Gait:
    """Four phase offsets with a name.

    Attributes:
        name: what to call it.
        offsets: theta of LH, LF, RF, RH, each in [0, 1).

    Raises:
        InvalidValue: if there are not four finite offsets in [0, 1).
    """

    name: str
    offsets: tuple[float, float, float, float]

    def __post_init__(self) -> None:
        if len(self.offsets) != len(LEGS) or not all(math.isfinite(o) and 0.0 <= o < 1.0 for o in self.offsets):
            raise InvalidValue(
                f"Phase offsets of gait {self.name!r}",
                self.offsets,
                f"{len(LEGS)} numbers in [0, 1): {', '.join(LEGS)}",
            )

    @classmethod
    def wrapped(cls, name: str, offsets: NDArray[np.float64]) -> Gait:
        """A gait from offsets of any value, wrapped onto the circle. ``offsets``: (4,)."""
        lh, lf, rf, rh = wrapped(np.asarray(offsets, dtype=np.float64)).tolist()
        return cls(name, (lh, lf, rf, rh))

    @property
    def theta(self) -> NDArray[np.float64]:
        """The offsets as an array, (4,)."""
        return np.array(self.offsets)

    @property
    def touchdown_delays(self) -> NDArray[np.float64]:
        """Touchdown times in strides after the first leg of the cycle, (4,), in [0, 1)."""
        return wrapped(-self.theta)

    def by_leg(self) -> dict[str, float]:
        """Offsets by the leg's name."""
        return dict(zip(LEGS, self.offsets, strict=True))

    def distance(self, other: Gait) -> float:
        """How far two gaits are apart, in strides: see :func:`pattern_distance`."""
        return float(pattern_distance(self.theta, other.theta))

    def towards(self, other: Gait, weight: float) -> Gait:
        """The mixture ``weight`` of the way from this gait to another, each leg the shorter way round the circle.

        Raises:
            InvalidValue: if the weight is not in [0, 1].
        """
        if not 0.0 <= weight <= 1.0:
            raise InvalidValue("The weight of a gait mixture", weight, "in [0, 1]")
        mixed = self.theta + weight * wrap(other.theta - self.theta)
        return Gait.wrapped(f"{self.name}:{other.name}:{weight:g}", mixed)


def pattern_distance(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Distance of two patterns of phases regardless of where the stride is said to begin.

    The mean over legs of the circular difference, minimised over a common shift. The minimum over the shift of a sum of
    circular distances lies where one leg agrees exactly (it is piecewise linear), so those four shifts are tried.

    Args:
        a: (..., 4) phases.
        b: (..., 4) phases.

    Returns:
        (...,) in [0, 0.25], strides.
    """
    difference = np.asarray(a) - np.asarray(b)
    return np.min(np.mean(np.abs(wrap(difference[..., None, :] - difference[..., :, None])), axis=-1), axis=-1)


def _library() -> Mapping[str, Gait]:
    # theta of LH, LF, RF, RH. The first six: Table I of the paper; the others from the delays of the literature
    # (Hildebrand 1965: a lateral-sequence walk touches down LH, LF, RH, RF a quarter stride apart).
    table = {
        "trot": (0.0, 0.5, 0.0, 0.5),
        "bound": (0.0, 0.5, 0.5, 0.0),
        "half_bound_left": (0.0, 0.63, 0.37, 0.0),
        "half_bound_right": (0.0, 0.37, 0.63, 0.0),
        "rotary_gallop": (0.13, 0.37, 0.63, 0.87),
        "transverse_gallop": (0.13, 0.63, 0.37, 0.87),
        "pronk": (0.0, 0.0, 0.0, 0.0),
        "pace": (0.0, 0.0, 0.5, 0.5),
        "walk": (0.0, 0.75, 0.25, 0.5),
    }
    return MappingProxyType({name: Gait(name, offsets) for name, offsets in table.items()})


LIBRARY: Mapping[str, Gait] = _library()
"""Every gait that has a name."""

PAPER_GAITS = ("trot", "bound", "half_bound_left", "half_bound_right", "rotary_gallop", "transverse_gallop")
"""The six gaits of the paper's Table I: what the policy is trained and judged on."""


def get(name: str) -> Gait:
    """The library's gait of that name.

    Raises:
        UnknownName: if there is none; the message lists those there are.
    """
    try:
        return LIBRARY[name]
    except KeyError:
        raise UnknownName("gait", name, LIBRARY) from None


def nearest(offsets: NDArray[np.float64], candidates: Mapping[str, Gait] = LIBRARY) -> list[str]:
    """The name of the gait nearest to each pattern. ``offsets``: (n, 4); returns n names."""
    names = list(candidates)
    table = np.stack([candidates[name].theta for name in names])
    distances = pattern_distance(np.asarray(offsets)[:, None, :], table[None, :, :])
    return [names[i] for i in np.argmin(distances, axis=1)]
