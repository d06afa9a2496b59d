"""Where branches meet: located on a branch, with the direction in which the other one leaves."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slip.families.continuation import Point, point
from slip.model.unknowns import DX
from slip.orbits.newton import NoConvergence, correct
from slip.orbits.subspace import Subspace, subspace

Vector = NDArray[np.float64]

ACCURACY = 1e-9
"""To which the unknowns of a junction are found."""


@dataclass(frozen=True)
class Crossing:
    """A junction on a branch.

    Attributes:
        kinds: test functions that vanish there: ``even``, ``hind``, ``front``.
        unknowns: of the orbit, (22,).
        directions: by kind, in which a branch leaves, (22,).
    """

    kinds: tuple[str, ...]
    unknowns: Vector
    directions: dict[str, Vector]

    def space_after(self, kind: str, before: Subspace) -> Subspace:
        """Subspace of the branch that leaves."""
        return before if kind == "even" else subspace(*(pair for pair in before.pairs if pair != kind))


def crossings(space: Subspace, before: Point, after: Point, parameters: Vector) -> list[Crossing]:
    """All junctions between two neighbouring points of a branch, those at one orbit taken together."""
    found: list[tuple[str, Vector, Point]] = []
    for kind in before.tests:
        if before.tests[kind] * after.tests[kind] < 0.0:
            try:
                located = located_between(space, before, after, lambda p, kind=kind: p.tests[kind], parameters)
            except NoConvergence:
                continue
            found.append((kind, located.unknowns, located))
    result: list[Crossing] = []
    secant = space.coordinates(after.unknowns - before.unknowns)
    secant /= np.linalg.norm(secant)
    while found:
        kind, unknowns, at = found.pop(0)
        same = [other for other in found if np.abs(other[1] - unknowns).max() < 1e-4]
        found = [other for other in found if not any(other is twin for twin in same)]
        kinds = (kind, *(other[0] for other in same))
        result.append(Crossing(kinds, unknowns, {k: _direction(space, at, k, secant) for k in kinds}))
    return result


def turning_point(space: Subspace, before: Point, after: Point, parameters: Vector) -> Point | None:
    """The orbit between two neighbouring points where the apex speed turns round, or None."""

    def dx_along(at: Point) -> float:
        return float(space.unknowns(at.tangent)[DX])

    if dx_along(before) * dx_along(after) >= 0.0:
        return None
    try:
        return located_between(space, before, after, dx_along, parameters)
    except NoConvergence:
        return None


def located_between(
    space: Subspace, before: Point, after: Point, function: Callable[[Point], float], parameters: Vector
) -> Point:
    """The zero of a function along a branch, between two points at which it has different signs.

    Raises:
        NoConvergence: if the branch cannot be followed between them.
    """
    start, chord = space.coordinates(before.unknowns), space.coordinates(after.unknowns - before.unknowns)
    low, high = 0.0, 1.0
    f_low, f_high = function(before), function(after)
    here, last = before, before.unknowns
    for iteration in range(60):
        # Illinois: regula falsi that halves the weight of an end that stays; every fourth step is a bisection
        where = 0.5 * (low + high) if iteration % 4 == 3 else (low * f_high - high * f_low) / (f_high - f_low)
        corrected = correct(space, start + where * chord, chord / np.linalg.norm(chord), parameters)
        here = point(space, corrected.stride, space.unknowns(corrected.coordinates), chord)
        f = function(here)
        moved, last = float(np.abs(here.unknowns - last).max()), here.unknowns
        if f == 0.0 or moved < ACCURACY or (high - low) * np.abs(chord).max() < ACCURACY:
            break
        if f * f_low > 0.0:
            low, f_low, f_high = where, f, 0.5 * f_high
        else:
            high, f_high, f_low = where, f, 0.5 * f_low
    return here


def _direction(space: Subspace, at: Point, kind: str, secant: Vector) -> Vector:
    if kind == "even":
        # null vector of the block that is not the branch's own tangent, which the block cannot tell apart there
        null = np.linalg.svd(np.vstack((space.jacobian(at.jacobian), secant)))[2][-1]
        return space.unknowns(null)
    null = np.linalg.svd(space.odd_block(at.jacobian, kind))[2][-1]
    return space.odd[kind] @ null
