"""What a robot is as a spring-loaded body: mass, pitch inertia, hips, leg stiffness, swing frequency, in SI units.

Everything is measured on the description in its nominal stance, the base level.

**Hips** are where legs swing fore and aft: the point of the axis of the first joint that turns about the lateral axis,
seen from the side. The leg line runs from there to the foot's origin.

**Leg stiffness** is that of the position gains. A force F on the foot moves it by C F with the compliance
C = J Kp^-1 J^T, where J is the foot's Jacobian. In a planar model the foot stays in its sagittal plane: friction and
the other side's leg take the lateral force that this needs. So the stiffness along the leg line d is

    K = 1 / (C_dd - C_dy^2 / C_yy).

A foot that slides sideways without friction is softer, 1 / C_dd, because abduction gives way too; it is kept beside K.
The Go2 settles on its gains in MuJoCo as K says (a test), not as 1 / C_dd.

**Swing frequency**: a leg held stiff by its other joints has the inertia I about the hip axis (with the rotor's, seen
through the gear, where the robot's definition has one). The gain of the hip makes it a torsion pendulum with
sqrt(kp / I); gravity alone, the trunk held, makes it a pendulum with sqrt(m g r / I), r from the axis to the leg's
centre of mass. The model's swing spring is the first one: it acts in flight, where the hip falls freely and gravity
turns no leg.
"""

# pinocchio lies in a folder that its wheel adds to the path at run time, out of pyright's sight
# pyright: reportMissingImports=false

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio
from numpy.typing import NDArray

from slip.robot.quadruped import BASE_VELOCITIES, Leg, Quadruped
from slip.robot.rotors import reflected_rotor_inertia
from slip.robot.urdf import load_robot
from symdyn.errors import InvalidValue, SymdynError
from symdyn.gait.timing import GRAVITY
from symdyn.robot.legs import LEGS, is_front
from symdyn.robot.robot_file import DEFAULT_ROBOT

Vector = NDArray[np.float64]

_LATERAL = np.array([0.0, 1.0, 0.0])
_MOSTLY = math.cos(math.radians(45.0))
_STRAIGHT = 1e-6
"""A leg whose compliance along its line is below this share of (leg length)^2 / kp is straight: it has no spring."""


@dataclass(frozen=True)
class Gains:
    """Position and velocity gain of every joint.

    Attributes:
        kp: N m/rad.
        kd: N m s/rad.
        source: where they come from.
    """

    kp: float
    kd: float
    source: str = "given"

    def __post_init__(self) -> None:
        if not (math.isfinite(self.kp) and self.kp > 0.0):
            raise InvalidValue("kp", self.kp, "a finite number > 0, N m/rad")
        if not (math.isfinite(self.kd) and self.kd >= 0.0):
            raise InvalidValue("kd", self.kd, "a finite number >= 0, N m s/rad")


