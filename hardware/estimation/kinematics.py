"""Where the feet are and how they move as seen from the trunk, and what the joints may do: from the URDF, by Pinocchio.

A foot is a sphere: the one that the trainer's model collides with the floor, fitted to the URDF's collision mesh in the
same way (half the height of the mesh's bounding box about the box's centre). It rolls. Where it touches flat ground it
has, without slip, no velocity; its centre has omega x r, which at 1 m/s on legs of 0.35 m makes 5% of the speed. So
velocities here are those of the foot's lowest point.
"""

# pinocchio lies in a folder that its wheel adds to the path at run time, out of pyright's sight
# pyright: reportMissingImports=false

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio
from numpy.typing import NDArray

from symdyn.errors import FileProblem
from symdyn.robot.definition import Robot
from symdyn.robot.descriptions import urdf_path
from symdyn.robot.legs import LEG_JOINTS, LEGS

Floats = NDArray[np.float64]

_LEVI_CIVITA = np.cross(np.eye(3)[:, None], np.eye(3)).swapaxes(1, 2).reshape(3, 9)


def skew(vectors: Floats) -> Floats:
    """The matrices S with S u = vector x u, (..., 3, 3), from (..., 3)."""
    return (vectors @ _LEVI_CIVITA).reshape(*vectors.shape, 3)


def rotation(quat_w: Floats) -> Floats:
    """Matrix from body to world, (3, 3), from (4,) w, x, y, z of any length but 0."""
    return pinocchio.Quaternion(*quat_w.tolist()).normalized().toRotationMatrix()


@dataclass(frozen=True, eq=False)
class JointLimits:
    """What the URDF, or in its place the robot file, allows each joint, in the order of symdyn.robot.legs.JOINTS.

    Attributes:
        lower: (12,) lowest position, rad.
        upper: (12,) highest position, rad.
        velocity: (12,) highest speed, rad/s.
        torque: (12,) highest torque, N m.
    """

    lower: Floats
    upper: Floats
    velocity: Floats
    torque: Floats

    @classmethod
    def of(cls, robot: Robot) -> JointLimits:
        """The limits of a robot.

        Raises:
            FileProblem: if the URDF is missing, cannot be read or lacks a joint.
            ResourceProblem: if example-robot-data is not installed.
        """
        model = _load(robot)
        index = _joint_indices(model, robot)
        lower, upper = model.lowerPositionLimit[index], model.upperPositionLimit[index]
        velocity, torque = model.velocityLimit[index], model.effortLimit[index]
        for i, joint in enumerate(robot.joint_names):
            given = robot.limit(joint)
            if given.position is not None:
                lower[i], upper[i] = given.position
            velocity[i] = given.velocity or velocity[i]
            torque[i] = given.torque or torque[i]
        return cls(lower, upper, velocity, torque)


@dataclass(frozen=True, eq=False)
class Feet:
    """All four feet at one set of joint angles, in the body frame and order of symdyn.robot.legs.LEGS.

    Attributes:
        centre_b: (4, 3) centre of each foot's sphere, m.
        centre_jacobian_b: (4, 3, 3) its derivative by the leg's hip, thigh and calf angle: foot, coordinate, joint.
        axes_b: (4, 3, 3) the leg's joint axes as columns: what the foot turns by, by the leg's joint velocities.
        radius: (4,) of the spheres, m.
    """

    centre_b: Floats
    centre_jacobian_b: Floats
    axes_b: Floats
    radius: Floats

    def sole_b(self, up_b: Floats) -> Floats:
        """The lowest point of each foot, (4, 3), m. ``up_b``: (3,) unit vector, up in the body frame."""
        return self.centre_b - self.radius[:, None] * up_b

    def sole_jacobian_b(self, up_b: Floats) -> Floats:
        """Jacobian of the piece of rubber that is lowest now, (4, 3, 3), as ``centre_jacobian_b``."""
        return self.centre_jacobian_b + self.radius[:, None, None] * (skew(up_b) @ self.axes_b)


