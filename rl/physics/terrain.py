"""Uneven ground: a height field whose bumps are wide enough to step on and too high to ignore."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import RectBivariateSpline
from scipy.ndimage import maximum_filter

from symdyn.errors import InvalidValue


@dataclass(frozen=True)
class Terrain:
    """A square of random ground about the origin, in z from -amplitude to amplitude; nothing lies beyond it.

    Heights are drawn uniformly and independently at points ``bump`` apart, joined by a cubic spline, and scaled so that
    lowest and highest point of the square are -amplitude and amplitude.

    Attributes:
        amplitude: m.
        bump: distance between the points of independent height, m.
        cell: distance between the grid points of the height field, m; at most half a bump.
        half_size: half the side of the square, m; a multiple of ``bump``.
        seed: of the heights.

    Raises:
        InvalidValue: for a length out of range.
    """

    amplitude: float = 0.04
    bump: float = 0.25
    cell: float = 0.05
    half_size: float = 20.0
    seed: int = 0

    def __post_init__(self) -> None:
        for name in ("amplitude", "bump", "cell", "half_size"):
            if not 0.0 < getattr(self, name) < math.inf:
                raise InvalidValue(f"terrain.{name}", getattr(self, name), "a number of metres > 0")
        if self.cell > self.bump / 2.0:
            raise InvalidValue("terrain.cell", self.cell, f"at most half of bump, {self.bump / 2.0:g} m")
        if self.half_size < 4.0 * self.bump:
            raise InvalidValue("terrain.half_size", self.half_size, f"at least four bumps, {4.0 * self.bump:g} m")

    @cached_property
    def axis(self) -> NDArray[np.float64]:
        """Coordinates of the grid points along x, and along y, m."""
        return np.linspace(-self.half_size, self.half_size, round(2.0 * self.half_size / self.cell) + 1)

    @cached_property
    def heights(self) -> NDArray[np.float64]:
        """Height of every grid point, m; a row for each y, a column for each x, as MuJoCo has it."""
        n = round(2.0 * self.half_size / self.bump) + 1
        coarse = np.linspace(-self.half_size, self.half_size, n)
        drawn = np.random.default_rng(self.seed).uniform(-1.0, 1.0, (n, n))
        fine = RectBivariateSpline(coarse, coarse, drawn)(self.axis, self.axis)
        return self.amplitude * (2.0 * (fine - fine.min()) / np.ptp(fine) - 1.0)

    def height(self, position: NDArray[np.float64]) -> NDArray[np.float64]:
        """Height of the ground, m; that of the nearest grid point.

        Args:
            position: (..., 2) x and y, m.

        Returns:
            (...,) m; for a position outside of the square that of its edge.
        """
        return _at(self.heights, position, self.half_size)

    def highest_near(self, position: NDArray[np.float64], reach: float) -> NDArray[np.float64]:
        """The highest point of the ground within ``reach`` m along x and y of each position, (..., 2) -> (...,) m."""
        return _at(maximum_filter(self.heights, 2 * math.ceil(reach / self.cell) + 1), position, self.half_size)


def _at(values: NDArray[np.float64], position: NDArray[np.float64], half_size: float) -> NDArray[np.float64]:
    last = len(values) - 1
    cell = np.clip(np.rint((position + half_size) / (2.0 * half_size) * last).astype(np.intp), 0, last)
    return values[cell[..., 1], cell[..., 0]]
