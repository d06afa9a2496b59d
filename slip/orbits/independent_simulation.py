"""An independent check: slip.orbits.independent_body integrated by SciPy, with events detected or prescribed."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from slip.model.parameters import SlipParameters
from slip.model.unknowns import DY, EVENT_NAMES, EVENTS, PERIOD, STATES
from slip.orbits.independent_body import LEGS, Body
from slip.orbits.orbit import Orbit
from symdyn.errors import SymdynError

Vector = NDArray[np.float64]

RELATIVE_TOLERANCE = 1e-12
ABSOLUTE_TOLERANCE = 1e-13
_SIMULTANEOUS = 1e-9
"""Feet so near to the ground (or legs so near to their rest length) share the event of another."""
_SWINGS_BACK = 1e-9
_STEPS = (math.inf, 0.02)
"""Longest steps of the integrator to try in turn."""
_APEXES = 3
_AGREES = 1e-6
_LONGEST = 3.0
"""A simulated stride may last so many times as long as the orbit's before it counts as failed."""


@dataclass(frozen=True)
class SimulatedStride:
    """A stride as it happened.

    Attributes:
        touchdowns: time of the touchdown of each leg (order of SLIP_LEGS), (4,).
        liftoffs: time of its lift-off, (4,).
        period: time of the apex that ends the stride.
        distance: covered by the torso.
        state: at the end, the 13 states of slip.model.unknowns, (13,).
        energy_drift: largest change of the energy between events.
    """

    touchdowns: Vector
    liftoffs: Vector
    period: float
    distance: float
    state: Vector
    energy_drift: float


def simulate(
    state: Vector,
    standing: NDArray[np.bool_],
    parameters: SlipParameters,
    patience: float,
    apex: int = 1,
    longest_step: float = math.inf,
) -> SimulatedStride:
    """Run from an apex to one after every leg has touched down and lifted off.

    A swinging leg touches down when its foot comes down onto the ground while the leg swings back; on the way forward
    it may dip below (the legs are massless).

    Args:
        state: the 13 states of slip.model.unknowns at the apex, (13,).
        standing: which legs are on the ground there, (4,).
        parameters: of the model.
        patience: longest time to wait for the end.
        apex: the how manieth apex after that ends the stride; a torso may bob more than once.
        longest_step: of the integrator; a foot that dips into the ground for less than a step is overlooked.

    Raises:
        SymdynError: if the stride does not end in time, or the torso falls.
    """
    body = Body(parameters)
    s = body.start(state)
    for leg in LEGS:
        if standing[leg]:
            body.pin(s, leg)
    touchdowns, liftoffs = [math.nan] * len(body.hip), [math.nan] * len(body.hip)
    time, drift, energy = 0.0, 0.0, body.energy(s)
    forwards = math.copysign(1.0, s[1])
    while True:
        complete = not any(math.isnan(t) for t in (*touchdowns, *liftoffs))
        events, meanings = _events(body, forwards, complete)
        solution: Any = solve_ivp(
            body.rate,
            (time, patience),
            s,
            "DOP853",
            events=events,
            rtol=RELATIVE_TOLERANCE,
            atol=ABSOLUTE_TOLERANCE,
            max_step=longest_step,
        )
        drift = max(drift, *(abs(body.energy(column) - energy) for column in solution.y.T))
        if solution.status != 1:
            raise SymdynError(
                "The simulated stride did not end: no apex after all legs had touched down and lifted off."
            )
        which = next(i for i, times in enumerate(solution.t_events) if len(times))
        time, s = float(solution.t_events[which][0]), solution.y_events[which][0].copy()
        kind, leg = meanings[which]
        if kind == "apex":
            apex -= 1
            if apex == 0:
                break
            s[3] = -0.0
            continue
        if kind == "fall":
            raise SymdynError("The simulated torso fell.")
        for other in LEGS:
            if (kind, leg) == ("touchdown", other) or _meets_ground(body, s, other, forwards):
                body.pin(s, other)
                touchdowns[other] = time
            elif (kind, leg) == ("liftoff", other) or _leaves_ground(body, s, other):
                body.release(s, other)
                liftoffs[other] = time
    return SimulatedStride(np.array(touchdowns), np.array(liftoffs), time, float(s[0]), body.states(s), drift)


def _meets_ground(body: Body, s: Vector, leg: int, forwards: float) -> bool:
    """Whether a swinging leg touches down at this very moment, too."""
    if body.foot[leg] is not None or abs(body.foot_height(s, leg)) > _SIMULTANEOUS:
        return False
    dtheta = s[7 + 2 * leg] + s[5]
    sinking = body.hip_velocity(s, leg)[1] + body.length * math.sin(s[6 + 2 * leg] + s[4]) * dtheta < 0.0
    return sinking and forwards * dtheta <= _SWINGS_BACK


