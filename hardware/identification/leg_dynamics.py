"""Strength, friction, damping, rotor inertia and encoder offsets of a leg in the air: torques against known masses.

torque_i = (M_i(q - offset, motion) + armature a_i + friction sign(v_i) + damping v_i) / strength_i

M is the inverse dynamics of the robot's URDF (Pinocchio), its trunk moving as the IMU says. So strength is relative to
the URDF's masses: a robot whose legs are a tenth heavier looks a tenth weaker.
"""

# pinocchio lies in a folder that its wheel adds to the path at run time, out of pyright's sight
# pyright: reportMissingImports=false

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio
from scipy.optimize import least_squares

from hardware.identification.least_squares import Estimate, block_covariance
from hardware.identification.motor_law import BLOCK_S, EVERY, excited
from hardware.identification.signals import Floats, Signals, derivative, smooth
from symdyn.robot.definition import Robot
from symdyn.robot.descriptions import urdf_path
from symdyn.robot.legs import LEG_JOINTS

CUT_OFF_HZ = 10.0
"""Lower than for the motor's law: noise of accelerations weakens what gravity tells of strength. At 20 Hz and a Go2's
noise strength came out 2.5% too large."""

_SURE_DIRECTION = 0.95  # of the smoothed sign of the velocity: there was no stop nearby
_STILL = 0.2  # rad/s; below, noise decides the sign, and friction may be less than when sliding
_STEP = 1e-3  # rad, for the derivative by an offset
_AGE = "age"
_OWN = ("strength", "armature", "friction", "damping", _AGE)
"""Parameters of one joint. Age: by how much torque and state of one message are not of the same moment; fitted for its
uncertainty, and not reported."""

Found = dict[str, tuple[float, float]]
"""Estimates with the half widths of their 95% intervals, by quantity."""


@dataclass(frozen=True, eq=False)
class Motion:
    """Smoothed, on the grid: joints (N, 12), trunk (N, 3)."""

    pos: Floats
    vel: Floats
    acc: Floats
    sign: Floats
    torque: Floats
    torque_rate: Floats
    turn_b: Floats
    turn_acc_b: Floats
    force_b: Floats

    @classmethod
    def of(cls, signals: Signals) -> Motion:
        """From a log."""
        pos, turn = smooth(signals.pos, CUT_OFF_HZ), smooth(signals.angular_velocity_b, CUT_OFF_HZ)
        vel, torque = derivative(pos), smooth(signals.torque, CUT_OFF_HZ)
        sign = smooth(np.where(np.abs(vel) < _STILL, 0.0, np.sign(vel)), CUT_OFF_HZ)
        return cls(
            pos=pos,
            vel=vel,
            acc=derivative(vel),
            sign=sign,
            torque=torque,
            torque_rate=derivative(torque),
            turn_b=turn,
            turn_acc_b=derivative(turn),
            force_b=smooth(signals.acceleration_b, CUT_OFF_HZ),
        )


class FloatingRobot:
    """Inverse dynamics of a robot whose trunk moves as its IMU says, the IMU taken to be at the trunk's origin.

    Args:
        robot: whose URDF is taken.
    """

    def __init__(self, robot: Robot) -> None:
        self._model = pinocchio.buildModelFromUrdf(str(urdf_path(robot)), pinocchio.JointModelFreeFlyer())
        self._model.gravity.setZero()  # an accelerometer shows it
        self._data = self._model.createData()
        self._joints = np.array([self._model.joints[self._model.getJointId(name)].idx_v for name in robot.joint_names])
        self._q, self._v, self._a = pinocchio.neutral(self._model), np.zeros(self._model.nv), np.zeros(self._model.nv)
        self._shift = self._model.nq - self._model.nv

    def torques(self, motion: Motion, row: int, pos: Floats, acc: Floats) -> Floats:
        """That move the joints so, (12,) N m, with positions and accelerations, (12,) each, in the place of a row's."""
        self._q[self._joints + self._shift] = pos
        self._v[self._joints], self._v[3:6] = motion.vel[row], motion.turn_b[row]
        self._a[self._joints], self._a[3:6] = acc, motion.turn_acc_b[row]
        self._a[:3] = motion.force_b[row]
        return pinocchio.rnea(self._model, self._data, self._q, self._v, self._a)[self._joints]


def identify_leg(signals: Signals, motion: Motion, body: FloatingRobot, leg: int) -> list[Found]:
    """Of the three joints of a leg, an index of LEGS: strength, armature, friction, damping, offset of each.

    Args:
        signals: of a robot that hung.
        motion: of the same.
        body: of the same.
        leg: index of LEGS.
    """
    kinds = len(LEG_JOINTS)
    joints = np.arange(kinds * leg, kinds * (leg + 1))
    targets = signals.commanded(signals.time)
    rows = np.flatnonzero(np.any([excited(targets[:, j]) for j in joints], axis=0))[::EVERY]
    exact = np.array([body.torques(motion, row, motion.pos[row], motion.acc[row])[joints] for row in rows])
    shifts = []
    for joint in joints:
        step = np.zeros(motion.pos.shape[1])
        step[joint] = _STEP
        moved = [body.torques(motion, row, motion.pos[row] + step, motion.acc[row])[joints] for row in rows]
        shifts.append((np.array(moved) - exact) / _STEP)
    by_offset = np.stack(shifts, axis=2)  # sample, equation, offset
    usable = np.abs(motion.sign[rows][:, joints]) > _SURE_DIRECTION
    model = _LegModel(motion, rows, joints, exact, by_offset, usable)
    start = np.concatenate([np.tile([1.0, *np.zeros(len(_OWN) - 1)], kinds), np.zeros(kinds)])
    solved = least_squares(model.residual, start, x_scale="jac", method="lm")
    block = np.tile((signals.time[rows] / BLOCK_S).astype(np.intp)[:, None], (1, kinds))[usable]
    covariance, blocks = block_covariance(solved.jac, solved.fun, block)
    estimate = Estimate(solved.x, covariance, blocks)
    unit, found = np.eye(len(start)), []
    for i in range(kinds):
        places = {name: len(_OWN) * i + k for k, name in enumerate(_OWN) if name != _AGE} | {
            "offset": len(_OWN) * kinds + i
        }
        found.append({name: (float(solved.x[at]), estimate.half_width(unit[at])) for name, at in places.items()})
    return found


@dataclass(frozen=True, eq=False)
class _LegModel:
    motion: Motion
    rows: np.ndarray
    joints: np.ndarray
    exact: Floats
    by_offset: Floats
    usable: np.ndarray

    def residual(self, parameters: Floats) -> Floats:
        kinds = len(self.joints)
        own, offsets = parameters[: len(_OWN) * kinds].reshape(kinds, len(_OWN)), parameters[len(_OWN) * kinds :]
        strength, armature, friction, damping, age = own.T
        at = np.ix_(self.rows, self.joints)
        needed = self.exact - self.by_offset @ offsets
        needed = (
            needed + armature * self.motion.acc[at] + friction * self.motion.sign[at] + damping * self.motion.vel[at]
        )
        shown = self.motion.torque[at] + age * self.motion.torque_rate[at]
        return (shown - needed / strength)[self.usable]
