"""Settings of the estimators."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import Literal

from symdyn.errors import InvalidValue
from symdyn.robot.legs import LEGS


@dataclass(frozen=True)
class ContactConfig:
    """When a foot counts as bearing load.

    Attributes:
        source: "force": the sensors in the feet. "torque": the vertical force estimated from the joint torques, for a
            robot with bad foot sensors or none. "auto": the sensors, unless all four have read 0 from the start, as in
            unitree_mujoco; then the torques, until a sensor reads something else.
        thresholds: raw foot force above which a foot bears load, LH LF RF RH. Users of the Go2 report that 20 to 60
            separates stance from swing; ``symdyn calibrate-feet`` measures it.
        vertical_force: the same for "torque", N. A standing Go2 has 40 N on each foot.
        release: share of the threshold below which a foot is off the ground again.
        bandwidth: of the observer of "torque", rad/s. Slower, it is late; faster, swinging legs seem to push.
    """

    source: Literal["auto", "force", "torque"] = "auto"
    thresholds: tuple[float, float, float, float] = (30.0, 30.0, 30.0, 30.0)
    vertical_force: float = 20.0
    release: float = 0.7
    bandwidth: float = 150.0

    def __post_init__(self) -> None:
        if self.source not in ("auto", "force", "torque"):
            raise InvalidValue("contact.source", self.source, "'auto', 'force' or 'torque'")
        if len(self.thresholds) != len(LEGS):
            raise InvalidValue("contact.thresholds", self.thresholds, f"{len(LEGS)} numbers: {', '.join(LEGS)}")
        named = [("thresholds", value) for value in self.thresholds]
        named += [(name, getattr(self, name)) for name in ("vertical_force", "bandwidth")]
        for name, value in named:
            if not 0.0 < value < math.inf:
                raise InvalidValue(f"contact.{name}", value, "a finite number > 0")
        if not 0.0 < self.release <= 1.0:
            raise InvalidValue("contact.release", self.release, "in (0, 1]")


@dataclass(frozen=True)
class EstimatorConfig:
    """Noise of the velocity filter.

    Attributes:
        acceleration: density of the noise of the measured acceleration, (m/s^2)/sqrt(Hz). The sensor's own is the least
            of it (0.1 m/s^2 at 200 Hz: 0.007). A degree of tilt lets 0.17 m/s^2 of gravity through, which in 0.8 s
            moves the velocity as far as this noise does.
        foot_velocity: of a foot in stance, horizontally, m/s: noise of joint velocities (0.1 rad/s at 0.3 m) and slip.
        foot_velocity_vertical: the same vertically, m/s: rubber and floor give way.
        foot_position: of a foot relative to the trunk, m: encoders (2 mrad at 0.3 m), play, links that bend.
        foot_height: of the ground under a foot in stance, m.
        persistence: how long an error of the last four lasts, s. More than one sample in that time tells nothing new,
            so that the result does not depend on the rate.
        slip: random walk of a foot in stance, m/sqrt(s).
        swing: random walk of a foot that is not trusted, m/sqrt(s): it crosses 0.3 m in a swing.
        tail: degrees of freedom nu of the Student t distribution: the smaller, the more outliers are expected.
        trust_rise: time from touchdown until a foot is fully trusted, s.
        longest_flight: s; with no foot down for longer the robot lies or is held, and its velocity is taken to be zero
            within ``held_velocity``. The acceleration's error would else add up.
        held_velocity: m/s.
        longest_gap: s; after a longer one without good input the filter begins anew.
        initial_velocity: uncertainty of each component at the start, m/s.
    """

    acceleration: float = 0.15
    foot_velocity: float = 0.1
    foot_velocity_vertical: float = 0.3
    foot_position: float = 0.002
    foot_height: float = 0.02
    persistence: float = 0.005
    slip: float = 0.02
    swing: float = 5.0
    tail: float = 2.0
    trust_rise: float = 0.03
    longest_flight: float = 0.5
    held_velocity: float = 0.1
    longest_gap: float = 0.1
    initial_velocity: float = 0.5

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if not 0.0 < value < math.inf:
                raise InvalidValue(f"estimator.{field.name}", value, "a finite number > 0")
