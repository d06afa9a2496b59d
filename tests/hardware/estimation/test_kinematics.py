"""Pinocchio's legs against MuJoCo's, and against the URDF read by hand."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from dataclasses import replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import hardware.estimation.kinematics
from hardware.estimation.kinematics import JointLimits, LegKinematics, rotation, skew
from rl.physics.model import foot_site
from symdyn.errors import FileProblem
from symdyn.robot.descriptions import urdf_path
from symdyn.robot.legs import LEG_JOINTS, LEGS
from tests.robots import GO2

SEEDS = range(10)


@pytest.fixture(scope="module")
def kinematics() -> LegKinematics:
    return LegKinematics(GO2)


def posed(model: mujoco.MjModel, seed: int) -> tuple[mujoco.MjData, np.ndarray]:
    """The trunk at the origin, level, the joints anywhere in their ranges: (12,) rad."""
    limits = JointLimits.of(GO2)
    joint_pos = np.random.default_rng(seed).uniform(limits.lower, limits.upper)
    data = mujoco.MjData(model)
    data.qpos[:7] = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
    for name, angle in zip(GO2.joint_names, joint_pos, strict=True):
        data.joint(name).qpos[0] = angle
    mujoco.mj_forward(model, data)
    return data, joint_pos


@pytest.mark.parametrize("seed", SEEDS)
def test_feet_are_the_trainers_collision_spheres(
    kinematics: LegKinematics, go2_model: mujoco.MjModel, seed: int
) -> None:
    data, joint_pos = posed(go2_model, seed)
    feet = kinematics.feet(joint_pos)
    np.testing.assert_allclose(feet.centre_b, [data.geom(foot_site(leg)).xpos for leg in LEGS], atol=1e-8)
    np.testing.assert_allclose(feet.radius, [go2_model.geom(foot_site(leg)).size[0] for leg in LEGS], atol=1e-8)


@pytest.mark.parametrize("seed", SEEDS)
def test_jacobians_are_mujocos(kinematics: LegKinematics, go2_model: mujoco.MjModel, seed: int) -> None:
    data, joint_pos = posed(go2_model, seed)
    feet = kinematics.feet(joint_pos)
    up_b = np.random.default_rng(seed).normal(size=3)
    up_b /= np.linalg.norm(up_b)
    for i, leg in enumerate(LEGS):
        names = GO2.joint_names[i * len(LEG_JOINTS) : (i + 1) * len(LEG_JOINTS)]
        columns = [go2_model.joint(name).dofadr[0] for name in names]
        body = go2_model.geom(foot_site(leg)).bodyid[0]
        for point, ours in (
            (feet.centre_b[i], feet.centre_jacobian_b[i]),
            (feet.sole_b(up_b)[i], feet.sole_jacobian_b(up_b)[i]),
        ):
            linear, angular = np.zeros((2, 3, go2_model.nv))
            mujoco.mj_jac(go2_model, data, linear, angular, point, body)
            np.testing.assert_allclose(ours, linear[:, columns], atol=1e-8)
            np.testing.assert_allclose(feet.axes_b[i], angular[:, columns], atol=1e-12)


def test_sole_is_below_the_centre(kinematics: LegKinematics) -> None:
    feet = kinematics.feet(GO2.default_joint_pos)
    down = feet.sole_b(np.array([0.0, 0.0, 1.0])) - feet.centre_b
    np.testing.assert_allclose(down, [[0.0, 0.0, -radius] for radius in feet.radius])


def test_left_and_right_are_mirror_images(kinematics: LegKinematics, by_hand: Any) -> None:
    joint_pos = GO2.default_joint_pos + np.random.default_rng(0).uniform(-0.3, 0.3, 12)
    image = kinematics.feet(by_hand.joints(joint_pos)).centre_b
    expected = by_hand.legs(kinematics.feet(joint_pos).centre_b.T).T * [1.0, -1.0, 1.0]
    np.testing.assert_allclose(image, expected, atol=1e-4)  # the feet's meshes are 0.04 mm off their middle


def test_rotors_are_the_trainers(kinematics: LegKinematics, go2_model: mujoco.MjModel) -> None:
    theirs = [go2_model.dof_armature[go2_model.joint(name).dofadr[0]] for name in GO2.joint_names]
    np.testing.assert_allclose(kinematics.model.armature[kinematics.joints], theirs, rtol=1e-12)


def test_mass_is_that_of_all_links(kinematics: LegKinematics) -> None:
    masses = ElementTree.parse(urdf_path(GO2)).getroot().findall("link/inertial/mass")
    assert kinematics.mass == pytest.approx(sum(float(mass.get("value", "nan")) for mass in masses), rel=1e-12)


def test_limits_are_the_urdfs() -> None:
    joints = ElementTree.parse(urdf_path(GO2)).getroot().findall("joint")
    limit = {joint.get("name"): joint.find("limit") for joint in joints}
    limits = JointLimits.of(GO2)
    for i, name in enumerate(GO2.joint_names):
        element = limit[name]
        assert element is not None
        expected = [float(element.get(key, "nan")) for key in ("lower", "upper", "velocity", "effort")]
        assert [limits.lower[i], limits.upper[i], limits.velocity[i], limits.torque[i]] == expected


def test_skew_is_the_cross_product() -> None:
    a, b = np.random.default_rng(0).normal(size=(2, 5, 4, 3))
    np.testing.assert_allclose((skew(a) @ b[..., None])[..., 0], np.cross(a, b), atol=1e-14)
    np.testing.assert_allclose(b @ skew(a[0, 0]).T, np.cross(a[0, 0], b), atol=1e-14)


def test_rotation_is_scipys() -> None:
    quat_w = np.random.default_rng(0).normal(size=4)
    np.testing.assert_allclose(rotation(quat_w), Rotation.from_quat(quat_w, scalar_first=True).as_matrix(), atol=1e-14)


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"joint_names": ("no_such_joint", *GO2.joint_names[1:])}, "no_such_joint"),
        ({"joint_names": GO2.joint_names[:-1]}, "12 joints"),
        ({"foot_links": ("no_such_link", *GO2.foot_links[1:])}, "no_such_link"),
        ({"foot_links": ("RL_hip_rotor", *GO2.foot_links[1:])}, "RL_hip_rotor"),  # a link without a mesh
        ({"urdf": "go2_description/urdf/no_such.urdf"}, "no_such.urdf"),
    ],
)
def test_a_robot_that_its_urdf_does_not_know(change: dict[str, Any], named: str) -> None:
    with pytest.raises(FileProblem, match=named):
        LegKinematics(replace(GO2, **change))


def test_a_file_that_is_no_urdf(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "broken.urdf"
    path.write_text("<robot name='broken'><link name='base'>")
    monkeypatch.setattr(hardware.estimation.kinematics, "urdf_path", lambda robot: path)
    with pytest.raises(FileProblem, match=r"broken\.urdf: cannot be read as a URDF"):
        JointLimits.of(GO2)
