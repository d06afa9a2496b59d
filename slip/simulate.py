"""An independent check: the model integrated forward in time, with events detected instead of prescribed.

Nothing here is shared with slip.equations. A standing leg is a spring between the hip and a fixed point on the ground;
a swinging leg is a pendulum in the frame of its accelerating hip; the integrator is SciPy's adaptive DOP853.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from slip.orbit import Orbit
from slip.parameters import SlipParameters
from slip.unknowns import ALPHA, DALPHA, DPHI, DX, DY, EVENTS, FRONT, PERIOD, PHI, SLIP_LEGS, STATES, Y
from symdyn.errors import SymdynError

Vector = NDArray[np.float64]

RELATIVE_TOLERANCE = 1e-12
ABSOLUTE_TOLERANCE = 1e-13
_LEGS = range(len(SLIP_LEGS))
_SIMULTANEOUS = 1e-9
"""Feet so near to the ground (or legs so near to their rest length) share the event of another."""
_SWINGS_BACK = 1e-9
_LONGEST_STEP = 0.02
"""Of the integrator, so that a foot that dips into the ground for a moment is not overlooked."""
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
        state: at the end, the 13 states of slip.unknowns, (13,).
        energy_drift: largest change of the energy between events.
    """

    touchdowns: Vector
    liftoffs: Vector
    period: float
    distance: float
    state: Vector
    energy_drift: float


class _Body:
    """Forces and accelerations at a state [x, dx, y, dy, phi, dphi, (alpha, dalpha) of the swinging legs]."""

    def __init__(self, parameters: SlipParameters) -> None:
        p = parameters
        self.hip = [(1.0 if i in FRONT else 0.0) - p.hind_distance for i in _LEGS]
        self.stiffness = [p.front_stiffness if i in FRONT else p.hind_stiffness for i in _LEGS]
        self.length, self.inertia = p.rest_length, p.pitch_inertia
        self.swing_stiffness, self.resting_angle = p.swing_stiffness, p.resting_angle
        self.foot: list[float | None] = [None] * len(self.hip)
        """Where each standing foot is; None for a swinging leg."""

    def hip_position(self, s: Vector, leg: int) -> tuple[float, float]:
        h = self.hip[leg]
        return s[0] + h * math.cos(s[4]), s[2] + h * math.sin(s[4])

    def hip_velocity(self, s: Vector, leg: int) -> tuple[float, float]:
        h = self.hip[leg]
        return s[1] - h * math.sin(s[4]) * s[5], s[3] + h * math.cos(s[4]) * s[5]

    def spring(self, s: Vector, leg: int) -> tuple[float, float, float]:
        """Length of a standing leg and the force that it puts on its hip."""
        x, y = self.hip_position(s, leg)
        foot = self.foot[leg]
        assert foot is not None
        length = math.hypot(foot - x, y)
        force = self.stiffness[leg] * (self.length - length)
        return length, -force * (foot - x) / length, force * y / length

    def rate(self, _: float, s: Vector) -> list[float]:
        fx = fy = torque = 0.0
        sin, cos = math.sin(s[4]), math.cos(s[4])
        for leg in _LEGS:
            if self.foot[leg] is not None:
                _length, x, y = self.spring(s, leg)
                fx, fy = fx + x, fy + y
                torque += self.hip[leg] * (cos * y - sin * x)
        ddx, ddy, ddphi = fx, fy - 1.0, torque / self.inertia
        result = [s[1], ddx, s[3], ddy, s[5], ddphi]
        for leg in _LEGS:
            if self.foot[leg] is not None:
                result += [0.0, 0.0]
                continue
            h, alpha, dalpha = self.hip[leg], s[6 + 2 * leg], s[7 + 2 * leg]
            ax = ddx - h * (sin * ddphi + cos * s[5] ** 2)
            ay = ddy + h * (cos * ddphi - sin * s[5] ** 2)
            theta = alpha + s[4]
            pendulum = -(ax * math.cos(theta) + (ay + 1.0) * math.sin(theta)) / self.length
            spring = -self.swing_stiffness * (alpha - self.resting_angle) / self.length**2
            result += [dalpha, pendulum + spring - ddphi]
        return result

    def energy(self, s: Vector) -> float:
        total = 0.5 * (s[1] ** 2 + s[3] ** 2 + self.inertia * s[5] ** 2) + s[2]
        for leg in _LEGS:
            if self.foot[leg] is not None:
                total += 0.5 * self.stiffness[leg] * (self.length - self.spring(s, leg)[0]) ** 2
        return total

    def foot_height(self, s: Vector, leg: int) -> float:
        return self.hip_position(s, leg)[1] - self.length * math.cos(s[6 + 2 * leg] + s[4])

    def stance_angle(self, s: Vector, leg: int) -> tuple[float, float]:
        """alpha and dalpha of a standing leg."""
        x, y = self.hip_position(s, leg)
        vx, vy = self.hip_velocity(s, leg)
        foot = self.foot[leg]
        assert foot is not None
        ahead = foot - x
        return math.atan2(ahead, y) - s[4], (-vx * y - ahead * vy) / (ahead**2 + y**2) - s[5]


