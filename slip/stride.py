"""One stride of the hybrid model, from apex to apex, with given event times: 22 unknowns to 22 residuals.

The event times are unknowns, not detected. They are wrapped into the stride, sorted, and the segments in between are
integrated with the contacts that the order of events implies; a leg whose touchdown comes after its lift-off begins
and ends the stride on the ground.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slip import kernel
from slip.integrate import Segment, integrate, step_derivatives
from slip.unknowns import COUNT, DALPHA, DY, EVENT_NAMES, EVENTS, LIFTOFF, PERIOD, SLIP_LEGS, STATES, TOUCHDOWN

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

_STATE_COUNT = STATES.stop
ROWS = _STATE_COUNT + len(EVENT_NAMES) + 1
PERIODICITY_ROWS = slice(0, _STATE_COUNT)
EVENT_ROWS = slice(_STATE_COUNT, _STATE_COUNT + len(EVENT_NAMES))
SECTION_ROW = ROWS - 1


@dataclass(frozen=True)
class Stride:
    """A stride, integrated.

    Attributes:
        residual: (22,): end minus start of the 13 states; foot height at touchdown and lift-off of each leg, in the
            order of the unknowns; vertical speed at the end.
        jacobian: of the residual by the unknowns, (22, 22), or None.
        bounds: time of the start, the events in order, and the end, (10,).
        events: what happens at ``bounds[1:-1]``: positions in ``EVENT_NAMES``, (8,).
        contacts: of each leg in each segment, (9, 4), 0 or 1.
        segments: the nine segments.
    """

    residual: Vector
    jacobian: Matrix | None
    bounds: Vector
    events: NDArray[np.int64]
    contacts: Matrix
    segments: tuple[Segment, ...]


def integrate_stride(unknowns: Vector, parameters: Vector, derivative: bool = True) -> Stride:
    """Integrate one stride.

    Args:
        unknowns: (22,), see slip.unknowns.
        parameters: (7,), the fields of SlipParameters.
        derivative: whether the Jacobian is wanted.

    Raises:
        slip.integrate.IntegrationFailure: if the state leaves the model's domain.
    """
    period = unknowns[PERIOD]
    turns = np.floor(unknowns[EVENTS] / period)
    times = np.clip(unknowns[EVENTS] - turns * period, 0.0, period)
    order = np.argsort(times, kind="stable")
    bounds = np.concatenate(([0.0], times[order], [period]))
    durations = np.diff(bounds)
    contacts = _contacts(times, order)

    state = unknowns[STATES].copy()
    residual = np.zeros(ROWS)
    segments: list[Segment] = []
    gradients: list[tuple[Vector, Vector]] = []
    for i, event in enumerate(order):
        segments.append(integrate(state, contacts[i], parameters, durations[i]))
        leg = event // 2
        heights, height_gradients, rates, rate_gradients = kernel.event()(segments[-1].end, parameters)
        residual[EVENT_ROWS.start + event] = heights[leg, 0]
        state = segments[-1].end.copy()
        state[DALPHA[leg]] = rates[leg, 0]
        gradients.append((height_gradients[leg].copy(), rate_gradients[leg].copy()))
    segments.append(integrate(state, contacts[-1], parameters, durations[-1]))
    residual[PERIODICITY_ROWS] = segments[-1].end - unknowns[STATES]
    residual[SECTION_ROW] = segments[-1].end[DY]

    jacobian = None
    if derivative:
        jacobian = _jacobian(segments, contacts, durations, order, turns, gradients, parameters)
    return Stride(residual, jacobian, bounds, order, contacts, tuple(segments))


def _contacts(times: Vector, order: NDArray[np.int64]) -> Matrix:
    """Contacts (9, 4) by the order of events alone, so that simultaneous events have the right one-sided derivative."""
    touchdowns, liftoffs = times[0::2], times[1::2]
    contact = (touchdowns > liftoffs).astype(np.float64)
    contacts = [contact]
    for event in order:
        contact = contact.copy()
        contact[event // 2] = 1.0 - event % 2
        contacts.append(contact)
    return np.array(contacts)


def _jacobian(
    segments: list[Segment],
    contacts: Matrix,
    durations: Vector,
    order: NDArray[np.int64],
    turns: Vector,
    gradients: list[tuple[Vector, Vector]],
    parameters: Vector,
) -> Matrix:
    by_time = np.zeros((len(durations) + 1, COUNT))  # gradient of every bound
    for i, event in enumerate(order):
        by_time[i + 1, EVENTS.start + event] = 1.0
        by_time[i + 1, PERIOD] = -turns[event]
    by_time[-1, PERIOD] = 1.0
    by_duration = np.diff(by_time, axis=0)

    derivatives = step_derivatives(segments, contacts, durations, parameters)
    sensitivity = np.eye(_STATE_COUNT, COUNT)
    jacobian = np.zeros((ROWS, COUNT))
    step = 0
    for i, segment in enumerate(segments):
        for fraction in segment.fractions:
            by_state, by_length = derivatives[step, :, :-1], derivatives[step, :, -1]
            sensitivity = by_state @ sensitivity + np.outer(by_length, fraction * by_duration[i])
            step += 1
        if i < len(order):
            height_gradient, rate_gradient = gradients[i]
            jacobian[EVENT_ROWS.start + order[i]] = height_gradient @ sensitivity
            sensitivity[DALPHA[order[i] // 2]] = rate_gradient @ sensitivity
    jacobian[PERIODICITY_ROWS] = sensitivity - np.eye(_STATE_COUNT, COUNT)
    jacobian[SECTION_ROW] = sensitivity[DY]
    return jacobian


assert all(TOUCHDOWN[i] - EVENTS.start == 2 * i and LIFTOFF[i] == TOUCHDOWN[i] + 1 for i in range(len(SLIP_LEGS)))
