"""What training, evaluation and the robot must agree on about a robot: names, pose, gains, rates.

Masses, inertias, ranges and torque limits come from the robot's URDF. What a URDF cannot say stands in a robot file
(:mod:`symdyn.robot.robot_file`), whose keys are the attributes of the classes here.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray

from symdyn.errors import InvalidValue
from symdyn.robot.legs import LEGS

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]*")


@dataclass(frozen=True)
class Leg:
    """One leg.

    Attributes:
        joints: names of its joints in the URDF from the trunk outwards: hip (abduction), thigh (flexion), calf (knee).
        foot: name of its foot link in the URDF.
        stance: angles of these joints in the nominal stance, rad: where episodes begin and what actions are added to.
        lying: angles on the belly, rad, as symdyn robot-sim finds the robot; without them it sinks from its stance.
        hanging: angles in the harness, rad; without them those of the stance.
    """

    joints: tuple[str, str, str]
    foot: str
    stance: tuple[float, float, float]
    lying: tuple[float, float, float] | None = None
    hanging: tuple[float, float, float] | None = None


@dataclass(frozen=True)
class Legs:
    """The four legs.

    Attributes:
        LH: left hind.
        LF: left front.
        RF: right front.
        RH: right hind.
    """

    LH: Leg
    LF: Leg
    RF: Leg
    RH: Leg

    def in_order(self) -> tuple[Leg, ...]:
        """In the order of :data:`symdyn.robot.legs.LEGS`."""
        return tuple(getattr(self, leg) for leg in LEGS)


@dataclass(frozen=True)
class JointLimit:
    """Limits of one joint, where the URDF has none or wrong ones. What is left out is the URDF's.

    Attributes:
        joint: its name in the URDF.
        position: lowest and highest angle, rad.
        velocity: highest speed, rad/s.
        torque: highest torque, N m.
    """

    joint: str
    position: tuple[float, float] | None = None
    velocity: float | None = None
    torque: float | None = None


@dataclass(frozen=True)
class Robot:
    """A robot under joint position control at a fixed rate: target = default_joint_pos + action_scale * action.

    Attributes:
        name: of the robot, as configurations, checkpoints, curves and policies carry it.
        urdf: its description: ``example-robot-data:PATH`` inside that package's ``robots`` folder, or a path. A
            relative path counts from the folder of the robot file.
        trunk: name of the base link in the URDF.
        legs: which joints and which foot are whose, and the nominal stance.
        action_scale: rad of target per unit of action.
        kp: proportional gain of every joint, N m/rad.
        kd: derivative gain of every joint, N m s/rad.
        control_dt: time between two actions, s.
        leg_length: the length that makes speed and stride period dimensionless, m.
        base_height_range: band in which the trunk's origin should stay above ground, m.
        gear_ratio: motor turns per joint turn for the joint with the lowest torque limit, where the URDF has a link
            ``..._rotor`` beside each driven one; the other ratios follow from the torque limits, the motors being
            alike. Without it the joints carry no reflected rotor inertia.
        torque_knee: share of a joint's velocity limit up to which its motor gives its full torque; from there the
            torque along the motion falls linearly to zero at the limit. Without it speed does not limit torque.
        limits: of joints, where the URDF has none or wrong ones.

    Raises:
        InvalidValue: if a number is out of range, or a name stands twice.
    """

    name: str
    urdf: str
    trunk: str
    legs: Legs
    action_scale: float
    kp: float
    kd: float
    control_dt: float
    leg_length: float
    base_height_range: tuple[float, float]
    gear_ratio: float | None = None
    torque_knee: float | None = None
    limits: tuple[JointLimit, ...] = ()

    def __post_init__(self) -> None:
        if not _NAME.fullmatch(self.name):
            raise InvalidValue("name", self.name, "a word of letters, digits, '_', '.', '-'")
        for name in ("action_scale", "kp", "control_dt", "leg_length", "gear_ratio"):
            value = getattr(self, name)
            if value is not None and not 0.0 < value < math.inf:
                raise InvalidValue(name, value, "a number > 0")
        if self.torque_knee is not None and not 0.0 <= self.torque_knee < 1.0:
            raise InvalidValue("torque_knee", self.torque_knee, "in [0, 1)")
        if not 0.0 <= self.kd < math.inf:
            raise InvalidValue("kd", self.kd, "a number >= 0")
        low, high = self.base_height_range
        if not 0.0 < low < high < math.inf:
            raise InvalidValue("base_height_range", self.base_height_range, "two heights > 0, the smaller first")
        for what, names in (("joints", self.joint_names), ("feet", self.foot_links)):
            if len(set(names)) != len(names):
                raise InvalidValue(f"The {what} of the legs", names, "different from each other")
        if not np.isfinite(self.default_joint_pos).all():
            raise InvalidValue("The stance of the legs", self.default_joint_pos.tolist(), "finite angles")
        limited = [limit.joint for limit in self.limits]
        if not set(limited) <= set(self.joint_names) or len(set(limited)) != len(limited):
            raise InvalidValue("The joints of limits", limited, f"each once, of {', '.join(self.joint_names)}")

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The URDF's names in the order of :data:`symdyn.robot.legs.JOINTS`."""
        return tuple(joint for leg in self.legs.in_order() for joint in leg.joints)

    @property
    def foot_links(self) -> tuple[str, ...]:
        """The URDF's names of the feet in the order of LEGS."""
        return tuple(leg.foot for leg in self.legs.in_order())

    @property
    def default_joint_pos(self) -> NDArray[np.float64]:
        """Nominal stance in the order of JOINTS, (12,), rad."""
        return np.array([angle for leg in self.legs.in_order() for angle in leg.stance])

    @property
    def base_height(self) -> float:
        """Middle of the band of heights, m: where episodes begin, and what heights are measured from."""
        return sum(self.base_height_range) / 2.0

    def standing_at(self, joint_pos: NDArray[np.float64]) -> Robot:
        """The robot with another nominal stance. ``joint_pos``: (12,) rad in the order of JOINTS."""
        poses = np.asarray(joint_pos, dtype=np.float64).reshape(len(LEGS), -1).tolist()
        legs = {
            item.name: replace(getattr(self.legs, item.name), stance=tuple(poses[LEGS.index(item.name)]))
            for item in fields(Legs)
        }
        return replace(self, legs=Legs(**legs))

    def limit(self, joint: str) -> JointLimit:
        """What the robot file says of a joint's limits; nothing, if it is silent on them."""
        return next((limit for limit in self.limits if limit.joint == joint), JointLimit(joint))