def simulate(
    state: Vector, standing: NDArray[np.bool_], parameters: SlipParameters, patience: float, apex: int = 1
) -> SimulatedStride:
    """Run from an apex to one after every leg has touched down and lifted off.

    A swinging leg touches down when its foot comes down onto the ground while the leg swings back; on the way forward
    it may dip below (the legs are massless).

    Args:
        state: the 13 states of slip.unknowns at the apex, (13,).
        standing: which legs are on the ground there, (4,).
        parameters: of the model.
        patience: longest time to wait for the end.
        apex: the how manieth apex after that ends the stride; a torso may bob more than once.

    Raises:
        SymdynError: if the stride does not end in time, or the torso falls.
    """
    body = _Body(parameters)
    s = np.zeros(6 + 2 * len(body.hip))
    s[[1, 2, 3, 4, 5]] = state[[DX, Y, DY, PHI, DPHI]]
    s[6::2], s[7::2] = state[list(ALPHA)], state[list(DALPHA)]
    for leg in _LEGS:
        if standing[leg]:
            x, y = body.hip_position(s, leg)
            body.foot[leg] = x + y * math.tan(s[6 + 2 * leg] + s[4])
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
            max_step=_LONGEST_STEP,
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
        for other in _LEGS:
            if (kind, leg) == ("touchdown", other) or _meets_ground(body, s, other, forwards):
                body.foot[other] = body.hip_position(s, other)[0] + body.length * math.sin(s[6 + 2 * other] + s[4])
                touchdowns[other] = time
            elif (kind, leg) == ("liftoff", other) or _leaves_ground(body, s, other):
                s[6 + 2 * other], s[7 + 2 * other] = body.stance_angle(s, other)
                body.foot[other], liftoffs[other] = None, time
    end = np.zeros_like(state)
    end[[DX, Y, DY, PHI, DPHI]] = s[[1, 2, 3, 4, 5]]
    for leg in _LEGS:
        angle = body.stance_angle(s, leg) if body.foot[leg] is not None else (s[6 + 2 * leg], s[7 + 2 * leg])
        end[ALPHA[leg]], end[DALPHA[leg]] = angle
    return SimulatedStride(np.array(touchdowns), np.array(liftoffs), time, float(s[0]), end, drift)


def _meets_ground(body: _Body, s: Vector, leg: int, forwards: float) -> bool:
    """Whether a swinging leg touches down at this very moment, too."""
    if body.foot[leg] is not None or abs(body.foot_height(s, leg)) > _SIMULTANEOUS:
        return False
    dtheta = s[7 + 2 * leg] + s[5]
    sinking = body.hip_velocity(s, leg)[1] + body.length * math.sin(s[6 + 2 * leg] + s[4]) * dtheta < 0.0
    return sinking and forwards * dtheta <= _SWINGS_BACK


def _leaves_ground(body: _Body, s: Vector, leg: int) -> bool:
    """Whether a standing leg lifts off at this very moment, too."""
    foot = body.foot[leg]
    if foot is None or abs(body.spring(s, leg)[0] - body.length) > _SIMULTANEOUS:
        return False
    (x, y), (vx, vy) = body.hip_position(s, leg), body.hip_velocity(s, leg)
    return y * vy - (foot - x) * vx > 0.0


def _events(
    body: _Body, forwards: float, complete: bool
) -> tuple[list[Callable[[float, Vector], float]], list[tuple[str, int]]]:
    events: list[Any] = []
    meanings: list[tuple[str, int]] = []

    def add(function: Callable[[float, Vector], float], direction: float, kind: str, leg: int = -1) -> None:
        function.terminal, function.direction = True, direction  # type: ignore[attr-defined]
        events.append(function)
        meanings.append((kind, leg))

    for leg in _LEGS:
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
    for apex in range(1, _APEXES + 1):
        try:
            run = simulate(orbit.unknowns[STATES], orbit.standing, orbit.parameters, _LONGEST * orbit.period, apex)
        except SymdynError:
            break
        found = np.stack((run.touchdowns, run.liftoffs), axis=1).ravel()
        states = np.abs(run.state - orbit.unknowns[STATES]).max()
        best = np.nanmin([best, max(np.abs(found - expected).max(), states, abs(run.period - orbit.period))])
        if best < _AGREES or run.period > orbit.period:
            break
    return float(best)
