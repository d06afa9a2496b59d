"""The model once more, written independently of slip.model.equations: a body on springs, for checks.

A standing leg is a spring between the hip and a fixed point on the ground; a swinging leg is a pendulum in the frame of
its accelerating hip. Nothing is shared with slip.model.equations but the numbers.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from slip.model.parameters import SlipParameters
from slip.model.unknowns import ALPHA, DALPHA, DPHI, DX, DY, FRONT, PHI, SLIP_LEGS, STATES, Y

Vector = NDArray[np.float64]

LEGS = range(len(SLIP_LEGS))


class Body:
    """Forces and accelerations at a state [x, dx, y, dy, phi, dphi, (alpha, dalpha) of the swinging legs]."""

    def __init__(self, parameters: SlipParameters) -> None:
        p = parameters
        self.hip = [(1.0 if i in FRONT else 0.0) - p.hind_distance for i in LEGS]
        self.stiffness = [p.front_stiffness if i in FRONT else p.hind_stiffness for i in LEGS]
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
        for leg in LEGS:
            if self.foot[leg] is not None:
                _length, x, y = self.spring(s, leg)
                fx, fy = fx + x, fy + y
                torque += self.hip[leg] * (cos * y - sin * x)
        ddx, ddy, ddphi = fx, fy - 1.0, torque / self.inertia
        result = [s[1], ddx, s[3], ddy, s[5], ddphi]
        for leg in LEGS:
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
        for leg in LEGS:
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

    def pin(self, s: Vector, leg: int) -> None:
        """Put the foot of a leg on the ground where the leg's line meets it."""
        x, y = self.hip_position(s, leg)
        self.foot[leg] = x + y * math.tan(s[6 + 2 * leg] + s[4])

    def release(self, s: Vector, leg: int) -> None:
        """Let a standing leg swing, from the angle and rate that it has."""
        s[6 + 2 * leg], s[7 + 2 * leg] = self.stance_angle(s, leg)
        self.foot[leg] = None

    def start(self, state: Vector) -> Vector:
        """The state of this class, (14,), of the 13 states of slip.model.unknowns at x = 0."""
        s = np.zeros(6 + 2 * len(self.hip))
        s[[1, 2, 3, 4, 5]] = state[[DX, Y, DY, PHI, DPHI]]
        s[6::2], s[7::2] = state[list(ALPHA)], state[list(DALPHA)]
        return s

    def states(self, s: Vector) -> Vector:
        """The 13 states of slip.model.unknowns of a state of this class."""
        result = np.zeros(STATES.stop)
        result[[DX, Y, DY, PHI, DPHI]] = s[[1, 2, 3, 4, 5]]
        for leg in LEGS:
            angle = self.stance_angle(s, leg) if self.foot[leg] is not None else (s[6 + 2 * leg], s[7 + 2 * leg])
            result[ALPHA[leg]], result[DALPHA[leg]] = angle
        return result
