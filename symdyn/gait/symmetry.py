"""The symmetry group of a quadruped and how gaits sit in it.

The body's group is K4 = {e, g_s, g_t, g_r}: reflection in the sagittal plane (left <-> right), in the transverse plane
(front <-> hind), and their product, the half turn about the vertical axis. Each element permutes legs, maps base
vectors by R (axial ones by det(R) R) and joint angles by a sign. An element of the spatio-temporal group adds a shift
of the stride phase and, possibly, the reversal of time.

For a gait, K is the subgroup of K4 that leaves its offsets alone, H the elements that leave them alone up to a phase
shift (Golubitsky, Stewart, Buono & Collins 1999). :func:`classify` finds both by trying every element.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from array_api_compat import array_namespace
from numpy.typing import NDArray

from symdyn.arrays import Array
from symdyn.errors import UnknownName
from symdyn.gait.library import LIBRARY, Gait, wrap
from symdyn.gait.phase import wrapped
from symdyn.robot.legs import JOINTS, LEG_JOINT_AXES_B, LEG_JOINTS, LEGS, is_front, is_left

TOLERANCE = 0.01
"""epsilon_sigma of the paper: offsets this close (in strides) count as equal."""

PAIRS: tuple[tuple[int, int], ...] = tuple(combinations(range(len(LEGS)), 2))
"""Every unordered pair of legs as indices into LEGS."""


@dataclass(frozen=True)
class Spatial:
    """An element of K4.

    Attributes:
        name: e, g_s, g_t or g_r.
        swaps_sides: whether left and right are exchanged.
        swaps_ends: whether front and hind are exchanged.
    """

    name: str
    swaps_sides: bool
    swaps_ends: bool

    @property
    def reflection_b(self) -> NDArray[np.float64]:
        """Diagonal of R on vectors of the body frame (x forward, y left, z up), (3,)."""
        return np.array([-1.0 if self.swaps_ends else 1.0, -1.0 if self.swaps_sides else 1.0, 1.0])

    @property
    def axial_reflection_b(self) -> NDArray[np.float64]:
        """Diagonal of det(R) R, for angular velocities and torques, (3,)."""
        return float(np.prod(self.reflection_b)) * self.reflection_b

    def leg_image(self, leg: str) -> str:
        """Where a leg goes: ``g_s`` takes LH to RH."""
        left = is_left(leg) != self.swaps_sides
        front = is_front(leg) != self.swaps_ends
        return next(other for other in LEGS if is_left(other) == left and is_front(other) == front)

    @property
    def leg_index(self) -> tuple[int, ...]:
        """``index`` such that ``x[..., index]`` is the transformed array over legs. All elements are involutions."""
        return tuple(LEGS.index(self.leg_image(leg)) for leg in LEGS)

    @property
    def joint_index(self) -> tuple[int, ...]:
        """``index`` such that ``joint_signs * q[..., index]`` are the transformed joint angles."""
        names = [joint.partition("_") for joint in JOINTS]
        return tuple(JOINTS.index(f"{self.leg_image(leg)}_{kind}") for leg, _, kind in names)

    @property
    def leg_joint_signs(self) -> NDArray[np.float64]:
        """Sign of each joint of a leg, (3,): a rotation by q about an axis becomes one by sign * q about the same axis.

        Rotations are axial: the image of the axis is det(R) R a, which for an axis along x, y or z is plus or minus a.
        """
        axes = np.array([LEG_JOINT_AXES_B[joint] for joint in LEG_JOINTS])
        return np.sum(axes * (axes * self.axial_reflection_b), axis=-1)

    @property
    def joint_signs(self) -> NDArray[np.float64]:
        """:attr:`leg_joint_signs` for every joint of JOINTS, (12,)."""
        return np.tile(self.leg_joint_signs, len(LEGS))

    def __matmul__(self, other: Spatial) -> Spatial:
        """The product: first ``other``, then this."""
        sides, ends = self.swaps_sides != other.swaps_sides, self.swaps_ends != other.swaps_ends
        return next(g for g in K4 if (g.swaps_sides, g.swaps_ends) == (sides, ends))


E = Spatial("e", swaps_sides=False, swaps_ends=False)
G_S = Spatial("g_s", swaps_sides=True, swaps_ends=False)
G_T = Spatial("g_t", swaps_sides=False, swaps_ends=True)
G_R = Spatial("g_r", swaps_sides=True, swaps_ends=True)
K4 = (E, G_S, G_T, G_R)


@dataclass(frozen=True)
class SpatioTemporal:
    """A spatial element followed by a shift of the stride and, possibly, the reversal of time.

    Attributes:
        spatial: element of K4.
        shift: of the stride phase, in [0, 1).
        reverses_time: whether the motion runs backwards.
    """

    spatial: Spatial
    shift: float = 0.0
    reverses_time: bool = False

    def on_offsets(self, offsets: NDArray[np.float64]) -> NDArray[np.float64]:
        """The transformed offsets, (..., 4): permuted, then negated if time is reversed, then shifted; wrapped."""
        moved = np.asarray(offsets)[..., list(self.spatial.leg_index)]
        return wrapped((-moved if self.reverses_time else moved) + self.shift)

    def on_gait(self, gait: Gait) -> Gait:
        """The gait's image, named after both."""
        name = self.spatial.name + ("~" if self.reverses_time else "")
        return Gait.wrapped(f"{name}({gait.name})", self.on_offsets(gait.theta))

    def __matmul__(self, other: SpatioTemporal) -> SpatioTemporal:
        """The product: first ``other``, then this."""
        carried = -other.shift if self.reverses_time else other.shift
        return SpatioTemporal(
            self.spatial @ other.spatial,
            float(wrapped(np.asarray(carried + self.shift))),
            self.reverses_time != other.reverses_time,
        )

    def inverse(self) -> SpatioTemporal:
        """The element that undoes this one."""
        shift = self.shift if self.reverses_time else -self.shift
        return SpatioTemporal(self.spatial, float(wrapped(np.asarray(shift))), self.reverses_time)