class LegKinematics:
    """The legs of a robot, trunk held.

    Args:
        robot: whose URDF is taken.

    Attributes:
        robot: the same.
        model: Pinocchio's, the trunk fixed to its universe, motors' rotors in its armature.
        joints: (12,) where in the model's vectors the joints of symdyn.robot.legs.JOINTS are.
        mass: of all of the robot, kg.

    Raises:
        FileProblem: if the URDF is missing, cannot be read, or lacks a joint, its rotor, or a foot with a collision
            mesh.
        ResourceProblem: if example-robot-data is not installed.
    """

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self.model = _load(robot)
        self._data = self.model.createData()
        # what is fixed to the trunk has no joint above it, and is not in Pinocchio's total
        self.mass = float(self.model.inertias[0].mass + pinocchio.computeTotalMass(self.model))
        self.joints = _joint_indices(self.model, robot)
        self.model.armature = _reflected_inertia(self.model, robot, self.joints)
        self._feet = [_link(self.model, robot, link) for link in robot.foot_links]
        self._centre, self._radius = _foot_spheres(self.model, robot, self._feet)
        self._configuration = np.zeros(self.model.nq)

    def feet(self, joint_pos: Floats) -> Feet:
        """The feet at joint angles ``joint_pos``, (12,) rad."""
        model, data = self.model, self._data
        self._configuration[self.joints] = joint_pos
        # velocity of what each joint drives: of its point at the trunk's origin, and angular
        jacobian = pinocchio.computeJointJacobians(model, data, self._configuration)
        origin, axes = jacobian[:, self.joints].reshape(2, 3, len(LEGS), len(LEG_JOINTS)).transpose(0, 2, 1, 3)
        placed = [pinocchio.updateFramePlacement(model, data, foot) for foot in self._feet]
        centre = np.array([foot.act(centre) for foot, centre in zip(placed, self._centre, strict=True)])
        return Feet(centre, origin - skew(centre) @ axes, axes, self._radius)


def _load(robot: Robot) -> pinocchio.Model:
    path = urdf_path(robot)
    try:
        return pinocchio.buildModelFromUrdf(str(path))
    except (ValueError, RuntimeError) as error:
        raise FileProblem(path, f"cannot be read as a URDF ({error}).") from error


def _joint_indices(model: pinocchio.Model, robot: Robot) -> NDArray[np.intp]:
    lacking = [name for name in robot.joint_names if not model.existJointName(name)]
    if lacking or model.nq != len(robot.joint_names):
        raise FileProblem(
            urdf_path(robot),
            f"has {model.nq} joints, but must have {', '.join(lacking or robot.joint_names)} and no more.",
        )
    return np.array([model.joints[model.getJointId(name)].idx_v for name in robot.joint_names])


def _reflected_inertia(model: pinocchio.Model, robot: Robot, joints: NDArray[np.intp]) -> Floats:
    # Motors are alike, so that gear ratios are as torque limits. The URDF has each rotor as a link beside the driven
    # one; Pinocchio gives its inertia to the fixed joint above it. A disc's is largest about the axis that it spins on.
    reflected = np.zeros(model.nv)
    if robot.gear_ratio is None:
        return reflected
    torque = JointLimits.of(robot).torque
    gear = robot.gear_ratio * torque / torque.min()
    rotors = [_link(model, robot, name.removesuffix("_joint") + "_rotor") for name in robot.joint_names]
    inertias = [model.frames[model.frames[rotor].parentFrame].inertia.inertia for rotor in rotors]
    reflected[joints] = np.array([inertia.diagonal().max() for inertia in inertias]) * gear**2
    return reflected


def _link(model: pinocchio.Model, robot: Robot, link: str) -> int:
    if not model.existBodyName(link):
        raise FileProblem(urdf_path(robot), f"has no link {link!r}.")
    return model.getBodyId(link)


def _foot_spheres(model: pinocchio.Model, robot: Robot, feet: list[int]) -> tuple[list[Floats], Floats]:
    # centres in the feet's frames, and radii
    path = urdf_path(robot)
    try:
        geometry = pinocchio.buildGeomFromUrdf(
            model, str(path), pinocchio.GeometryType.COLLISION, package_dirs=[str(folder) for folder in path.parents]
        )
    except (ValueError, RuntimeError) as error:
        raise FileProblem(path, f"has a collision mesh that cannot be read ({error}).") from error
    shapes = {shape.parentFrame: shape for shape in geometry.geometryObjects}
    centres, radii = [], []
    for link, foot in zip(robot.foot_links, feet, strict=True):
        if foot not in shapes or not hasattr(shapes[foot].geometry, "vertices"):
            raise FileProblem(path, f"has no link {link!r} with a collision mesh.")
        in_foot = model.frames[foot].placement.actInv(shapes[foot].placement)
        vertices = shapes[foot].geometry.vertices() @ in_foot.rotation.T + in_foot.translation
        low, high = vertices.min(axis=0), vertices.max(axis=0)
        centres.append((low + high) / 2.0)
        radii.append((high - low)[2] / 2.0)
    return centres, np.array(radii)
