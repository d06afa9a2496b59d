"""A periodic gait of the SLIP, and what one reads off it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from slip.model.parameters import SlipParameters
from slip.model.unknowns import (
    DPHI,
    DX,
    LIFTOFF,
    PERIOD,
    SLIP_LEGS,
    STATES,
    TOUCHDOWN,
    UNKNOWN_NAMES,
    checked,
)
from slip.orbits import kernel
from slip.orbits.integrate import IntegrationFailure
from slip.orbits.stride import Stride, integrate_stride
from symdyn.errors import SymdynError
from symdyn.gait.library import Gait
from symdyn.robot.legs import LEGS, permutation

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

TO_LEGS = permutation(SLIP_LEGS, LEGS)
"""``array[..., TO_LEGS]`` puts an array over the model's legs in the order of symdyn.robot.legs.LEGS."""


def residual(unknowns: Vector, parameters: Vector | SlipParameters) -> Vector:
    """How far a stride is from a periodic gait.

    Args:
        unknowns: (22,): dx, y, dy, phi, dphi at the apex; alpha, dalpha of LH, LF, RH, RF; touchdown, lift-off of LH,
            LF, RH, RF; stride period T. See slip.model.unknowns for names, slip.model.equations for units.
        parameters: (7,): k, ks, J, l, resting swing angle, lb, kr, or SlipParameters.

    Returns:
        (22,): end minus start of the 13 states (periodicity); foot height at touchdown and lift-off of each leg, in the
        order of the unknowns; vertical speed at the end (the section). Zero for a periodic gait.

    Raises:
        InvalidValue: for a wrong shape, numbers that are not finite, or a period or parameter out of range.
        SymdynError: if the motion leaves the model's domain (a leg lies flat).
    """
    known = parameters if isinstance(parameters, SlipParameters) else SlipParameters.from_vector(parameters)
    try:
        return integrate_stride(checked(unknowns), known.vector()).residual
    except IntegrationFailure as failure:
        raise SymdynError(f"The stride cannot be integrated: {failure}.") from None


def jacobian(unknowns: Vector, parameters: Vector | SlipParameters) -> Matrix:
    """Exact Jacobian (22, 22) of :func:`residual` by the unknowns; arguments and errors are the same."""
    known = parameters if isinstance(parameters, SlipParameters) else SlipParameters.from_vector(parameters)
    try:
        return integrate_stride(checked(unknowns), known.vector()).jacobian
    except IntegrationFailure as failure:
        raise SymdynError(f"The stride cannot be integrated: {failure}.") from None


