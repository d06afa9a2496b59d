"""Force of the ground on each foot, from joint torques: a momentum observer.

A leg's joints obey M q'' + C q' + g = tau + J^T f. With the momentum p = M q' and M' = C + C^T this is

    J^T f = p' - (tau + C^T q' - g),

which needs no joint accelerations. A first-order low-pass filter keeps p' from amplifying noise (De Luca et al. 2006;
for the feet of a quadruped: Bledt et al. 2018b). M includes the reflected inertia of the rotors: that of a Go2's knee
rotor is three times the calf's, and without it swing looks like stance.

The trunk is taken as a frame that accelerates, but does not turn: gravity is what its accelerometer shows, reversed.
"""

# pinocchio lies in a folder that its wheel adds to the path at run time, out of pyright's sight
# pyright: reportMissingImports=false

from __future__ import annotations

import math

import numpy as np
import pinocchio
from numpy.typing import NDArray

from hardware.estimation.kinematics import LegKinematics, rotation
from hardware.wire.readings import Imu, Joints
from symdyn.robot.legs import LEGS

Floats = NDArray[np.float64]

_VERTICAL = 2

_DAMPING = 1e-6 * np.eye(3)
"""m^2; of least squares (Nakamura and Hanafusa 1986): a straight leg's Jacobian has no inverse, and a bent one's
least singular value is 0.07 m within the Go2's limits."""


class GroundForce:
    """The observer. It begins anew after input that is not finite.

    Args:
        kinematics: of the robot.
        bandwidth: of the low-pass filter, rad/s.
    """

    def __init__(self, kinematics: LegKinematics, bandwidth: float) -> None:
        self._kinematics = kinematics
        self._bandwidth = bandwidth
        self._model = kinematics.model.copy()
        self._data = self._model.createData()
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._torque = np.zeros(self._model.nv)
        self._before: tuple[Floats, Floats] | None = None

    def update(self, dt: float, imu: Imu, joints: Joints) -> Floats:
        """The vertical force on each foot, (4,) N, upwards positive, in the order of symdyn.robot.legs.LEGS.

        Zero for the first sample; not to be relied on where a leg is all but straight.

        Args:
            dt: since the sample before, s.
            imu: newest.
            joints: newest.
        """
        used = (imu.quat_w, imu.acceleration_b, joints.pos, joints.vel, joints.torque)
        if not (dt > 0.0 and np.isfinite(np.concatenate(used)).all() and imu.quat_w.any()):
            self.reset()
            return np.zeros(len(LEGS))
        momentum, drive = self._balance(imu, joints)
        if self._before is not None:
            momentum_before, drive_before = self._before
            keep = math.exp(-self._bandwidth * dt)
            now = (momentum - momentum_before) / dt - (drive + drive_before) / 2.0
            self._torque = keep * self._torque + (1.0 - keep) * now
        self._before = momentum, drive
        up_b = rotation(imu.quat_w)[_VERTICAL]
        jacobian = self._kinematics.feet(joints.pos).sole_jacobian_b(up_b)
        by_leg = self._torque[self._kinematics.joints].reshape(len(LEGS), -1, 1)
        force_b = np.linalg.solve(jacobian @ jacobian.transpose(0, 2, 1) + _DAMPING, jacobian @ by_leg)[:, :, 0]
        return force_b @ up_b

    def _balance(self, imu: Imu, joints: Joints) -> tuple[Floats, Floats]:
        """p, and tau + C^T q' - g."""
        model, data, index = self._model, self._data, self._kinematics.joints
        position, velocity, torque, none = np.zeros((4, model.nv))
        position[index], velocity[index], torque[index] = joints.pos, joints.vel, joints.torque
        model.gravity.linear = -imu.acceleration_b
        gravity = pinocchio.computeGeneralizedGravity(model, data, position).copy()
        # inverse dynamics at rest, with the velocity for an acceleration, is M q' + g
        momentum = pinocchio.rnea(model, data, position, none, velocity) - gravity
        coriolis = pinocchio.computeCoriolisMatrix(model, data, position, velocity)
        return momentum, torque + coriolis.T @ velocity - gravity
