"""The compiled pieces of a stride: one integration step, one event; each with its exact Jacobian.

One graph serves every order of events: contact and step length are arguments, and a stride is a chain of steps
(:mod:`slip.orbits.stride`). The method is the explicit Runge-Kutta of order 8 by Dormand and Prince (12 stages, its
tableau from SciPy). The lengths of the steps are chosen by its error estimate; the derivative is exact for the steps
taken.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray
from scipy.integrate import DOP853

from slip.model.equations import energy, legs, vector_field
from slip.model.unknowns import DPHI, SLIP_LEGS, STATE_NAMES

STATES = len(STATE_NAMES)
_OPTIONS = {"cse": True}


class Compiled:
    """A CasADi function of vectors that writes dense numpy results without copies.

    The result arrays belong to this object and are overwritten by the next call.
    """

    def __init__(self, name: str, arguments: list[ca.SX], results: list[ca.SX]) -> None:
        self._function = ca.Function(name, arguments, [ca.densify(result) for result in results], _OPTIONS)
        # kept: it owns what evaluate() works on; casadi's stub lacks the real signature of its methods
        self._buffer: Any
        self._buffer, self._evaluate = self._function.buffer()
        self._inputs = [np.zeros(argument.numel()) for argument in arguments]
        # CasADi stores by column
        self.results = [np.zeros(result.shape, order="F") for result in results]
        for i, array in enumerate(self._inputs):
            self._buffer.set_arg(i, array.data)
        for i, array in enumerate(self.results):
            self._buffer.set_res(i, array.ravel(order="K").data)

    def __call__(self, *arguments: NDArray[np.float64] | float) -> list[NDArray[np.float64]]:
        for array, value in zip(self._inputs, arguments, strict=True):
            array[:] = value
        self._evaluate()
        return self.results


def _symbols() -> tuple[ca.SX, ca.SX, ca.SX]:
    return ca.SX.sym("state", STATES), ca.SX.sym("contact", len(SLIP_LEGS)), ca.SX.sym("parameters", 7)


@cache
def step() -> Compiled:
    """One Runge-Kutta step and what its error estimate and its derivative need.

    (state (13,), contact (4,), parameters (7,), length [time]) -> state after it (13, 1); error estimates of order 5
    and 3 (13, 1) each (Hairer, Nørsett & Wanner 1993, II.10); rates at the stages (13, 12).
    """
    state, contact, parameters = _symbols()
    length = ca.SX.sym("length")
    field = ca.Function("field", [state, contact, parameters], [vector_field(state, contact, parameters)])
    stages = _stages(state, length, lambda at: field(at, contact, parameters))
    end = state + length * _combined(DOP853.B, stages)
    rates = [*stages, field(end, contact, parameters)]
    errors = [length * _combined(weights, rates) for weights in (DOP853.E5, DOP853.E3)]
    return Compiled("step", [state, contact, parameters, length], [end, *errors, ca.horzcat(*stages)])


@cache
def stage_jacobians() -> Compiled:
    """(state, contact, parameters, length) -> Jacobians of the rate at the stages of a step, (13, 13 * 12)."""
    state, contact, parameters = _symbols()
    length = ca.SX.sym("length")
    field = vector_field(state, contact, parameters)
    both = ca.Function("both", [state, contact, parameters], [field, ca.jacobian(field, state)], _OPTIONS)
    jacobians: list[ca.SX] = []

    def rate_at(at: ca.SX) -> ca.SX:
        rate, jacobian = both(at, contact, parameters)
        jacobians.append(jacobian)
        return rate

    _stages(state, length, rate_at)
    return Compiled("stage_jacobians", [state, contact, parameters, length], [ca.horzcat(*jacobians)])


def _stages(state: ca.SX, length: ca.SX, rate_at: Callable[[ca.SX], ca.SX]) -> list[ca.SX]:
    stages: list[ca.SX] = []
    for row in DOP853.A:
        stages.append(rate_at(state + length * _combined(row, stages)))
    return stages


def _combined(weights: NDArray[np.float64], stages: list[ca.SX]) -> ca.SX:
    total = ca.SX(0.0)
    for weight, stage in zip(weights, stages, strict=False):
        if weight != 0.0:
            total = total + float(weight) * stage
    return total


@cache
def rate() -> Compiled:
    """(state, contact, parameters) -> rate of the state, (13, 1)."""
    state, contact, parameters = _symbols()
    return Compiled("rate", [state, contact, parameters], [vector_field(state, contact, parameters)])


@cache
def event() -> Compiled:
    """What happens when a foot meets or leaves the ground, for all four legs at once.

    (state, parameters) -> foot heights (4, 1); their gradients (4, 13); the leg rates dalpha after the event (4, 1);
    their gradients (4, 13).
    """
    state, _, parameters = _symbols()
    heights = ca.vertcat(*(leg.foot_height_w for leg in legs(state, parameters)))
    rates = ca.vertcat(*(leg.stance_dtheta - state[DPHI] for leg in legs(state, parameters)))
    return Compiled(
        "event", [state, parameters], [heights, ca.jacobian(heights, state), rates, ca.jacobian(rates, state)]
    )


@cache
def energy_and_forces() -> Compiled:
    """(state, contact, parameters) -> energy (1, 1), force along each leg (4, 1), theta of each leg (4, 1)."""
    state, contact, parameters = _symbols()
    all_legs = legs(state, parameters)
    forces = ca.vertcat(*(contact[i] * leg.force for i, leg in enumerate(all_legs)))
    angles = ca.vertcat(*(leg.theta for leg in all_legs))
    return Compiled(
        "energy_and_forces", [state, contact, parameters], [energy(state, contact, parameters), forces, angles]
    )


@cache
def energy_gradient() -> Compiled:
    """(state, contact, parameters) -> gradient of the energy by the state, (1, 13)."""
    state, contact, parameters = _symbols()
    total = energy(state, contact, parameters)
    return Compiled("energy_gradient", [state, contact, parameters], [ca.jacobian(total, state)])
