"""Are the legs those that they are taken for? While a knee stretches, the trunk tilts: the IMU tells which corner rose.

Joints that are exchanged alike in what is reported and in what is told, front left for front right say, each answer for
themselves. So each of the 24 orders that the legs may truly be in is asked how the trunk should have tilted, and the
one that explains best how it did tilt is the true one. An IMU whose axes or quaternion are others than thought makes
the trunk seem to tilt the other way, as if sides or ends were exchanged.
"""

from __future__ import annotations

from itertools import permutations

import numpy as np

from hardware.estimation.kinematics import LegKinematics
from hardware.wire.readings import Floats, Imu, Joints
from symdyn.robot.legs import LEG_JOINTS, LEGS

ORDERS = tuple(permutations(range(len(LEGS))))
"""Of the legs, the one that they are taken in first. An order says: ``LEGS[k]`` is taken for ``LEGS[order[k]]``."""

_BETTER = 1.3
"""What the order as taken leaves unexplained, over what another leaves, for the other to be the true one. In simulation
the true order is never beaten at all, and beats the others by 1.8 and more."""


class LegOrder:
    """Compares the tilts that the IMU tells with those that the legs tell, in whatever order, on feet that stand.

    Args:
        kinematics: of the robot.
        stance: (12,) rad, where the joints are but for small motions.
    """

    def __init__(self, kinematics: LegKinematics, stance: Floats) -> None:
        feet = kinematics.feet(stance)
        # how the height of each foot's centre in the body frame changes with its leg's joints
        self._lift = feet.centre_jacobian_b[:, 2]
        # up in the body frame, x and y, by the heights of the feet: of the plane through them, by least squares
        plane = np.column_stack([feet.centre_b[:, :2], np.ones(len(LEGS))])
        self._up = -np.linalg.pinv(plane)[:2]
        self._seen: dict[str, list[tuple[Floats, Floats]]] = {leg: [] for leg in LEGS}

    def observe(self, leg: str, joints: Joints, imu: Imu) -> None:
        """Take note of a moment in which the knee of ``leg`` is wiggled."""
        self._seen[leg].append((joints.pos, -imu.gravity_b[:2]))

    def explained(self) -> Floats:
        """The share of the trunk's tilting that the legs explain in each of :data:`ORDERS`, (24,).

        1 - (sum of squares of what is left) / (sum of squares of the tilts), both about the mean of each knee's wiggle:
        near 1 for the true order, less than 0 for an order that explains worse than no motion at all, as all do in a
        harness, where the trunk stays as it is. 0 for all where nothing was seen.
        """
        tilts, left = 0.0, np.zeros(len(ORDERS))
        for seen in filter(None, self._seen.values()):
            joint_pos, up_b = (np.array(values) for values in zip(*seen, strict=True))
            moved = (joint_pos - joint_pos.mean(axis=0)).reshape(len(seen), len(LEGS), len(LEG_JOINTS))
            up_b -= up_b.mean(axis=0)
            tilts += (up_b**2).sum()
            # the motion of the joints as reported, of the order's leg at each corner, moves that corner's foot
            heights = np.einsum("lj,tolj->otl", self._lift, moved[:, ORDERS])
            left += ((up_b - heights @ self._up.T) ** 2).sum(axis=(1, 2))
        return 1.0 - left / tilts if tilts > 0.0 else left

    def other(self, at_least: float) -> tuple[tuple[int, ...], float] | None:
        """An order that is the true one rather than the one as taken, and the share of the tilting that it explains.

        Args:
            at_least: share that it must explain.
        """
        explained = self.explained()
        best = int(np.argmax(explained))
        as_taken = ORDERS.index(tuple(range(len(LEGS))))
        beaten = 1.0 - explained[as_taken] > _BETTER * (1.0 - explained[best])
        return (ORDERS[best], float(explained[best])) if beaten and explained[best] >= at_least else None
