"""One stride of the hybrid model, from apex to apex, with given event times: 22 unknowns to 22 residuals.

The event times are unknowns, not detected. They are wrapped into the stride, sorted, and the segments in between are
integrated with the contacts that the order of events implies; a leg whose touchdown comes after its lift-off begins
and ends the stride on the ground.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from slip.model.unknowns import COUNT, DALPHA, DY, EVENT_NAMES, EVENTS, LIFTOFF, PERIOD, SLIP_LEGS, STATES, TOUCHDOWN
from slip.orbits import kernel
from slip.orbits.integrate import Segment, integrate, step_derivatives

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

_STATE_COUNT = STATES.stop
ROWS = _STATE_COUNT + len(EVENT_NAMES) + 1
PERIODICITY_ROWS = slice(0, _STATE_COUNT)
EVENT_ROWS = slice(_STATE_COUNT, _STATE_COUNT + len(EVENT_NAMES))
SECTION_ROW = ROWS - 1


@dataclass(frozen=True, eq=False)
class Stride:
    """A stride, integrated.

    Attributes:
        parameters: of the model, (7,).
        residual: (22,): end minus start of the 13 states; foot height at touchdown and lift-off of each leg, in the
            order of the unknowns; vertical speed at the end.
        bounds: time of the start, the events in order, and the end, (10,).
        events: what happens at ``bounds[1:-1]``: positions in ``EVENT_NAMES``, (8,).
        turns: stride periods subtracted from each event time to bring it into the stride, in the order of
            ``EVENT_NAMES``, (8,).
        contacts: of each leg in each segment, (9, 4), 0 or 1.
        segments: the nine segments.
    """

    parameters: Vector
    residual: Vector
    bounds: Vector
    events: NDArray[np.int64]
    turns: Vector
    contacts: Matrix
    segments: tuple[Segment, ...]

    @cached_property
    def jacobian(self) -> Matrix:
        """Exact Jacobian of the residual by the unknowns, (22, 22)."""
        by_time = np.zeros((len(self.bounds), COUNT))  # gradient of every bound
        for i, event in enumerate(self.events):
            by_time[i + 1, EVENTS.start + event] = 1.0
            by_time[i + 1, PERIOD] = -self.turns[event]
        by_time[-1, PERIOD] = 1.0
        by_duration = np.diff(by_time, axis=0)

        derivatives = step_derivatives(self.segments, self.contacts, np.diff(self.bounds), self.parameters)
        sensitivity = np.eye(_STATE_COUNT, COUNT)
        jacobian = np.zeros((ROWS, COUNT))
        step = 0
        for i, segment in enumerate(self.segments):
            for fraction in segment.fractions:
                by_state, by_length = derivatives[step, :, :-1], derivatives[step, :, -1]
                sensitivity = by_state @ sensitivity + by_length[:, None] * (fraction * by_duration[i])
                step += 1
            if i < len(self.events):
                event, leg = self.events[i], self.events[i] // 2
                _, height_gradients, _, rate_gradients = kernel.event()(segment.end, self.parameters)
                jacobian[EVENT_ROWS.start + event] = height_gradients[leg] @ sensitivity
                sensitivity[DALPHA[leg]] = rate_gradients[leg] @ sensitivity
        jacobian[PERIODICITY_ROWS] = sensitivity - np.eye(_STATE_COUNT, COUNT)
        jacobian[SECTION_ROW] = sensitivity[DY]
        return jacobian


def turns_of(unknowns: Vector) -> Vector:
    """Stride periods to subtract from each event time to bring it into [0, T), (8,)."""
    return np.floor(unknowns[EVENTS] / unknowns[PERIOD])


def integrate_stride(unknowns: Vector, parameters: Vector, turns: Vector | None = None) -> Stride:
    """Integrate one stride.

    Args:
        unknowns: (22,), see slip.model.unknowns.
        parameters: (7,), the fields of SlipParameters.
        turns: stride periods to subtract from each event time, (8,); those of :func:`turns_of` if None. With others an
            event may lie outside the stride, which is then integrated to it and back: the residual goes on smoothly
            where an event crosses the apex, at which the unknowns dalpha have a kink.

    Raises:
        slip.orbits.integrate.IntegrationFailure: if the state leaves the model's domain.
    """
    period = unknowns[PERIOD]
    turns = turns_of(unknowns) if turns is None else turns
    times = unknowns[EVENTS] - turns * period
    order = np.argsort(times, kind="stable")
    bounds = np.concatenate(([0.0], times[order], [period]))
    durations = np.diff(bounds)
    contacts = _contacts(times, order)

    state = unknowns[STATES].copy()
    residual = np.zeros(ROWS)
    segments: list[Segment] = []
    for i, event in enumerate(order):
        segments.append(integrate(state, contacts[i], parameters, durations[i]))
        leg = event // 2
        heights, _, rates, _ = kernel.event()(segments[-1].end, parameters)
        residual[EVENT_ROWS.start + event] = heights[leg, 0]
        state = segments[-1].end.copy()
        state[DALPHA[leg]] = rates[leg, 0]
    segments.append(integrate(state, contacts[-1], parameters, durations[-1]))
    residual[PERIODICITY_ROWS] = segments[-1].end - unknowns[STATES]
    residual[SECTION_ROW] = segments[-1].end[DY]
    return Stride(parameters, residual, bounds, order, turns, contacts, tuple(segments))


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


assert all(TOUCHDOWN[i] - EVENTS.start == 2 * i and LIFTOFF[i] == TOUCHDOWN[i] + 1 for i in range(len(SLIP_LEGS)))
