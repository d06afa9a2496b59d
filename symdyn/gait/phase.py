"""The clock: stride phase, leg phases, and which legs should be in swing.

Written against the array API, so that numpy arrays (analysis, robot) and torch tensors (training) go through the same
lines. Phases are fractions of a stride in [0, 1).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from array_api_compat import array_namespace

from symdyn.arrays import Array

_SHORTEST_SWING = 1e-9
"""Share of a stride; what takes its place as a divisor when a robot stands."""


def wrapped(x: Array) -> Array:
    """A phase on the circle: x mod 1, in [0, 1). Same shape.

    x - floor(x) alone is 1.0 for a negative number so small that the difference rounds up.
    """
    turned = x - array_namespace(x).floor(x)
    return turned * (turned < 1.0)


def advance(phase: Array, period: Array, dt: Array | float) -> Array:
    """Integrate the stride phase over ``dt``: ``phi + dt / T``, wrapped.

    Integrated and never computed as ``t / T``: T changes with the command, and the clock must not jump with it.

    Args:
        phase: (...,) stride phase in [0, 1).
        period: (...,) stride period, s.
        dt: s, one for all or (...,); the clock of a robot that stands is given 0.

    Returns:
        (...,) in [0, 1).
    """
    return wrapped(phase + dt / period)


def leg_phase(phase: Array, offsets: Array, velocity_x: Array, time_reversal: bool = True) -> Array:
    """Phase of each leg, eq. (7) of the paper.

    ``(phi + theta_i) mod 1`` for a commanded forward velocity >= 0; ``-(phi + theta_i) mod 1`` for one < 0, so that
    each leg runs through its cycle in the opposite sense when the robot runs backwards.

    Args:
        phase: (...,) stride phase.
        offsets: (..., 4) theta.
        velocity_x: (...,) commanded forward velocity, m/s; only its sign counts.
        time_reversal: False switches the map off (an ablation of the paper).

    Returns:
        (..., 4) in [0, 1).
    """
    xp = array_namespace(phase, offsets, velocity_x)
    forward = phase[..., None] + offsets
    if time_reversal:
        forward = xp.where((velocity_x < 0)[..., None], -forward, forward)
    return wrapped(forward)


def in_swing(leg_phases: Array, duty: Array) -> Array:
    """Whether a leg should be in swing: phase in [0, 1 - beta); stance is [1 - beta, 1).

    Args:
        leg_phases: (..., 4).
        duty: (...,) duty factor beta.

    Returns:
        (..., 4) bool.
    """
    return leg_phases < (1.0 - duty)[..., None]


def swing_progress(leg_phases: Array, duty: Array) -> Array:
    """How far a leg is through its swing, clip(phi_i / (1 - beta), 0, 1): s_i of the paper. (..., 4).

    For a duty factor of 1 there is no swing, and the result is 1 (0 at phase 0).
    """
    xp = array_namespace(leg_phases, duty)
    return xp.clip(leg_phases / xp.clip(1.0 - duty, _SHORTEST_SWING, None)[..., None], 0.0, 1.0)


def touchdown_phase(duty: Array, velocity_x: Array, time_reversal: bool = True) -> Array:
    """Leg phase at which swing should end: 1 - beta forwards; 0 when the leg phase runs backwards. (...,)."""
    xp = array_namespace(duty, velocity_x)
    forward = 1.0 - duty
    if not time_reversal:
        return forward
    return xp.where(velocity_x < 0, xp.zeros_like(forward), forward)


@dataclass(frozen=True)
class SwingExpectation:
    """Expected swing indicator when the events of the cycle jitter by a von Mises law (Siekmann et al. 2021).

    With a jitter ``e ~ vonMises(0, kappa)`` (as an angle; e / 2 pi of a stride) that moves both events
    together,

        E[I_swing(phi)] = P(0 <= phi - e < 1 - beta) = F(phi) - F(phi - (1 - beta)),

    where F is the von Mises cumulative distribution, continued over the circle by F(x + 1) = F(x) + 1. Siekmann draws
    the two events independently; sharing one draw keeps E[I_swing] + E[I_stance] = 1 and the mean over a stride equal
    to 1 - beta, exactly. At kappa 16 the two differ by less than 2e-6 where swing and stance exceed a quarter stride,
    and by less than 1e-8 from a third on.

    F has no closed form. It is tabulated once from its Fourier series,
    F(x) = x + sum_n I_n(kappa) / I_0(kappa) sin(2 pi n x) / (pi n), and interpolated linearly.

    Attributes:
        table: F(x) - x at ``size`` equal steps of [0, 1], both ends included; an array of the namespace that will be
            used.
    """

    table: Array

    @classmethod
    def of(cls, kappa: float, like: Array, size: int = 8192) -> SwingExpectation:
        """Tabulate for one concentration.

        Args:
            kappa: concentration of the jitter as an angle; its standard deviation is about 1 / sqrt(kappa) rad.
            like: an array whose namespace, device and precision the table takes.
            size: number of cells; the error is below 1.3 kappa / size**2 (and float32 rounding).
        """

        from scipy.special import ive  # half a second, which `symdyn deploy --help` need not take

        x = np.linspace(0.0, 1.0, size + 1)
        periodic = np.zeros_like(x)
        n = 1
        while (ratio := ive(n, kappa) / ive(0, kappa)) > 1e-17:
            periodic += ratio * np.sin(2.0 * np.pi * n * x) / (np.pi * n)
            n += 1
        xp = array_namespace(like)
        kwargs = {"dtype": like.dtype}
        if hasattr(like, "device"):
            kwargs["device"] = like.device
        return cls(xp.asarray(periodic, **kwargs))

    def cumulative(self, x: Array) -> Array:
        """F(x) for any real x; same shape."""
        xp = array_namespace(x, self.table)
        cells = self.table.shape[0] - 1
        position = (x - xp.floor(x)) * cells
        cell = xp.clip(xp.floor(position), 0, cells - 1)
        index = xp.astype(cell, xp.int64)
        flat = xp.reshape(index, (-1,))
        low = xp.reshape(xp.take(self.table, flat, axis=0), index.shape)
        high = xp.reshape(xp.take(self.table, flat + 1, axis=0), index.shape)
        return x + low + (position - cell) * (high - low)

    def __call__(self, leg_phases: Array, duty: Array) -> Array:
        """E[I_swing]; E[I_stance] is one minus it.

        Args:
            leg_phases: (..., 4).
            duty: (...,).

        Returns:
            (..., 4) in [0, 1].
        """
        return self.cumulative(leg_phases) - self.cumulative(leg_phases - (1.0 - duty)[..., None])