@dataclass(frozen=True, eq=False)
class Orbit:
    """A periodic gait: a solution of :func:`residual` = 0.

    Build it with :func:`slip.families.solve.solve_orbit` or take it from a branch of
    :func:`slip.families.explore.explore`; the constructor itself does not check that the residual vanishes
    (``residual_norm`` tells).

    Attributes:
        unknowns: (22,).
        parameters: of the model.
    """

    unknowns: Vector
    parameters: SlipParameters

    def __post_init__(self) -> None:
        checked(self.unknowns)

    @cached_property
    def stride(self) -> Stride:
        """The integrated stride, with its Jacobian."""
        return integrate_stride(self.unknowns, self.parameters.vector())

    def value(self, name: str) -> float:
        """An unknown by its name in slip.model.unknowns.UNKNOWN_NAMES."""
        return float(self.unknowns[UNKNOWN_NAMES.index(name)])

    @property
    def residual_norm(self) -> float:
        """Largest of the 22 residuals."""
        return float(np.abs(self.stride.residual).max())

    @property
    def apex_speed(self) -> float:
        """Forward speed at the apex [sqrt(g torso length)]."""
        return float(self.unknowns[DX])

    @property
    def pitch_rate(self) -> float:
        """dphi at the apex [sqrt(g / torso length)]."""
        return float(self.unknowns[DPHI])

    @property
    def period(self) -> float:
        """Stride period T [sqrt(torso length / g)]."""
        return float(self.unknowns[PERIOD])

    @cached_property
    def step_distances(self) -> Vector:
        """Distance covered in every integration step of the stride, in order [torso length]."""
        # the trapezoidal rule with its end correction (Euler-Maclaurin), of order 4
        vector, distances = self.parameters.vector(), []
        for i, segment in enumerate(self.stride.segments):
            lengths = segment.fractions * (self.stride.bounds[i + 1] - self.stride.bounds[i])
            speeds = np.append(segment.starts[:, DX], segment.end[DX])
            (last,) = kernel.rate()(segment.end, self.stride.contacts[i], vector)
            rates = np.append(segment.rates[:, 0, DX], last[DX, 0])
            distances.append(0.5 * lengths * (speeds[:-1] + speeds[1:]) + lengths**2 / 12.0 * (rates[:-1] - rates[1:]))
        return np.concatenate(distances)

    @property
    def stride_length(self) -> float:
        """Distance covered in a stride [torso length]."""
        return float(self.step_distances.sum())

    @property
    def mean_speed(self) -> float:
        """Stride length over stride period [sqrt(g torso length)]."""
        return self.stride_length / self.period

    @property
    def touchdowns(self) -> Vector:
        """Time of touchdown of each leg within [0, T), legs in the order of symdyn.robot.legs.LEGS; (4,)."""
        return np.mod(self.unknowns[list(TOUCHDOWN)], self.period)[list(TO_LEGS)]

    @property
    def liftoffs(self) -> Vector:
        """Time of lift-off of each leg within [0, T), legs in the order of symdyn.robot.legs.LEGS; (4,)."""
        return np.mod(self.unknowns[list(LIFTOFF)], self.period)[list(TO_LEGS)]

    @property
    def duty_factors(self) -> Vector:
        """Share of the stride that each leg stands, legs in the order of symdyn.robot.legs.LEGS; (4,)."""
        return np.mod(self.liftoffs - self.touchdowns, self.period) / self.period

    @property
    def duty_factor(self) -> float:
        """Mean over the legs."""
        return float(self.duty_factors.mean())

    def gait(self, name: str = "orbit") -> Gait:
        """The footfall as a gait of symdyn: a leg that touches down later by a delay d has the offset -d."""
        delays = (self.touchdowns - self.touchdowns[0]) / self.period
        # a difference of rounding errors must not become an offset of almost one
        return Gait.wrapped(name, -np.round(delays, 12))

    @property
    def standing(self) -> NDArray[np.bool_]:
        """Which legs are on the ground at the apex, in the order of SLIP_LEGS; (4,)."""
        times = np.mod(self.unknowns, self.period)
        return times[list(TOUCHDOWN)] > times[list(LIFTOFF)]

    @cached_property
    def energy(self) -> float:
        """Total energy [M g torso length]."""
        contact = self.standing.astype(np.float64)
        value, _, _ = kernel.energy_and_forces()(self.unknowns[STATES], contact, self.parameters.vector())
        return float(value[0, 0])

    @cached_property
    def energy_gradient(self) -> Vector:
        """Derivative of the energy by the 13 states, at the apex; (13,)."""
        contact = self.standing.astype(np.float64)
        return kernel.energy_gradient()(self.unknowns[STATES], contact, self.parameters.vector())[0][0].copy()

    @cached_property
    def energy_drift(self) -> float:
        """Largest change of the energy along the stride, at the ends of all integration steps."""
        evaluate, vector, worst = kernel.energy_and_forces(), self.parameters.vector(), 0.0
        for segment, contact in zip(self.stride.segments, self.stride.contacts, strict=True):
            for state in (*segment.starts, segment.end):
                value, _, _ = evaluate(state, contact, vector)
                worst = max(worst, abs(float(value[0, 0]) - self.energy))
        return worst

    @cached_property
    def least_force(self) -> float:
        """Smallest force of a leg on the ground [M g]: negative where it would have to pull."""
        evaluate, vector, least = kernel.energy_and_forces(), self.parameters.vector(), np.inf
        durations = np.diff(self.stride.bounds)
        for segment, contact, duration in zip(self.stride.segments, self.stride.contacts, durations, strict=True):
            on_ground = contact > 0.0
            if duration == 0.0 or not on_ground.any():
                continue
            for state in (*segment.starts, segment.end):
                _, forces, _ = evaluate(state, contact, vector)
                least = min(least, float(forces[on_ground, 0].min()))
        return least
