"""Least squares whose intervals hold when neighbouring errors are alike, as those of smoothed signals are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as student

Floats = NDArray[np.float64]

CONFIDENCE = 0.95


@dataclass(frozen=True, eq=False)
class Estimate:
    """Parameters and how well they are known.

    Attributes:
        value: (P,).
        covariance: (P, P).
        blocks: independent pieces of data that stand behind it.
    """

    value: Floats
    covariance: Floats
    blocks: int

    def half_width(self, gradient: Floats) -> float:
        """Of the 95% interval of a function of the parameters whose gradient is (P,)."""
        variance = float(gradient @ self.covariance @ gradient)
        freedom = max(self.blocks - len(self.value), 1)
        return float(student.ppf(0.5 + CONFIDENCE / 2.0, freedom)) * float(np.sqrt(max(variance, 0.0)))


def block_covariance(jacobian: Floats, residual: Floats, block: NDArray[np.intp]) -> tuple[Floats, int]:
    """Covariance of least-squares parameters from scores summed over blocks of data (cluster-robust; White 1984,
    Cameron and Miller 2015), which assumes errors of different blocks independent, and nothing within one.

    Args:
        jacobian: (N, P) of the model.
        residual: (N,).
        block: (N,) which block each row belongs to.

    Returns:
        (P, P), and the number of blocks.
    """
    names, places = np.unique(block, return_inverse=True)
    scores = np.zeros((len(names), jacobian.shape[1]))
    np.add.at(scores, places, jacobian * residual[:, None])
    bread = np.linalg.pinv(jacobian.T @ jacobian, rcond=1e-12)
    n = len(names)
    return bread @ (scores.T @ scores) @ bread * n / max(n - 1, 1), n