def _leaves_ground(body: Body, s: Vector, leg: int) -> bool:
    """Whether a standing leg lifts off at this very moment, too."""
    foot = body.foot[leg]
    if foot is None or abs(body.spring(s, leg)[0] - body.length) > _SIMULTANEOUS:
        return False
    (x, y), (vx, vy) = body.hip_position(s, leg), body.hip_velocity(s, leg)
    return y * vy - (foot - x) * vx > 0.0


def _events(
    body: Body, forwards: float, complete: bool
) -> tuple[list[Callable[[float, Vector], float]], list[tuple[str, int]]]:
    events: list[Any] = []
    meanings: list[tuple[str, int]] = []

    def add(function: Callable[[float, Vector], float], direction: float, kind: str, leg: int = -1) -> None:
        function.terminal, function.direction = True, direction  # type: ignore[attr-defined]
        events.append(function)
        meanings.append((kind, leg))

    for leg in LEGS:
        if body.foot[leg] is None:

            def height(_: float, s: Vector, leg: int = leg) -> float:
                value = body.foot_height(s, leg)
                swings_back = forwards * (s[7 + 2 * leg] + s[5]) <= _SWINGS_BACK
                # a foot that dips below the ground on its way forward is not there for the detection
                return value if swings_back or value > 0.0 else -value

            add(height, -1.0, "touchdown", leg)
        else:

            def stretch(_: float, s: Vector, leg: int = leg) -> float:
                return body.spring(s, leg)[0] - body.length

            add(stretch, 1.0, "liftoff", leg)
    if complete:

        def vertical_speed(_: float, s: Vector) -> float:
            return s[3]

        add(vertical_speed, -1.0, "apex")

    def torso_height(_: float, s: Vector) -> float:
        return s[2]

    add(torso_height, -1.0, "fall")
    return events, meanings


def disagreement(orbit: Orbit) -> float:
    """Largest difference between an orbit and its simulation over a stride: states, event times, period.

    NaN where the simulation does not come to an apex after the same events.
    """
    expected = np.mod(orbit.unknowns[EVENTS], orbit.unknowns[PERIOD])
    best = math.nan
    for longest_step in _STEPS:
        for apex in range(1, _APEXES + 1):
            patience = _LONGEST * orbit.period
            try:
                run = simulate(orbit.unknowns[STATES], orbit.standing, orbit.parameters, patience, apex, longest_step)
            except SymdynError:
                break
            found = np.stack((run.touchdowns, run.liftoffs), axis=1).ravel()
            states = np.abs(run.state - orbit.unknowns[STATES]).max()
            here = max(np.abs(found - expected).max(), states, abs(run.period - orbit.period))
            best = float(np.nanmin([best, here]))
            if best < _AGREES:
                return best
            if run.period > orbit.period:
                break
    return best


def residual_with_given_times(unknowns: Vector, parameters: SlipParameters) -> Vector:
    """:func:`slip.orbits.orbit.residual`, (22,), by the independent model: events at the times that the unknowns say.

    Args:
        unknowns: (22,), see slip.model.unknowns.
        parameters: of the model.
    """
    period = unknowns[PERIOD]
    times = np.mod(unknowns[EVENTS], period)
    body = Body(parameters)
    s = body.start(unknowns[STATES])
    for leg in LEGS:
        if times[2 * leg] > times[2 * leg + 1]:
            body.pin(s, leg)
    heights, now = np.zeros(len(times)), 0.0
    for event in (*np.argsort(times, kind="stable"), None):
        until = period if event is None else times[event]
        if until > now:
            solution: Any = solve_ivp(
                body.rate, (now, until), s, "DOP853", rtol=RELATIVE_TOLERANCE, atol=ABSOLUTE_TOLERANCE
            )
            s, now = solution.y[:, -1].copy(), until
        if event is None:
            break
        leg = int(event) // 2
        if body.foot[leg] is not None:
            s[6 + 2 * leg], s[7 + 2 * leg] = body.stance_angle(s, leg)
        heights[event] = body.foot_height(s, leg)
        if EVENT_NAMES[event].startswith("touchdown"):
            body.pin(s, leg)
        elif body.foot[leg] is not None:
            body.release(s, leg)
    end = body.states(s)
    return np.concatenate((end - unknowns[STATES], heights, [end[DY]]))
