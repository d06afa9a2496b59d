"""Are the legs those that they are taken for? While a knee stretches, the trunk must tilt as the legs say.

Joints that are exchanged alike in what is reported and in what is told, front left for front right say, each answer for
themselves. But the plane through the feet, as the reported joints have it, then turns otherwise than the IMU does. So
it does where the IMU's axes are others than thought, or its quaternion is that of the inverse rotation.
"""

from __future__ import annotations

import numpy as np

from hardware.leg_kinematics import LegKinematics
from hardware.readings import Floats, Imu, Joints
from symdyn.legs import LEGS

AXES = ("pitches", "rolls")
"""What the trunk does where the world's up moves along x, and along y, in the body frame."""

_STILL = 1e-4
"""rad; less tilt than this, root mean square, is rounding."""


class LegOrder:
    """Compares the tilt that the IMU tells with the tilt that the legs tell, on any floor that the feet stand on.

    Args:
        kinematics: of the robot.
    """

    def __init__(self, kinematics: LegKinematics) -> None:
        self._kinematics = kinematics
        self._seen: dict[str, list[tuple[Floats, Floats]]] = {leg: [] for leg in LEGS}

    def observe(self, leg: str, joints: Joints, imu: Imu) -> None:
        """Take note of a moment in which the knee of ``leg`` is wiggled."""
        up_b = -imu.gravity_b
        self._seen[leg].append((self._normal_b(joints)[:2], up_b[:2]))

    def agreement(self) -> Floats:
        """How much of the tilt that the legs tell the IMU tells as well, (4, 2), of :data:`LEGS` and :data:`AXES`.

        The slope of the one over the other by least squares, while that leg's knee was wiggled: 1 on the floor, about 0
        in a harness, where the trunk stays as it is, and less than 0 where the trunk tilts the other way. 0 where
        nothing was seen or the legs did not move.
        """
        slopes = np.zeros((len(LEGS), len(AXES)))
        for row, seen in zip(slopes, self._seen.values(), strict=True):
            if len(seen) > 2:
                by_legs, by_imu = np.array(seen).swapaxes(0, 1)
                by_legs -= by_legs.mean(axis=0)
                spread = (by_legs**2).sum(axis=0)
                moved = spread > len(seen) * _STILL**2
                np.divide((by_legs * by_imu).sum(axis=0), spread, out=row, where=moved)
        return slopes

    def _normal_b(self, joints: Joints) -> Floats:
        """Of the plane through the feet's centres, by least squares: the unit vector that points up."""
        x, y, z = self._kinematics.feet(joints.pos).centre_b.T
        (a, b, _), *_ = np.linalg.lstsq(np.column_stack([x, y, np.ones_like(x)]), z)
        return np.array([-a, -b, 1.0]) / np.sqrt(a * a + b * b + 1.0)
