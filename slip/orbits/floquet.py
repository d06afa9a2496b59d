"""Stability of an orbit: Floquet multipliers of the apex return map."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slip.model.unknowns import DY, EVENTS, PERIOD, STATES
from slip.orbits.orbit import Orbit
from slip.orbits.stride import EVENT_ROWS, PERIODICITY_ROWS, SECTION_ROW

Matrix = NDArray[np.float64]


def return_map(jacobian: Matrix) -> Matrix:
    """Derivative (13, 13) of the state at the next apex by the state at this one.

    The events and the apex happen when their conditions say, so their times follow from the initial state by the
    implicit function theorem.

    Args:
        jacobian: of the residual at an orbit, (22, 22).
    """
    times = [*range(EVENTS.start, EVENTS.stop), PERIOD]
    conditions = [*range(EVENT_ROWS.start, EVENT_ROWS.stop), SECTION_ROW]
    times_by_state = -np.linalg.solve(jacobian[np.ix_(conditions, times)], jacobian[conditions, STATES])
    end_by_state = jacobian[PERIODICITY_ROWS, STATES] + np.eye(STATES.stop)
    return end_by_state + jacobian[PERIODICITY_ROWS][:, times] @ times_by_state


def multipliers_of(orbit: Orbit, jacobian: Matrix) -> NDArray[np.complex128]:
    """Floquet multipliers within the section (dy = 0) and within the energy level, by falling magnitude, (11,).

    All inside the unit circle: asymptotically stable. All NaN where an event grazes.

    Args:
        orbit: to be judged.
        jacobian: of the residual at it, (22, 22).
    """
    section = [i for i in range(STATES.stop) if i != DY]
    try:
        derivative = return_map(jacobian)[np.ix_(section, section)]
    except np.linalg.LinAlgError:
        return np.full(len(section) - 1, np.nan, dtype=np.complex128)
    gradient = orbit.energy_gradient[section]
    # an orthonormal basis of the energy level: energy is conserved, so the gradient is a left eigenvector (of 1)
    level = np.linalg.svd(gradient[None])[2][1:].T
    values = np.linalg.eigvals(level.T @ derivative @ level)
    return values[np.argsort(-np.abs(values))].astype(np.complex128)


def multipliers(orbit: Orbit) -> NDArray[np.complex128]:
    """:func:`multipliers_of` an orbit, (11,)."""
    return multipliers_of(orbit, orbit.stride.jacobian)