@dataclass(frozen=True)
class SymmetryClass:
    """Where a gait sits in the group.

    Attributes:
        K: names of the elements of K4 that leave the gait alone.
        H: (element, shift) pairs that leave it alone: the gait's image under the element is the gait, shift later.
        time_reversal_partner: name of the gait that the time-reversed gait is: of the library, or the library's gait's
            mirror image as ``NAME_mirrored``, or None.
        symmetric_pairs: pairs of legs with equal offsets.
    """

    K: tuple[str, ...]
    H: tuple[tuple[str, float], ...]
    time_reversal_partner: str | None
    symmetric_pairs: tuple[tuple[str, str], ...]

    @property
    def group(self) -> tuple[tuple[str, ...], tuple[tuple[str, float], ...]]:
        """(K, H): gaits that agree in it are of one class."""
        return self.K, self.H

    def describe(self) -> str:
        """K and H by generators, as the literature writes them: ``K=<g_r> H=K4``."""
        return f"K={_subgroup_name(self.K)} H={_subgroup_name(element for element, _ in self.H)}"


def _subgroup_name(elements: Iterable[str]) -> str:
    names = [name for name in elements if name != E.name]
    if not names:
        return "1"
    return f"<{names[0]}>" if len(names) == 1 else "K4"


def common_shift(
    image: NDArray[np.float64], offsets: NDArray[np.float64], tolerance: float = TOLERANCE
) -> float | None:
    """The shift s with image = offsets + s on the circle for every leg, in [0, 1), or None if there is none.

    Args:
        image: (4,).
        offsets: (4,).
        tolerance: largest difference of a leg from its neighbour's shift, strides.
    """
    differences = np.asarray(image) - np.asarray(offsets)
    spread = wrap(differences - differences[0])
    if np.ptp(spread) > tolerance:
        return None
    shift = float(wrapped(differences[0] + (spread.max() + spread.min()) / 2.0))
    return 0.0 if min(shift, 1.0 - shift) <= tolerance / 2.0 else shift


