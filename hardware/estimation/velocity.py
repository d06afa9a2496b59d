"""Base velocity and position from legs and IMU, by a linear Kalman filter.

States, 18 in the world frame: position p and velocity v of the trunk's origin, centres f_i of the four feet. With the
attitude R from the IMU, what an accelerometer shows turned into the world gives v' = R a + g, p' = v. A foot in stance
rolls: f_i' = omega_i x r up (:mod:`hardware.estimation.kinematics`). Measurements, 28, each from joint angles and their
velocities and the foot's centre c_i(q) in the body frame:

    f_i - p   = R c_i                                                     12, always
    v         = omega_i x r up - R (dc_i/dt + omega_b x c_i)              12, foot in stance
    f_i up    = r                                                          4, foot in stance, level ground

The scheme is that of Bloesch et al. (2012), made linear by taking the attitude from the IMU as in Bledt et al. (2018a).
Here each noise is the same in all horizontal directions. So no equation mixes coordinates, the filter falls apart into
three of 6 states, and an estimate does not depend on where north is.

Feet are trusted by degrees. A weight w in [0, 1] divides the variance of a foot's velocity and height. It rises over
the first milliseconds of stance, in which a foot skids and presses in. It falls when the foot contradicts the filter:
with a Student t in place of a Gauss distribution (Agamennoni et al. 2012), w = (nu + 3) / (nu + d^2) at a Mahalanobis
distance d of the foot's velocity. So a foot that slips, or whose lift-off the contact sensor has missed, does little
harm. The filter's own uncertainty counts in d, so it cannot shut out all feet for long. In swing w = 0: no information.
"""

from __future__ import annotations

import logging
import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hardware.estimation.kinematics import LegKinematics, rotation, skew
from hardware.estimation.settings import EstimatorConfig
from hardware.wire.readings import Imu, Joints
from symdyn.gait.timing import GRAVITY
from symdyn.robot.legs import JOINTS, LEGS

Floats = NDArray[np.float64]

_log = logging.getLogger(__name__)

# states of one coordinate
_POS, _VEL = 0, 1
_MOTION = slice(0, 2)
_STATES = 2 + len(LEGS)
_FEET = slice(2, _STATES)
_RELATIVE = np.eye(_STATES)[_FEET]
_RELATIVE[:, _POS] = -1.0
"""(4, 6): feet relative to the trunk, by the states."""
_RELATIVE_SQUARED = _RELATIVE.T @ _RELATIVE
_VERTICAL = 2
_UP_W = np.array([0.0, 0.0, 1.0])

_HIGHEST_SPEED = 10.0
"""m/s; twice what a Go2 runs at most."""

_HIGHEST = {
    "quaternion": (4, 1.05),
    "acceleration": (3, 300.0),  # m/s^2; twice the 16 g of usual accelerometers
    "angular velocity": (3, 40.0),  # rad/s; usual gyroscopes show 35 (2000 degrees/s)
    "joint position": (len(JOINTS), 10.0),  # rad; twice what the URDF allows any joint
    "joint velocity": (len(JOINTS), 100.0),  # rad/s; three times what the URDF allows any joint
}
"""How many numbers of what the filter goes by, and the highest that makes sense."""

_BOUNDS = np.repeat([bound for _, bound in _HIGHEST.values()], [size for size, _ in _HIGHEST.values()])

_QUATERNION_TOLERANCE = 0.05
"""Of the square's difference from 1; the bridge sends zeros before it has data from the robot."""


@dataclass(frozen=True, eq=False)
class Estimate:
    """What the filter holds to be true.

    Attributes:
        position_w: (3,) of the trunk's origin, m: x and y from where the filter began, z above the ground.
        velocity_w: (3,) of the trunk's origin, m/s.
        velocity_b: (3,) the same in the body frame.
        velocity_h: (3,) forward and lateral velocity in the heading frame (m/s) and yaw rate (rad/s), as in
            symdyn.analysis.recording.
        deviation_w: (3,) standard deviation of ``velocity_w`` as the filter sees it, m/s.
        trust: (4,) weight of each foot in [0, 1], in the order of symdyn.robot.legs.LEGS.
        valid: whether the last input could be used. If not, all else is as it was, or zero after a reset.
    """

    position_w: Floats
    velocity_w: Floats
    velocity_b: Floats
    velocity_h: Floats
    deviation_w: Floats
    trust: Floats
    valid: bool

    @property
    def height(self) -> float:
        """Of the trunk's origin above the ground, m."""
        return float(self.position_w[_VERTICAL])


