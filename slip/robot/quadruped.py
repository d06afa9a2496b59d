"""A robot with four legs on a floating base: kinematics, masses and limits with its joints in symdyn's order.

:mod:`slip.robot.urdf` loads it. The base's frame has x forward, y left and z up (REP 103).
"""

# pinocchio lies in a folder that its wheel adds to the path at run time, out of pyright's sight
# pyright: reportMissingImports=false

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio
from numpy.typing import NDArray

from symdyn.robot.definition import Robot

Vector = NDArray[np.float64]

BASE_VELOCITIES = 6
"""Of the floating base: linear (3), then angular (3), both in the base's frame."""


@dataclass(frozen=True)
class Leg:
    """A leg.

    Attributes:
        name: of :data:`symdyn.robot.legs.LEGS`.
        joints: the URDF's names from the trunk outwards.
        foot: the URDF's name of the foot link.
    """

    name: str
    joints: tuple[str, ...]
    foot: str


@dataclass(frozen=True, eq=False)
class Quadruped:
    """A robot with four legs. Joints that belong to no leg (an arm's) are held at zero; their links count as trunk.

    Attributes:
        name: of the robot.
        urdf: its description.
        model: Pinocchio's, with a free-flyer as root. Not to be changed.
        legs: in the order of LEGS.
        standing: (n,) joint angles of the nominal stance in the order of :attr:`joints`, rad.
        definition: the robot's gains, pose and leg length, if symdyn defines it.
    """

    name: str
    urdf: Path
    model: Any
    legs: tuple[Leg, ...]
    standing: Vector
    definition: Robot | None = None

    @property
    def joints(self) -> tuple[str, ...]:
        """Every joint's name, leg by leg in the order of LEGS, from the trunk outwards; for the Go2 that of JOINTS."""
        return tuple(joint for leg in self.legs for joint in leg.joints)

    def joints_of(self, leg: Leg) -> slice:
        """Where a leg's joints stand in an array over :attr:`joints`."""
        start = sum(len(other.joints) for other in self.legs[: self.legs.index(leg)])
        return slice(start, start + len(leg.joints))

    def velocity_index(self, leg: Leg) -> list[int]:
        """Where a leg's joints stand in Pinocchio's velocity."""
        return [self.model.joints[self.model.getJointId(joint)].idx_v for joint in leg.joints]

    def configuration(self, angles: Vector) -> Vector:
        """Pinocchio's configuration with the base at the origin, level.

        Args:
            angles: (n,) in the order of :attr:`joints`, rad.
        """
        q = pinocchio.neutral(self.model)
        for name, angle in zip(self.joints, angles, strict=True):
            joint = self.model.joints[self.model.getJointId(name)]
            if joint.nq == 1:
                q[joint.idx_q] = angle
            else:  # a continuous joint, which Pinocchio keeps as cosine and sine
                q[joint.idx_q : joint.idx_q + 2] = np.cos(angle), np.sin(angle)
        return q

    def placed(self, angles: Vector) -> Any:
        """Pinocchio's data with joints, frames and Jacobians computed at these angles ((n,), rad)."""
        data = self.model.createData()
        pinocchio.computeJointJacobians(self.model, data, self.configuration(angles))
        pinocchio.updateFramePlacements(self.model, data)
        return data

    def feet(self, angles: Vector) -> Vector:
        """Positions of the feet's origins in the base's frame, (4, 3) in the order of LEGS, m."""
        data = self.placed(angles)
        return np.array([data.oMf[self.foot_frame(leg)].translation for leg in self.legs])

    def foot_frame(self, leg: Leg) -> int:
        """Pinocchio's number of a foot's frame."""
        return self.model.getFrameId(leg.foot, pinocchio.FrameType.BODY)

    def foot_jacobian(self, leg: Leg, data: Any) -> Vector:
        """Foot velocity by the leg's joint velocities, (3, joints), base's frame and orientation, m/rad.

        Args:
            leg: whose foot.
            data: of :meth:`placed`.
        """
        jacobian = pinocchio.getFrameJacobian(
            self.model, data, self.foot_frame(leg), pinocchio.ReferenceFrame.LOCAL_WORLD_ALIGNED
        )
        return jacobian[:3, self.velocity_index(leg)]

    def trunk_joints(self) -> Vector:
        """Where each leg leaves the trunk: origin of its first joint in the base's frame, (4, 3), m."""
        placements = self.model.jointPlacements
        return np.array([placements[self.model.getJointId(leg.joints[0])].translation for leg in self.legs])

    def mass_matrix(self, angles: Vector) -> Vector:
        """Mass matrix, (6 + n, 6 + n): base linear and angular velocity in the base's frame, then :attr:`joints`."""
        upper = np.triu(pinocchio.crba(self.model, self.model.createData(), self.configuration(angles)))
        index = list(range(BASE_VELOCITIES)) + [i for leg in self.legs for i in self.velocity_index(leg)]
        return (upper + np.triu(upper, 1).T)[np.ix_(index, index)]

    def limits(self) -> Vector:
        """Lowest and highest angle of each joint, (2, n), rad; infinite for continuous joints."""
        bounds = np.full((2, len(self.joints)), np.inf) * np.array([[-1.0], [1.0]])
        for i, name in enumerate(self.joints):
            joint = self.model.joints[self.model.getJointId(name)]
            if joint.nq == 1:
                bounds[:, i] = self.model.lowerPositionLimit[joint.idx_q], self.model.upperPositionLimit[joint.idx_q]
        return bounds