def classify(gait: Gait, tolerance: float = TOLERANCE) -> SymmetryClass:
    """Symmetry class of a gait, by exhaustive check of K4 with every shift.

    Args:
        gait: any gait.
        tolerance: offsets closer than this are equal, strides.
    """
    found = []
    for element in K4:
        shift = common_shift(gait.theta[list(element.leg_index)], gait.theta, tolerance)
        if shift is not None:
            found.append((element.name, round(shift, 6)))
    return SymmetryClass(
        K=tuple(name for name, shift in found if shift == 0.0),
        H=tuple(found),
        time_reversal_partner=_partner(gait, tolerance),
        symmetric_pairs=tuple(
            (LEGS[i], LEGS[j]) for i, j in PAIRS if abs(float(wrap(gait.theta[i] - gait.theta[j]))) <= tolerance
        ),
    )


def mirrored(gait: Gait) -> Gait:
    """The same gait led by the other side: its image under g_s, called ``NAME_mirrored``."""
    return Gait.wrapped(f"{gait.name}_mirrored", SpatioTemporal(G_S).on_offsets(gait.theta))


def time_reversed(gait: Gait) -> Gait:
    """The gait with time running backwards, called ``NAME_reversed``."""
    return Gait.wrapped(f"{gait.name}_reversed", SpatioTemporal(E, reverses_time=True).on_offsets(gait.theta))


def _partner(gait: Gait, tolerance: float) -> str | None:
    partner = time_reversed(gait)
    # the gait itself first, so that a gait which is its own partner says so
    for candidate in (gait, *LIBRARY.values(), mirrored(gait), *map(mirrored, LIBRARY.values())):
        if common_shift(partner.theta, candidate.theta, tolerance) is not None:
            return candidate.name
    return None


def pairs_in_phase(offsets: Array, tolerance: float = TOLERANCE) -> Array:
    """f(sigma(i, j)) of the paper: which pairs of legs share an offset.

    Args:
        offsets: (..., 4).
        tolerance: epsilon_sigma, strides, on the circle.

    Returns:
        (..., 6) bool, in the order of :data:`PAIRS`.
    """
    xp = array_namespace(offsets)
    columns = []
    for i, j in PAIRS:
        difference = offsets[..., i] - offsets[..., j]
        columns.append(xp.abs(difference - xp.round(difference)) <= tolerance)
    return xp.stack(columns, axis=-1)


def pair_joint_signs() -> NDArray[np.float64]:
    """Signs s with which joints of the two legs of a pair agree, q_i = s q_j, when the legs move alike. (6, 3).

    Legs of one side move alike with equal angles; legs of opposite sides are each other's mirror image, so that their
    angles agree up to the signs of g_s. (g_t and g_r, which would turn fore-aft motion round, play no part: two legs in
    phase swing forward together.)
    """
    signs = {False: E.leg_joint_signs, True: G_S.leg_joint_signs}
    return np.stack([signs[is_left(LEGS[i]) != is_left(LEGS[j])] for i, j in PAIRS])


def phase_groups(gait: Gait, tolerance: float = TOLERANCE) -> tuple[int, ...]:
    """For each leg the first leg with its offset, (4,): noise that such legs share keeps K and every pair."""
    return tuple(
        next(j for j in range(len(LEGS)) if abs(float(wrap(gait.theta[i] - gait.theta[j]))) <= tolerance)
        for i in range(len(LEGS))
    )


MIRRORED = "_mirrored"
"""After a gait's name: its mirror image (symdyn.gait.symmetry.mirrored), which leads with the other foot."""


def gait_by_name(name: str) -> Gait:
    """A gait of the library, or with :data:`MIRRORED` after its name the mirror image of one.

    Raises:
        UnknownName: if there is none.
    """
    plain = name.removesuffix(MIRRORED)
    if plain not in LIBRARY:
        raise UnknownName("gait", name, [*LIBRARY, *(f"{known}{MIRRORED}" for known in LIBRARY)])
    return LIBRARY[name] if plain == name else mirrored(LIBRARY[plain])