class VelocityEstimator:
    """The filter of the module's docstring.

    It begins with its first good input, at x = y = 0, the lowest foot on the ground. Input that is not finite or beyond
    what the robot can do is passed over; the next good one covers its time, too.

    Args:
        kinematics: of the robot.
        config: noise figures.
    """

    def __init__(self, kinematics: LegKinematics, config: EstimatorConfig | None = None) -> None:
        self._kinematics = kinematics
        self._config = config or EstimatorConfig()
        self._foot_variance = np.square(
            [self._config.foot_velocity, self._config.foot_velocity, self._config.foot_velocity_vertical]
        )
        self._warned = False
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._state = np.zeros((3, _STATES))
        self._covariance = np.zeros((3, _STATES, _STATES))
        self._acceleration_w = np.zeros(3)
        self._stance_time = np.zeros(len(LEGS))
        self._flight_time = 0.0
        self._gap = 0.0
        self._begun = False
        self._last = Estimate(*np.zeros((5, 3)), trust=np.zeros(len(LEGS)), valid=False)

    def update(self, dt: float, imu: Imu, joints: Joints, contact: ArrayLike) -> Estimate:
        """Take a sample into account. Never raises for what sensors say.

        Args:
            dt: since the sample before, s.
            imu: newest.
            joints: newest.
            contact: (4,) which feet bear load, in the order of symdyn.robot.legs.LEGS.
        """
        problem = _problem(dt, imu, joints)
        if problem is None and self._begun and self._gap + dt > self._config.longest_gap:
            _log.warning("The velocity estimate restarts after %.2f s without valid input.", self._gap + dt)
            self.reset()
        if problem is not None:
            return self._pass_over(problem, dt)
        legs = _Legs.of(self._kinematics, imu, joints)
        acceleration_w = legs.rotation @ imu.acceleration_b - GRAVITY * _UP_W
        stance = np.asarray(contact, dtype=bool)
        if self._begun:
            dt, self._gap = self._gap + dt, 0.0
            self._advance(dt, (acceleration_w + self._acceleration_w) / 2.0)
        else:
            self._begin(legs)
        self._acceleration_w = acceleration_w
        trust = self._trust(dt, stance, legs)
        self._move_feet(dt, stance, trust, legs)
        self._correct(dt, trust, legs)
        if not (np.abs(self._state[:, _VEL]) < _HIGHEST_SPEED).all():  # nor nan
            _log.warning("The velocity estimate exceeded %g m/s and restarts.", _HIGHEST_SPEED)
            self.reset()
            return self._last
        self._last = self._estimate(imu, legs, trust)
        return self._last

    def _pass_over(self, problem: str, dt: float) -> Estimate:
        if not self._warned:
            _log.warning("The velocity estimate ignores invalid input: %s. This is reported once.", problem)
        self._warned = True
        if math.isfinite(dt):
            self._gap += max(dt, 0.0)
        self._last = replace(self._last, valid=False)
        return self._last

    def _begin(self, legs: _Legs) -> None:
        config, feet = self._config, legs.centre_w
        self._begun = True
        self._state[_VERTICAL, _POS] = np.max(legs.radius - feet[:, _VERTICAL])
        self._state[:, _FEET] = self._state[:, [_POS]] + feet.T
        self._covariance[:, _POS, _POS] = config.foot_height**2
        self._covariance[:, _VEL, _VEL] = config.initial_velocity**2
        # the feet's errors are the trunk's, and their own
        self._covariance[:, _POS, _FEET] = config.foot_height**2
        self._covariance[:, _FEET, _POS] = config.foot_height**2
        self._covariance[:, _FEET, _FEET] = config.foot_height**2
        _diagonal(self._covariance)[:, _FEET] += config.foot_position**2

    def _advance(self, dt: float, acceleration_w: Floats) -> None:
        transition = np.eye(_STATES)
        transition[_POS, _VEL] = dt
        self._state = self._state @ transition.T
        self._state[:, _MOTION] += acceleration_w[:, None] * np.array([dt**2 / 2.0, dt])
        self._covariance = transition @ self._covariance @ transition.T
        # white noise of the acceleration, integrated once and twice
        noise = np.array([[dt**3 / 3.0, dt**2 / 2.0], [dt**2 / 2.0, dt]])
        self._covariance[:, _MOTION, _MOTION] += self._config.acceleration**2 * noise

    def _trust(self, dt: float, stance: NDArray[np.bool_], legs: _Legs) -> Floats:
        config = self._config
        self._stance_time = np.where(stance, self._stance_time + dt, 0.0)
        self._flight_time = 0.0 if stance.any() else self._flight_time + dt
        expected = self._covariance[:, _VEL, _VEL] + self._foot_variance
        distance2 = ((legs.trunk_velocity_w - self._state[:, _VEL]) ** 2 / expected).sum(axis=1)
        likely = np.minimum((config.tail + 3.0) / (config.tail + distance2), 1.0)
        return likely * np.minimum(self._stance_time / config.trust_rise, 1.0)

    def _move_feet(self, dt: float, stance: NDArray[np.bool_], trust: Floats, legs: _Legs) -> None:
        config = self._config
        self._state[:, _FEET] += (dt * stance[:, None] * legs.rolling_w).T
        walk = config.slip**2 * stance + config.swing**2 * (1.0 - trust)
        _diagonal(self._covariance)[:, _FEET] += dt * walk

    def _correct(self, dt: float, trust: Floats, legs: _Legs) -> None:
        # information form: a foot without trust adds nothing, and all measurements go in at once
        config = self._config
        samples = min(dt / config.persistence, 1.0)
        information = np.linalg.inv(self._covariance)
        vector = (information @ self._state[:, :, None])[:, :, 0]
        diagonal = _diagonal(information)
        position = samples / config.foot_position**2
        information += position * _RELATIVE_SQUARED
        vector += position * (legs.centre_w.T @ _RELATIVE)
        velocity = samples * trust / self._foot_variance[:, None]
        diagonal[:, _VEL] += velocity.sum(axis=1)
        vector[:, _VEL] += (velocity * legs.trunk_velocity_w.T).sum(axis=1)
        height = samples * trust / config.foot_height**2
        diagonal[_VERTICAL, _FEET] += height
        vector[_VERTICAL, _FEET] += height * legs.radius
        if self._flight_time > config.longest_flight:
            diagonal[:, _VEL] += samples / config.held_velocity**2
        covariance = np.linalg.inv(information)
        self._covariance = (covariance + covariance.transpose(0, 2, 1)) / 2.0
        self._state = (self._covariance @ vector[:, :, None])[:, :, 0]

    def _estimate(self, imu: Imu, legs: _Legs, trust: Floats) -> Estimate:
        velocity_w = self._state[:, _VEL].copy()
        # as symdyn.robot.frames.to_heading, which for one vector takes longer than the rest
        heading = math.atan2(legs.rotation[1, 0], legs.rotation[0, 0])
        cos, sin = math.cos(heading), math.sin(heading)
        x, y, _ = velocity_w.tolist()
        yaw_rate = float(legs.rotation[_VERTICAL] @ imu.angular_velocity_b)
        return Estimate(
            position_w=self._state[:, _POS].copy(),
            velocity_w=velocity_w,
            velocity_b=velocity_w @ legs.rotation,
            velocity_h=np.array([cos * x + sin * y, cos * y - sin * x, yaw_rate]),
            deviation_w=np.sqrt(self._covariance[:, _VEL, _VEL]),
            trust=trust,
            valid=True,
        )


