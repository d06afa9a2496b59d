r"""Which symmetries of the model a periodic gait has: every element of a group of sixteen, tried on the orbit.

Generators, acting on gaits as linear maps of the 22 unknowns (:mod:`slip.model.unknowns`):

==========  ==================================================  ======================================================
``h``       left <-> right of the hind pair                     exchanges all that belongs to the two legs
``f``       left <-> right of the front pair                    alike
``m``       mirror, front <-> hind                              x -> -x, phi -> -phi, alpha -> -alpha; legs of a side
``t``       time reversal                                       rates negated; touchdown: T - t_lo, lift-off T - t_td
==========  ==================================================  ======================================================

The model is planar, so that nothing couples left to right: each pair may be exchanged by itself. h and f commute, m h =
f m, and all three commute with t: the group is D4 x Z2, of order 16. The elements of the body's K4
(:mod:`symdyn.gait.symmetry`) are among them: g_s = hf, g_t = m, g_r = hfm.

Two questions are asked of every element g and orbit o (style of Ding & Gan 2024, section III):

1. Is g(o) an orbit? For h and f always, for m if the model is its own mirror image (lb = 1/2, kr = 1, resting angle 0);
   otherwise g(o) is an orbit of the mirrored model (:meth:`OrbitElement.on_parameters`). For t only where the leg's
   rate is continuous at touchdown: a touchdown resets it, and a jump cannot run backwards.
2. Is g(o) the same gait, from another moment of its cycle on?
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product

import numpy as np
from numpy.typing import NDArray

from slip.model.parameters import SlipParameters
from slip.model.unknowns import (
    ALPHA,
    COUNT,
    DALPHA,
    DPHI,
    DX,
    DY,
    EVENTS,
    LIFTOFF,
    PERIOD,
    PHI,
    SLIP_LEGS,
    STATES,
    TOUCHDOWN,
    of_leg,
    pair_swap,
    wrapped,
)
from slip.orbits.integrate import integrate
from slip.orbits.orbit import Orbit, residual
from symdyn.errors import SymdynError
from symdyn.gait.library import Gait
from symdyn.gait.symmetry import K4, SymmetryClass, classify
from symdyn.robot.legs import is_front, is_left

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

ORBIT_TOLERANCE = 1e-8
"""Largest residual of an image that counts as an orbit (those that fail do so by 1e-4 and more)."""

SAME_TOLERANCE = 1e-7
"""Largest difference of two gaits that count as one."""


@dataclass(frozen=True)
class OrbitElement:
    """An element of D4 x Z2: first ``t``, then ``m``, ``f``, ``h``.

    Attributes:
        hind: whether left and right of the hind pair are exchanged.
        front: whether left and right of the front pair are.
        mirror: whether front and hind are, with x -> -x.
        reverses_time: whether the motion runs backwards.
    """

    hind: bool = False
    front: bool = False
    mirror: bool = False
    reverses_time: bool = False

    @property
    def name(self) -> str:
        """The generators of which it is the product: ``hfm``; ``e`` for none."""
        flags = {"h": self.hind, "f": self.front, "m": self.mirror, "t": self.reverses_time}
        return "".join(letter for letter, flag in flags.items() if flag) or "e"

    @property
    def described(self) -> str:
        """In words."""
        sides = {(True, True): "left-right of both pairs", (True, False): "left-right of the hind pair"}
        sides |= {(False, True): "left-right of the front pair", (False, False): ""}
        parts = [sides[self.hind, self.front], "mirror" if self.mirror else ""]
        parts.append("time reversal" if self.reverses_time else "")
        return ", ".join(part for part in parts if part) or "identity"

    @property
    def spatial_name(self) -> str | None:
        """Name of the element of K4 that it is when time runs forwards, or None."""
        if self.hind != self.front:
            return None
        return next(g.name for g in K4 if (g.swaps_sides, g.swaps_ends) == (self.hind, self.mirror))

    @property
    def reverses_direction(self) -> bool:
        """Whether a gait that runs forwards becomes one that runs backwards."""
        return self.mirror != self.reverses_time

    @cached_property
    def matrix(self) -> Matrix:
        """The linear map of the unknowns, (22, 22), of entries -1, 0 and 1."""
        result = np.eye(COUNT)
        for flag, generator in (
            (self.reverses_time, _reversal),
            (self.mirror, _mirror),
            (self.front, lambda: np.eye(COUNT)[list(pair_swap("front"))]),
            (self.hind, lambda: np.eye(COUNT)[list(pair_swap("hind"))]),
        ):
            if flag:
                result = generator() @ result
        return result

    def on_unknowns(self, unknowns: Vector) -> Vector:
        """The image of a gait, (22,), event times within [0, T)."""
        return wrapped(self.matrix @ unknowns)

    def on_parameters(self, parameters: SlipParameters) -> SlipParameters:
        """The model of which the image is a gait."""
        if not self.mirror:
            return parameters
        return replace(
            parameters,
            hind_distance=1.0 - parameters.hind_distance,
            stiffness_ratio=1.0 / parameters.stiffness_ratio,
            resting_angle=-parameters.resting_angle,
        )

    def __matmul__(self, other: OrbitElement) -> OrbitElement:
        """The product: first ``other``, then this."""
        hind, front = (other.front, other.hind) if self.mirror else (other.hind, other.front)
        return OrbitElement(
            self.hind != hind,
            self.front != front,
            self.mirror != other.mirror,
            self.reverses_time != other.reverses_time,
        )

    def inverse(self) -> OrbitElement:
        """The element that undoes this one."""
        return replace(self, hind=self.front, front=self.hind) if self.mirror else self


GROUP = tuple(
    OrbitElement(hind, front, mirror, reverses_time)
    for reverses_time, mirror, front, hind in product((False, True), repeat=4)
)
"""All sixteen; those that keep the direction of time first."""


def _reversal() -> Matrix:
    matrix = np.eye(COUNT)
    for i in (DX, DY, DPHI, *DALPHA):
        matrix[i, i] = -1.0
    for touchdown, liftoff in zip(TOUCHDOWN, LIFTOFF, strict=True):
        for event, other in ((touchdown, liftoff), (liftoff, touchdown)):
            matrix[event] = 0.0
            matrix[event, other], matrix[event, PERIOD] = -1.0, 1.0
    return matrix


def _mirror() -> Matrix:
    sign = np.ones(COUNT)
    sign[[DX, PHI, DPHI, *ALPHA, *DALPHA]] = -1.0
    index = list(range(COUNT))
    for leg in range(len(SLIP_LEGS)):
        for here, there in zip(of_leg(leg), of_leg(_other_end(leg)), strict=True):
            index[here] = there
    return np.diag(sign) @ np.eye(COUNT)[index]


def _other_end(leg: int) -> int:
    name = SLIP_LEGS[leg]
    return next(
        i for i, other in enumerate(SLIP_LEGS) if is_left(other) == is_left(name) and is_front(other) != is_front(name)
    )


@dataclass(frozen=True)
class Image:
    """What an element makes of an orbit.

    Attributes:
        element: it.
        keeps_model: whether the element maps the model to itself.
        residual: largest residual of the image in the orbit's own model; infinity if it cannot be integrated.
        shift: the image begins this much later in the cycle of the orbit, strides in [0, 1): where the touchdowns of
            the legs agree best.
        distance: largest difference of the image to the orbit from there on: states at the image's apex, and event
            times in the cycle.
    """

    element: OrbitElement
    keeps_model: bool
    residual: float
    shift: float
    distance: float

    @property
    def is_orbit(self) -> bool:
        """Whether the image is a periodic gait of the same model."""
        return self.residual <= ORBIT_TOLERANCE

    @property
    def is_same(self) -> bool:
        """Whether it is the same gait."""
        return self.is_orbit and self.distance <= SAME_TOLERANCE


@dataclass(frozen=True)
class OrbitSymmetry:
    """The symmetries of a periodic gait.

    Attributes:
        images: under every element, in the order of :data:`GROUP`.
        gait: the footfall.
        footfall_class: of the footfall, by symdyn: what the pattern of touchdowns alone has.
        touchdown_jump: largest jump of a leg's rate at touchdown [sqrt(g / torso length)]: what time reversal breaks.
    """

    images: tuple[Image, ...]
    gait: Gait
    footfall_class: SymmetryClass
    touchdown_jump: float

    def image(self, name: str) -> Image:
        """Under the element of that name."""
        return next(image for image in self.images if image.element.name == name)

    @property
    def group(self) -> tuple[str, ...]:
        """Names of the elements under which the gait is the same gait: its symmetry group."""
        return tuple(image.element.name for image in self.images if image.is_same)

    @property
    def siblings(self) -> tuple[str, ...]:
        """Names of the elements that map it to another gait of the same model: the other lead, the other direction."""
        return tuple(image.element.name for image in self.images if image.is_orbit and not image.is_same)

    @property
    def reversible(self) -> bool:
        """Whether the gait run backwards in time is a gait."""
        return self.image("t").is_orbit


def orbit_symmetry(orbit: Orbit) -> OrbitSymmetry:
    """Try every element of the group on an orbit."""
    gait = orbit.gait()
    return OrbitSymmetry(tuple(image(orbit, g) for g in GROUP), gait, classify(gait), touchdown_jump(orbit))


def image(orbit: Orbit, element: OrbitElement) -> Image:
    """What an element makes of an orbit."""
    unknowns = element.on_unknowns(orbit.unknowns)
    try:
        off = float(np.abs(residual(unknowns, orbit.parameters)).max())
    except SymdynError:  # not even a stride
        off = np.inf
    keeps_model = element.on_parameters(orbit.parameters) == orbit.parameters
    return Image(element, keeps_model, off, *compare(orbit, unknowns))


def touchdown_jump(orbit: Orbit) -> float:
    """Largest change of a leg's rate dalpha at its touchdown [sqrt(g / torso length)]."""
    stride, jumps = orbit.stride, []
    for i, event in enumerate(stride.events):
        if EVENTS.start + event in TOUCHDOWN:
            rate = DALPHA[event // 2]
            jumps.append(abs(float(stride.segments[i + 1].starts[0][rate] - stride.segments[i].end[rate])))
    return max(jumps)


def state_at(orbit: Orbit, time: float) -> Vector:
    """The state (13,) of an orbit at a time, of any cycle; after the event if one happens then."""
    stride, time = orbit.stride, float(np.mod(time, orbit.period))
    # at the end of the last segment the state is the first one's start
    segment = min(int(np.searchsorted(stride.bounds, time, side="right")) - 1, len(stride.segments) - 1)
    start = stride.segments[segment].starts[0]
    contact = stride.contacts[segment]
    return integrate(start, contact, orbit.parameters.vector(), time - float(stride.bounds[segment])).end


def compare(orbit: Orbit, unknowns: Vector) -> tuple[float, float]:
    """How far a gait is from an orbit, wherever in the cycle it begins.

    Args:
        orbit: it.
        unknowns: of the gait, (22,); it may begin at any moment, not just at an apex.

    Returns:
        The moment of the orbit's cycle at which the gait begins, strides in [0, 1), and the largest difference from
        there on, of the state at the beginning or the time of an event.
    """
    period = orbit.period
    events, own = unknowns[EVENTS], wrapped(orbit.unknowns)[EVENTS]
    best = (0.0, np.inf)
    # a time of the image is a time of the orbit less the shift; every leg's touchdown proposes one
    for proposed in {round(float(np.mod(own[i] - events[i], period)), 9) for i in range(0, len(own), 2)}:
        shift = _refined(own - events - proposed, period) + proposed
        around = own - events - shift
        off = np.abs(around - period * np.round(around / period)).max()
        if off < best[1]:
            states = np.abs(state_at(orbit, shift) - unknowns[STATES]).max()
            best = min(best, (float(np.mod(shift, period) / period), float(max(off, states))), key=lambda pair: pair[1])
    shift, distance = best
    return (0.0 if min(shift, 1.0 - shift) < SAME_TOLERANCE else shift), distance


def _refined(differences: Vector, period: float) -> float:
    """Mean of differences that are small up to whole periods; those that are not have no say."""
    around = differences - period * np.round(differences / period)
    near = np.abs(around) < 1e-6
    return float(around[near].mean()) if near.any() else 0.0
