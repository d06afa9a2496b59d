"""What training, evaluation and the robot must agree on about a robot: names, pose, gains, rates.

Masses, inertias, ranges and torque limits are not here: they come from the robot's URDF.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symdyn.errors import UnknownName
from symdyn.robot.legs import JOINTS, LEGS, UNITREE_LEGS, unitree_joint_name


@dataclass(frozen=True)
class Robot:
    """A robot under joint position control at a fixed rate: target = default_joint_pos + action_scale * action.

    Attributes:
        name: as in a policy file.
        urdf: path of the description inside example-robot-data's ``robots`` folder.
        joint_names: the URDF's names in the order of :data:`symdyn.robot.legs.JOINTS`.
        trunk: the URDF's name of the base link.
        foot_links: the URDF's names of the feet in the order of LEGS.
        default_leg_pose: hip, thigh and calf angle of every leg in the nominal stance, rad.
        action_scale: rad of target per unit of action.
        kp: proportional gain of every joint, N m/rad.
        kd: derivative gain of every joint, N m s/rad.
        control_dt: time between two actions, s.
        leg_length: the length of the non-dimensional speed and period, m.
        base_height_range: band in which the trunk's origin should stay above ground, m.
        gear_ratio: motor turns per joint turn for the joint with the lowest torque limit. The others follow from their
            torque limits, the motors being alike.
    """

    name: str
    urdf: str
    joint_names: tuple[str, ...]
    trunk: str
    foot_links: tuple[str, ...]
    default_leg_pose: tuple[float, float, float]
    action_scale: float
    kp: float
    kd: float
    control_dt: float
    leg_length: float
    base_height_range: tuple[float, float]
    gear_ratio: float

    @property
    def default_joint_pos(self) -> NDArray[np.float64]:
        """Nominal pose, (12,), rad."""
        return np.tile(np.array(self.default_leg_pose), len(LEGS))

    @property
    def base_height(self) -> float:
        """Middle of the band of heights, m: where episodes begin, and what heights are measured from."""
        return sum(self.base_height_range) / 2.0


GO2 = Robot(
    name="go2",
    urdf="go2_description/urdf/go2.urdf",
    joint_names=tuple(unitree_joint_name(joint) for joint in JOINTS),
    trunk="base",
    foot_links=tuple(f"{UNITREE_LEGS[leg]}_foot" for leg in LEGS),
    # The same for all legs, feet a little behind the hips. Of the poses tried it is the highest that the gains alone
    # hold: it settles level at 0.35 m, where straighter legs or feet below the hips tip over at once.
    default_leg_pose=(0.0, 0.7, -1.2),
    action_scale=0.25,  # legged_gym's value for robots of this size (Rudin et al. 2022)
    kp=30.0,  # paper, section III-C
    kd=0.65,  # paper, section III-C
    control_dt=0.02,  # 50 Hz: paper, section III-E
    leg_length=0.40,  # middle of base_height_range
    base_height_range=(0.35, 0.45),  # paper, section III-E
    gear_ratio=6.33,  # Unitree's A1/Go1/Go2 hip and thigh motors (mujoco_menagerie, mjlab go1_constants)
)

ROBOTS = {GO2.name: GO2}


def get_robot(name: str) -> Robot:
    """The robot of that name. Raises UnknownName."""
    try:
        return ROBOTS[name]
    except KeyError:
        raise UnknownName("robot", name, ROBOTS) from None
