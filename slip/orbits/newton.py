"""Newton's method for periodic gaits, inside a symmetry subspace."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slip.model.unknowns import PERIOD
from slip.orbits.integrate import IntegrationFailure
from slip.orbits.stride import Stride, integrate_stride, turns_of
from slip.orbits.subspace import Subspace

Vector = NDArray[np.float64]

ACCEPTED = 1e-10
"""Largest residual of an orbit."""

_WANTED = 1e-12
_ITERATIONS = 16
_LARGEST_STEP = 0.3
_GOOD_PROGRESS = 0.05


class NoConvergence(ArithmeticError):
    """Newton's method found no orbit near its start. Handled by the callers, which know what to try next."""


@dataclass(frozen=True)
class Corrected:
    """An orbit.

    Attributes:
        coordinates: in the subspace.
        stride: integrated at it.
        iterations: that were needed.
    """

    coordinates: Vector
    stride: Stride
    iterations: int


def correct(space: Subspace, start: Vector, normal: Vector, parameters: Vector) -> Corrected:
    """The orbit nearest to ``start`` in the hyperplane through it.

    The order of events may change between iterations: it is read off the unknowns every time, and the residual is
    continuously differentiable across such a change where the feet that swap order carry no force. An event that
    crosses the apex makes a kink, so it may do so only between two converged solutions.

    Args:
        space: where to search.
        start: coordinates in it, (m,).
        normal: of the hyperplane, (m,).
        parameters: (7,).

    Raises:
        NoConvergence: says why.
    """
    coordinates, matrix = start.copy(), None
    last = np.inf
    turns = turns_of(space.unknowns(start))
    for iteration in range(_ITERATIONS):
        unknowns = space.unknowns(coordinates)
        if unknowns[PERIOD] <= 0.0:
            raise NoConvergence("the stride period shrank to zero")
        try:
            stride = integrate_stride(unknowns, parameters, turns)
        except IntegrationFailure as failure:
            raise NoConvergence(str(failure)) from None
        norm = float(np.abs(stride.residual).max())
        if norm < _WANTED or (norm < ACCEPTED and norm > 0.3 * last):
            if np.array_equal(turns, turns_of(unknowns)):
                return Corrected(coordinates, stride, iteration)
            # an event has crossed the apex: go on from here with the stride as it now is
            turns, matrix, last = turns_of(unknowns), None, np.inf
            continue
        if matrix is None or norm > _GOOD_PROGRESS * last:
            # a Jacobian costs five residuals: keep it as long as it serves
            matrix = np.vstack((space.jacobian(stride.jacobian), normal))
        last = norm
        right = -np.append(space.residual(stride.residual), normal @ (coordinates - start))
        try:
            change = np.linalg.solve(matrix, right)
        except np.linalg.LinAlgError:
            raise NoConvergence("the Jacobian is singular: the start lies on a junction") from None
        if not np.all(np.isfinite(change)):
            raise NoConvergence("the Jacobian is not finite: an event is grazing")
        coordinates = coordinates + change * min(1.0, _LARGEST_STEP / np.abs(change).max())
    raise NoConvergence(f"no convergence in {_ITERATIONS} iterations (residual {last:.1e})")
