"""The morphological symmetry group of a robot, found from its description.

An element acts on the trunk by a reflection or half turn R about the centre of the hips, on the legs by a permutation
and on joint angles by a permutation with signs, rho. It is a symmetry

- of the **mechanism** if the feet are equivariant: foot_i(rho q) = R foot_rho(i)(q) for all q;
- of the **body** if, in addition, the mass matrix is, M(rho q) = rho M(q) rho^T (base vectors by R, angular ones by
  det(R) R), and the joint limits of a joint are those of its image.

Permutation and signs are not assumed: every leg is tried in the place of every other with every combination of signs.
Errors of the mass matrix are relative, in the Frobenius norm (kg, m and rad as they come), the largest over random
poses.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from itertools import permutations, product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slip.robot.quadruped import BASE_VELOCITIES, Quadruped
from slip.robot.tolerances import Tolerances
from symdyn.gait.symmetry import K4, Spatial
from symdyn.robot.legs import JOINTS, LEGS

Vector = NDArray[np.float64]

POSES = 48
"""Random poses that an equation is tried on, every angle anywhere on the circle."""

_SEED = 0


@dataclass(frozen=True)
class Element:
    """An element of K4 as the robot has it. Indices are those of :class:`symdyn.gait.symmetry.Spatial`.

    Attributes:
        name: e, g_s, g_t or g_r.
        leg_index: ``x[..., leg_index]`` is the transformed array over legs.
        joint_index: ``joint_signs * q[..., joint_index]`` are the transformed angles, in the robot's order of joints.
        joint_signs: 1 or -1 each.
        kinematics_error: largest error of a foot's position, relative to the legs' reach.
        mass_error: largest error of the mass matrix, relative.
        limits_error: largest distance between a joint's limit and its image's, rad; infinite if only one has a limit.
    """

    name: str
    leg_index: tuple[int, ...]
    joint_index: tuple[int, ...]
    joint_signs: tuple[int, ...]
    kinematics_error: float
    mass_error: float
    limits_error: float

    @property
    def spatial(self) -> Spatial:
        """The element of :data:`symdyn.gait.symmetry.K4` that acts on the trunk alike."""
        return next(g for g in K4 if g.name == self.name)

    @property
    def representation(self) -> Vector:
        """rho on generalised velocities, (6 + n, 6 + n): base linear, base angular, joints."""
        n = len(self.joint_index)
        rho = np.zeros((BASE_VELOCITIES + n, BASE_VELOCITIES + n))
        rho[:3, :3], rho[3:6, 3:6] = np.diag(self.spatial.reflection_b), np.diag(self.spatial.axial_reflection_b)
        rho[np.arange(n) + BASE_VELOCITIES, np.array(self.joint_index) + BASE_VELOCITIES] = self.joint_signs
        return rho

    def on_joints(self, angles: Vector) -> Vector:
        """Transformed joint angles, (..., n)."""
        return np.asarray(self.joint_signs) * np.asarray(angles)[..., list(self.joint_index)]

    def of_mechanism(self, tolerances: Tolerances) -> bool:
        """Whether the feet are equivariant."""
        return self.kinematics_error <= tolerances.kinematics

    def of_body(self, tolerances: Tolerances) -> bool:
        """Whether mass matrix and joint limits are so, too."""
        alike = self.mass_error <= tolerances.mass and self.limits_error <= tolerances.limits
        return self.of_mechanism(tolerances) and alike

    def is_symdyns(self) -> bool:
        """Whether permutation and signs are those that reward and networks take from :mod:`symdyn.gait.symmetry`."""
        ours = self.spatial
        return (
            len(self.joint_index) == len(JOINTS)
            and self.leg_index == ours.leg_index
            and self.joint_index == ours.joint_index
            and self.joint_signs == tuple(int(sign) for sign in ours.joint_signs)
        )


@dataclass(frozen=True)
class Morphology:
    """What was found for a robot.

    Attributes:
        robot: its name.
        joints: names in the order that the elements' indices mean.
        elements: e, g_s, g_t, g_r, each as well as the robot has it.
        tolerances: that decide what counts.
    """

    robot: str
    joints: tuple[str, ...]
    elements: tuple[Element, ...]
    tolerances: Tolerances

    def __getitem__(self, name: str) -> Element:
        return next(element for element in self.elements if element.name == name)

    @property
    def mechanism_group(self) -> tuple[str, ...]:
        """Names of the elements that are symmetries of the kinematics."""
        return _subgroup([g for g in self.elements if g.of_mechanism(self.tolerances)])

    @property
    def body_group(self) -> tuple[str, ...]:
        """Names of the elements that are symmetries of kinematics, masses and limits."""
        return _subgroup([g for g in self.elements if g.of_body(self.tolerances)])

    def as_dict(self) -> dict[str, Any]:
        """For JSON, which has no infinity: an error without bound is null."""
        return {
            "robot": self.robot,
            "joints": list(self.joints),
            "legs": list(LEGS),
            "tolerances": asdict(self.tolerances),
            "elements": [
                {key: None if value == np.inf else value for key, value in asdict(g).items()}
                | {"of_mechanism": g.of_mechanism(self.tolerances), "of_body": g.of_body(self.tolerances)}
                for g in self.elements
            ],
            "mechanism_group": list(self.mechanism_group),
            "body_group": list(self.body_group),
        }


def group_name(names: Sequence[str]) -> str:
    """A subgroup of K4 by its structure: 1, C2 or K4."""
    return {1: "1", 2: "C2", 4: "K4"}[len(names)]


def find_morphology(robot: Quadruped, tolerances: Tolerances | None = None) -> Morphology:
    """Every element of K4 as well as the robot has it, with its errors.

    Args:
        robot: any.
        tolerances: that decide what counts; the defaults if left out.
    """
    search = _Search(robot)
    elements = tuple(search.element(g) for g in K4)
    return Morphology(robot.name, robot.joints, elements, tolerances or Tolerances())


def _subgroup(found: list[Element]) -> tuple[str, ...]:
    # two reflections within tolerance whose product is just outside: the better one counts
    if len(found) == len(K4) - 1:
        found = sorted(found, key=lambda g: (g.name != K4[0].name, g.mass_error, g.kinematics_error))[:2]
    return tuple(g.name for g in K4 if g.name in {element.name for element in found})


class _Search:
    """Foot positions at random poses under every combination of signs, computed once for all elements."""

    def __init__(self, robot: Quadruped) -> None:
        self.robot = robot
        self.angles = np.random.default_rng(_SEED).uniform(-np.pi, np.pi, (POSES, len(robot.joints)))
        hips = robot.trunk_joints()
        self.centre = np.array([*hips.mean(axis=0)[:2], 0.0])
        # the joints of all legs get the same angles, so that a leg can be compared with any other
        count = max(len(leg.joints) for leg in robot.legs)
        of_a_leg = self.angles[:, :count]
        self.signs = np.array(list(product((1, -1), repeat=count)))
        every_leg = [slice(0, len(leg.joints)) for leg in robot.legs]
        self.feet = np.array(
            [
                [robot.feet(np.concatenate([(sign * pose)[part] for part in every_leg])) for pose in of_a_leg]
                for sign in self.signs
            ]
        )
        self.feet -= self.centre  # (combinations of signs, poses, legs, 3)
        self.reach = float(np.linalg.norm(self.feet + self.centre - hips, axis=-1).max())

    def element(self, g: Spatial) -> Element:
        """The permutation and signs under which the feet come nearest to being equivariant."""
        robot, legs = self.robot, range(len(LEGS))
        images = g.reflection_b * self.feet[0]  # (poses, legs, 3): R foot of each leg
        errors = np.full((len(LEGS), len(LEGS)), np.inf)
        best = np.zeros((len(LEGS), len(LEGS)), dtype=int)
        for leg, source in product(legs, legs):
            if len(robot.legs[leg].joints) == len(robot.legs[source].joints):
                distance = np.linalg.norm(self.feet[:, :, leg] - images[None, :, source], axis=-1).max(axis=-1)
                best[leg, source], errors[leg, source] = np.argmin(distance), np.min(distance)
        leg_index = min(permutations(legs), key=lambda index: max(errors[leg, index[leg]] for leg in legs))
        joint_index, joint_signs = [], []
        for leg in robot.legs:
            source = leg_index[robot.legs.index(leg)]
            part = robot.joints_of(robot.legs[source])
            joint_index += range(part.start, part.stop)
            joint_signs += self.signs[best[robot.legs.index(leg), source]][: len(leg.joints)].tolist()
        found = Element(
            name=g.name,
            leg_index=tuple(leg_index),
            joint_index=tuple(joint_index),
            joint_signs=tuple(joint_signs),
            kinematics_error=float(max(errors[leg, leg_index[leg]] for leg in legs)) / self.reach,
            mass_error=np.inf,
            limits_error=np.inf,
        )
        return replace(found, mass_error=self._mass_error(found), limits_error=self._limits_error(found))

    def _mass_matrix(self, angles: Vector) -> Vector:
        # with the base's velocity taken at the centre of the hips, about which R acts
        shift = np.eye(BASE_VELOCITIES + len(self.robot.joints))
        x, y, z = self.centre
        shift[:3, 3:6] = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]
        return shift.T @ self.robot.mass_matrix(angles) @ shift

    def _mass_error(self, found: Element) -> float:
        rho, worst = found.representation, 0.0
        for pose in self.angles:
            expected = rho @ self._mass_matrix(pose) @ rho.T
            error = np.linalg.norm(self._mass_matrix(found.on_joints(pose)) - expected)
            worst = max(worst, float(error / np.linalg.norm(expected)))
        return worst

    def _limits_error(self, found: Element) -> float:
        limits, signs = self.robot.limits(), np.array(found.joint_signs)
        images = np.sort(signs * limits[:, list(found.joint_index)], axis=0)
        apart = [
            abs(a - b) for a, b in zip(limits.ravel(), images.ravel(), strict=True) if a != b
        ]  # inf - inf is no number
        return float(max(apart, default=0.0))