@dataclass(frozen=True, eq=False)
class RobotBody:
    """A robot in its nominal stance. Arrays over legs are in the order of LEGS; positions in the base's frame.

    Attributes:
        name: of the robot.
        mass: of all of it, kg.
        pitch_inertia: of all of it about the lateral axis through the centre of mass, joints locked, kg m^2.
        centre_of_mass: (3,), m.
        hips: (4, 3) where the leg lines begin, m.
        feet: (4, 3) origins of the foot links, m.
        leg_length: unit of the non-dimensional speed and period, m: the definition's, else the mean of ``hip_to_foot``.
        gains: of every joint.
        leg_stiffness: (4,) K of the module's docstring, N/m.
        leg_stiffness_sliding: (4,) the same with a foot free to slide sideways, N/m.
        leg_inertia: (4,) of the leg about its hip axis, with the rotor, kg m^2.
        pendulum_stiffness: (4,) m g r: gravity's torque by the angle of the hanging leg about its hip axis, N m/rad.
    """

    name: str
    mass: float
    pitch_inertia: float
    centre_of_mass: Vector
    hips: Vector
    feet: Vector
    leg_length: float
    gains: Gains
    leg_stiffness: Vector
    leg_stiffness_sliding: Vector
    leg_inertia: Vector
    pendulum_stiffness: Vector

    @property
    def torso_length(self) -> float:
        """From the hind hips forward to the front hips, m."""
        return _mean_of(self.hips[:, 0], front=True) - _mean_of(self.hips[:, 0], front=False)

    @property
    def hind_distance(self) -> float:
        """l_b: from the hind hips forward to the centre of mass, as a fraction of the torso length."""
        return (float(self.centre_of_mass[0]) - _mean_of(self.hips[:, 0], front=False)) / self.torso_length

    @property
    def hip_to_foot(self) -> Vector:
        """Length of each leg line, seen from the side, (4,), m."""
        return np.hypot(*(self.feet - self.hips)[:, [0, 2]].T)

    @property
    def leg_angles(self) -> Vector:
        """Of each leg line from the vertical, positive if the foot is in front of its hip, (4,), rad."""
        forward, _, up = (self.feet - self.hips).T
        return np.arctan2(forward, -up)

    @property
    def mean_stiffness(self) -> float:
        """Mean of hind and front leg stiffness, N/m."""
        return float(np.mean(self.leg_stiffness))

    @property
    def stiffness_ratio(self) -> float:
        """k_r: hind over front leg stiffness."""
        return _mean_of(self.leg_stiffness, front=False) / _mean_of(self.leg_stiffness, front=True)

    @property
    def swing_frequency(self) -> float:
        """Of a leg about its hip on the position gain, mean of the legs, rad/s."""
        return float(np.mean(np.sqrt(self.gains.kp / self.leg_inertia)))

    @property
    def swing_damping_ratio(self) -> float:
        """Of the same oscillation, by the velocity gain: 1 is critical."""
        return float(np.mean(self.gains.kd / (2.0 * np.sqrt(self.gains.kp * self.leg_inertia))))

    @property
    def pendulum_frequency(self) -> float:
        """Of a leg about its hip by gravity alone, mean of the legs, rad/s."""
        return float(np.mean(np.sqrt(self.pendulum_stiffness / self.leg_inertia)))


def _mean_of(values: Vector, front: bool) -> float:
    return float(np.mean([value for value, leg in zip(values, LEGS, strict=True) if is_front(leg) == front]))


def load_body(name: str, gains: Gains | None = None) -> RobotBody:
    """A robot by name or robot file, loaded and measured.

    Raises what :func:`slip.robot.urdf.load_robot` and :func:`measure` raise.
    """
    return measure(load_robot(name), gains)


def measure(robot: Quadruped, gains: Gains | None = None, leg_length: float | None = None) -> RobotBody:
    """The body of a robot in its nominal stance.

    Args:
        robot: any.
        gains: of its joints; the definition's if left out, and :func:`similar_gains` for a robot without.
        leg_length: m; the definition's if left out, and the distance from hip to foot for a robot without.

    Raises:
        InvalidValue: if the leg length is not positive.
        SymdynError: if a leg has no joint that swings it fore and aft, if a leg is straight in the nominal stance (it
            has no spring there: give a pose with bent knees).
    """
    if leg_length is not None and not (math.isfinite(leg_length) and leg_length > 0.0):
        raise InvalidValue("leg_length", leg_length, "a finite number > 0, m")
    model, data = robot.model, robot.placed(robot.standing)
    configuration = robot.configuration(robot.standing)
    pinocchio.ccrba(model, data, configuration, np.zeros(model.nv))  # inertia of the whole robot
    mass, pitch_inertia = float(data.Ig.mass), float(data.Ig.inertia[1, 1])
    pinocchio.centerOfMass(model, data, configuration, True)  # of every subtree, too
    swings = [_swing_joint(robot, leg, data) for leg in robot.legs]
    swing_joints = [joint for joint, _ in swings]
    hips = np.array([data.oMi[model.getJointId(joint)].translation for joint in swing_joints])
    feet = np.array([data.oMf[robot.foot_frame(leg)].translation for leg in robot.legs])
    length = leg_length or (robot.definition.leg_length if robot.definition else _hip_to_foot(hips, feet))
    gains = gains or _default_gains(robot, mass, _hip_to_foot(hips, feet))
    springs = [
        _springs(robot, leg, data, hip, foot, gains) for leg, hip, foot in zip(robot.legs, hips, feet, strict=True)
    ]
    return RobotBody(
        name=robot.name,
        mass=mass,
        pitch_inertia=pitch_inertia,
        centre_of_mass=data.com[0].copy(),
        hips=hips,
        feet=feet,
        leg_length=length,
        gains=gains,
        leg_stiffness=np.array([planar for planar, _ in springs]),
        leg_stiffness_sliding=np.array([sliding for _, sliding in springs]),
        leg_inertia=_leg_inertias(robot, swing_joints),
        pendulum_stiffness=np.array([_pendulum_stiffness(model, data, joint, axis) for joint, axis in swings]),
    )


