"""Gaits whose left and right legs of some pairs move together: the linear subspaces that branches live in."""

from __future__ import annotations

from functools import cache, cached_property

import numpy as np
from numpy.typing import NDArray

from slip.model.unknowns import COUNT, PAIRS, Y, of_leg, pair_difference

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]


class Subspace:
    """Unknowns for which the pairs named move together, in orthonormal coordinates.

    The residual of such a gait is of the same kind (exchanging the two legs maps strides to strides), so Newton's
    method and continuation can stay inside, and the Jacobian splits into this block and a 4 x 4 block for every pair
    that moves together. Energy is conserved, which makes one residual redundant: the row of y, whose coefficient (the
    torso's vertical acceleration at the apex) is never zero.

    Attributes:
        pairs: of ``hind``, ``front``: the pairs that move together.
        basis: (22, m), orthonormal.
        rows: (22, m - 1), orthonormal: the residuals that are left.
    """

    def __init__(self, pairs: tuple[str, ...]) -> None:
        self.pairs = pairs
        columns = []
        together = [PAIRS[pair] for pair in pairs]
        partners = dict(pair for left, right in together for pair in zip(of_leg(left), of_leg(right), strict=True))
        for i in range(COUNT):
            if i in partners.values():
                continue
            column = np.zeros(COUNT)
            column[i] = 1.0
            if i in partners:
                column[[i, partners[i]]] = np.sqrt(0.5)
            columns.append(column)
        self.basis: Matrix = np.array(columns).T
        self.rows: Matrix = self.basis[:, self.basis[Y] == 0.0]

    @cached_property
    def odd(self) -> dict[str, Matrix]:
        """Left-minus-right directions (22, 4) of every pair that moves together."""
        return {pair: pair_difference(pair) for pair in self.pairs}

    def coordinates(self, unknowns: Vector) -> Vector:
        """(22,) -> (m,)."""
        return self.basis.T @ unknowns

    def unknowns(self, coordinates: Vector) -> Vector:
        """(m,) -> (22,)."""
        return self.basis @ coordinates

    def residual(self, residual: Vector) -> Vector:
        """The residuals that are left, (m - 1,)."""
        return self.rows.T @ residual

    def jacobian(self, jacobian: Matrix) -> Matrix:
        """Their Jacobian by the coordinates, (m - 1, m)."""
        return self.rows.T @ jacobian @ self.basis

    def odd_block(self, jacobian: Matrix, pair: str) -> Matrix:
        """The 4 x 4 block of a pair's left-right differences."""
        return self.odd[pair].T @ jacobian @ self.odd[pair]


@cache
def subspace(*pairs: str) -> Subspace:
    """The subspace in which these pairs (``hind``, ``front``) move together."""
    return Subspace(tuple(sorted(pairs)))