@dataclass(frozen=True, eq=False)
class _Legs:
    """What a sample says of the legs.

    Attributes:
        rotation: (3, 3) from body to world.
        centre_w: (4, 3) centres of the feet relative to the trunk's origin, m.
        rolling_w: (4, 3) velocity of the centres, if the feet roll on the ground, m/s.
        trunk_velocity_w: (4, 3) velocity of the trunk, if a foot rolls on the ground, m/s.
        radius: (4,) of the feet, m.
    """

    rotation: Floats
    centre_w: Floats
    rolling_w: Floats
    trunk_velocity_w: Floats
    radius: Floats

    @classmethod
    def of(cls, kinematics: LegKinematics, imu: Imu, joints: Joints) -> _Legs:
        attitude = rotation(imu.quat_w)
        feet = kinematics.feet(joints.pos)
        joint_vel = joints.vel.reshape(len(LEGS), -1, 1)
        turn_b = imu.angular_velocity_b
        # rows times a skew matrix: a x u = -u S(a) = u S(a)^T
        swing_b = (feet.centre_jacobian_b @ joint_vel)[:, :, 0] - feet.centre_b @ skew(turn_b)
        foot_turn_b = (feet.axes_b @ joint_vel)[:, :, 0] + turn_b
        rolling_b = feet.radius[:, None] * (foot_turn_b @ skew(attitude[_VERTICAL]))
        return cls(
            rotation=attitude,
            centre_w=feet.centre_b @ attitude.T,
            rolling_w=rolling_b @ attitude.T,
            trunk_velocity_w=(rolling_b - swing_b) @ attitude.T,
            radius=feet.radius,
        )


def _diagonal(matrices: NDArray[np.floating]) -> NDArray[np.floating]:
    """The diagonals of (n, k, k), (n, k); a view, to be written to."""
    return np.einsum("nkk->nk", matrices)


def _problem(dt: float, imu: Imu, joints: Joints) -> str | None:
    """Why an input cannot be used, or None."""
    if not 0.0 < dt < math.inf:
        return f"a time step of {dt:g} s"
    values = (imu.quat_w, imu.acceleration_b, imu.angular_velocity_b, joints.pos, joints.vel)
    if not (np.abs(np.concatenate(values)) <= _BOUNDS).all():  # nor nan
        for (name, (_, highest)), value in zip(_HIGHEST.items(), values, strict=True):
            if not (np.abs(value) <= highest).all():
                return f"{name} {value.tolist()}"
    if abs(float(imu.quat_w @ imu.quat_w) - 1.0) > _QUATERNION_TOLERANCE:
        return f"a quaternion that is not of length 1, {imu.quat_w.tolist()}"
    return None