def similar_gains(mass: float, hip_to_foot: float, reference: str = DEFAULT_ROBOT) -> Gains:
    """Gains dynamically similar to those of a robot that has them.

    Equal are kp / (m g l) and kd / (m g l sqrt(l / g)), l from hip to foot.

    A description holds no gains. These come out within a factor of two of those in use: 18 and 145 N m/rad for the A1
    and the ANYmal C, where legged_gym (Rudin et al. 2022) takes 20 and 80.

    Args:
        mass: of the robot, kg.
        hip_to_foot: its leg length in the nominal stance, m.
        reference: name of the robot that has gains.
    """
    its = load_body(reference)
    torque = mass * hip_to_foot / (its.mass * _hip_to_foot(its.hips, its.feet))
    time = math.sqrt(hip_to_foot / _hip_to_foot(its.hips, its.feet))
    return Gains(its.gains.kp * torque, its.gains.kd * torque * time, f"dynamically similar to those of {reference}")


def foot_compliance(robot: Quadruped, leg: Leg, data: Any, gains: Gains) -> Vector:
    """C = J Kp^-1 J^T: displacement of a foot by a force on it, base and targets fixed, (3, 3), base's frame, m/N.

    Args:
        robot: it.
        leg: whose foot.
        data: of :meth:`slip.robot.quadruped.Quadruped.placed`.
        gains: of every joint.
    """
    jacobian = robot.foot_jacobian(leg, data)
    return jacobian @ jacobian.T / gains.kp


def _hip_to_foot(hips: Vector, feet: Vector) -> float:
    return float(np.mean(np.hypot(*(feet - hips)[:, [0, 2]].T)))


def _default_gains(robot: Quadruped, mass: float, hip_to_foot: float) -> Gains:
    if robot.definition is None:
        return similar_gains(mass, hip_to_foot)
    return Gains(robot.definition.kp, robot.definition.kd, f"the robot file of {robot.definition.name}")


def _swing_joint(robot: Quadruped, leg: Leg, data: Any) -> tuple[str, Vector]:
    world = pinocchio.ReferenceFrame.WORLD
    for name, column in zip(leg.joints, robot.velocity_index(leg), strict=True):
        joint = robot.model.getJointId(name)
        axis_b = pinocchio.getJointJacobian(robot.model, data, joint, world)[3:, column]
        if abs(axis_b @ _LATERAL) > _MOSTLY:
            return name, axis_b
    raise SymdynError(f"{robot.urdf}: no joint of {leg.name} ({', '.join(leg.joints)}) swings the leg fore and aft.")


def _springs(robot: Quadruped, leg: Leg, data: Any, hip: Vector, foot: Vector, gains: Gains) -> tuple[float, float]:
    line = (foot - hip) * (1.0 - _LATERAL)
    length = float(np.linalg.norm(line))
    line = line / length
    compliance = foot_compliance(robot, leg, data, gains)
    along, across, lateral = line @ compliance @ line, line @ compliance @ _LATERAL, _LATERAL @ compliance @ _LATERAL
    # a leg without abduction does not move sideways at all
    planar = along - across**2 / lateral if lateral > 1e-9 * np.trace(compliance) else along
    if planar < _STRAIGHT * length**2 / gains.kp:
        raise SymdynError(
            f"{robot.urdf}: {leg.name} is straight in the nominal stance, so its gains give no stiffness along it; "
            "give a pose with bent knees."
        )
    return 1.0 / float(planar), 1.0 / float(along)


def _leg_inertias(robot: Quadruped, swing_joints: list[str]) -> Vector:
    # the diagonal of the mass matrix at a joint is the inertia about its axis of all that it carries
    diagonal = np.diag(robot.mass_matrix(robot.standing))[BASE_VELOCITIES:]
    return np.array([diagonal[robot.joints.index(joint)] for joint in swing_joints]) + np.array(
        [reflected_rotor_inertia(robot, joint) for joint in swing_joints]
    )


def _pendulum_stiffness(model: Any, data: Any, name: str, axis_b: Vector) -> float:
    joint = model.getJointId(name)
    centre = data.oMi[joint].act(data.com[joint])
    lever = np.linalg.norm(np.cross(axis_b, centre - data.oMi[joint].translation))
    level = math.hypot(axis_b[0], axis_b[1])  # gravity along a tilted axis turns nothing
    return float(data.mass[joint] * GRAVITY * level * lever)
