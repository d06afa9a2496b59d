"""Inertia of a motor's rotor as its joint feels it, from the rotor links of Unitree's descriptions."""

from __future__ import annotations

from xml.etree import ElementTree

from slip.robot.quadruped import Quadruped
from symdyn.errors import FileProblem


def reflected_rotor_inertia(robot: Quadruped, joint_name: str) -> float:
    """Rotor inertia times the gear ratio squared, kg m^2; 0 for a robot without a gear ratio in a robot file.

    The description has each rotor as a link beside the driven one. A disc spins about the axis of its largest inertia.
    Motors are alike, so that gear ratios are as torque limits; the robot file's is that of the weakest joint.

    Args:
        robot: it.
        joint_name: as in the URDF, ``FL_thigh_joint``.

    Raises:
        FileProblem: if the description lacks the rotor link.
    """
    definition = robot.definition
    if definition is None or definition.gear_ratio is None:
        return 0.0
    link_name = joint_name.removesuffix("_joint") + "_rotor"
    inertia = ElementTree.parse(robot.urdf).find(f"link[@name='{link_name}']/inertial/inertia")
    if inertia is None:
        raise FileProblem(robot.urdf, f"has no rotor link {link_name!r} with an inertia.")
    rotor = max(float(inertia.get(axis, "0")) for axis in ("ixx", "iyy", "izz"))
    limits = {name: definition.limit(name).torque or _torque_limit(robot, name) for name in robot.joints}
    return rotor * (definition.gear_ratio * limits[joint_name] / min(limits.values())) ** 2


def _torque_limit(robot: Quadruped, joint_name: str) -> float:
    joint = robot.model.joints[robot.model.getJointId(joint_name)]
    return float(robot.model.upperEffortLimit[joint.idx_v])
