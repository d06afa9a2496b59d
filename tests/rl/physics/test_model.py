"""MuJoCo's Go2 against Pinocchio's, which reads the same URDF by itself.

Conventions differ. MuJoCo's free joint has the trunk's linear velocity in the world and its angular velocity in the
body; Pinocchio's free flyer has both in the body. MuJoCo's quaternion begins with w, Pinocchio's ends with it. A zero
of MuJoCo's linear acceleration is one of the world; in Pinocchio's coordinates that is -omega x v.
"""

from __future__ import annotations

import importlib.metadata
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass, replace
from pathlib import Path

import mujoco
import numpy as np
import pinocchio
import pytest

from rl.physics.model import build_model, foot_site
from symdyn.errors import FileProblem, ResourceProblem
from symdyn.robot.definition import JointLimit
from symdyn.robot.descriptions import robots_folder, urdf_path
from symdyn.robot.legs import JOINTS, LEGS
from tests.robots import GO2

GEAR = {"hip": 6.33, "thigh": 6.33, "calf": 6.33 * 45.43 / 23.7}


@dataclass
class Pair:
    """A state in both engines.

    Attributes:
        data: MuJoCo's, forwarded.
        q: (19,) Pinocchio's configuration.
        v: (18,) Pinocchio's velocity.
        to_pinocchio: (18, 18) matrix P with v = P qvel; generalised forces go back by its transpose.
        rest: (18,) Pinocchio's acceleration for MuJoCo's qacc = 0.
    """

    data: mujoco.MjData
    q: np.ndarray
    v: np.ndarray
    to_pinocchio: np.ndarray
    rest: np.ndarray


class Engines:
    """Both engines' models of the Go2."""

    def __init__(self, model: mujoco.MjModel) -> None:
        self.mujoco = model
        self.pinocchio = pinocchio.buildModelFromUrdf(str(urdf_path(GO2)), pinocchio.JointModelFreeFlyer())
        self.data = self.pinocchio.createData()

    def random_state(self, seed: int, moving: bool = True) -> Pair:
        """Any attitude, any joint angles, any velocities."""
        rng, model = np.random.default_rng(seed), self.pinocchio
        data = mujoco.MjData(self.mujoco)
        quat = rng.normal(size=4)
        quat /= np.linalg.norm(quat)
        data.qpos[:3], data.qpos[3:7] = rng.normal(size=3), quat
        if moving:
            data.qvel[:6] = rng.normal(size=6) * [1, 1, 1, 3, 3, 3]
        q, v = pinocchio.neutral(model), np.zeros(model.nv)
        q[:3], q[3:7] = data.qpos[:3], [*quat[1:], quat[0]]
        to_pinocchio = np.zeros((18, 18))
        world_from_body = pinocchio.Quaternion(*quat).matrix()
        to_pinocchio[:3, :3], to_pinocchio[3:6, 3:6] = world_from_body.T, np.eye(3)
        for name in GO2.joint_names:
            joint, angle = model.joints[model.getJointId(name)], rng.uniform(-2.0, 2.0)
            data.joint(name).qpos[0], q[joint.idx_q] = angle, angle
            data.joint(name).qvel[0] = rng.normal() * 5.0 if moving else 0.0
            to_pinocchio[joint.idx_v, self.mujoco.joint(name).dofadr[0]] = 1.0
        mujoco.mj_forward(self.mujoco, data)
        v = to_pinocchio @ data.qvel
        rest = np.zeros(18)
        rest[:3] = -np.cross(v[3:6], v[:3])
        return Pair(data, q, v, to_pinocchio, rest)


@pytest.fixture(scope="module")
def engines(go2_model: mujoco.MjModel) -> Engines:
    return Engines(go2_model)


def urdf() -> ElementTree.Element:
    return ElementTree.parse(urdf_path(GO2)).getroot()


def test_total_mass(engines: Engines) -> None:
    masses = [float(mass.get("value", "nan")) for mass in urdf().findall("link/inertial/mass")]
    assert engines.mujoco.body_mass.sum() == pytest.approx(sum(masses), rel=1e-12)
    assert engines.mujoco.body_mass.sum() == pytest.approx(pinocchio.computeTotalMass(engines.pinocchio), rel=1e-12)


def test_torque_limits_are_the_urdfs_efforts(go2_model: mujoco.MjModel) -> None:
    limits = {joint.get("name"): joint.find("limit") for joint in urdf().findall("joint")}
    for joint, name in zip(JOINTS, GO2.joint_names, strict=True):
        limit = limits[name]
        assert limit is not None
        effort = float(limit.get("effort", "nan"))
        assert go2_model.actuator(joint).forcerange.tolist() == [-effort, effort]
        assert go2_model.actuator(joint).forcelimited[0]
        ends = [float(limit.get(end, "nan")) for end in ("lower", "upper")]
        assert go2_model.joint(name).range.tolist() == ends
        assert go2_model.joint(name).limited[0]


def test_actuator_is_the_papers_pd_controller(go2_model: mujoco.MjModel) -> None:
    data, rng = mujoco.MjData(go2_model), np.random.default_rng(0)
    for _ in range(20):
        q, qd, target = rng.uniform(-1, 1, 12), rng.normal(size=12) * 5, rng.uniform(-2, 2, 12)
        for k, (joint, name) in enumerate(zip(JOINTS, GO2.joint_names, strict=True)):
            data.joint(name).qpos[0], data.joint(name).qvel[0] = q[k], qd[k]
            data.actuator(joint).ctrl[0] = target[k]
        mujoco.mj_forward(go2_model, data)
        limit = np.tile([23.7, 23.7, 45.43], 4)
        expected = np.clip(30.0 * (target - q) - 0.65 * qd, -limit, limit)
        got = np.array([data.actuator(joint).force[0] for joint in JOINTS])
        np.testing.assert_allclose(got, expected, rtol=1e-12)
        applied = np.array([data.joint(name).qfrc_actuator[0] for name in GO2.joint_names])
        np.testing.assert_allclose(applied, expected, rtol=1e-12)


def test_rotor_inertia_is_the_urdfs_times_the_gear_squared(go2_model: mujoco.MjModel) -> None:
    root = urdf()
    axes = {joint.get("name"): joint.find("axis") for joint in root.findall("joint")}
    links = {link.get("name"): link for link in root.findall("link")}
    for name in GO2.joint_names:
        axis, inertia = axes[name], links[name.replace("_joint", "_rotor")].find("inertial/inertia")
        assert axis is not None
        assert inertia is not None
        about = {"1 0 0": "ixx", "0 1 0": "iyy", "0 0 1": "izz"}[axis.get("xyz", "")]
        rotor = float(inertia.get(about, "nan"))
        gear = GEAR[name.split("_")[1]]
        assert go2_model.joint(name).armature[0] == pytest.approx(rotor * gear**2, rel=1e-9)
    assert go2_model.dof_armature[:6].tolist() == [0.0] * 6


@pytest.mark.parametrize("seed", range(10))
def test_mass_matrix(engines: Engines, seed: int) -> None:
    pair = engines.random_state(seed)
    ours = np.zeros((18, 18))
    mujoco.mj_fullM(engines.mujoco, pair.data, ours)
    upper = np.triu(pinocchio.crba(engines.pinocchio, engines.data, pair.q))
    theirs = upper + np.triu(upper, 1).T
    expected = pair.to_pinocchio.T @ theirs @ pair.to_pinocchio + np.diag(engines.mujoco.dof_armature)
    assert np.abs(ours - expected).max() < 1e-6 * np.abs(expected).max()
    np.testing.assert_allclose(np.diag(ours), np.diag(expected), rtol=1e-6)


@pytest.mark.parametrize("seed", range(10))
def test_gravity_torques(engines: Engines, seed: int) -> None:
    pair = engines.random_state(seed, moving=False)
    expected = pair.to_pinocchio.T @ pinocchio.computeGeneralizedGravity(engines.pinocchio, engines.data, pair.q)
    assert np.abs(expected[6:]).max() > 0.1
    assert np.abs(pair.data.qfrc_bias - expected).max() < 1e-6 * np.abs(expected).max()


@pytest.mark.parametrize("seed", range(10))
def test_coriolis_and_centrifugal_forces(engines: Engines, seed: int) -> None:
    pair = engines.random_state(seed)
    bias = pinocchio.rnea(engines.pinocchio, engines.data, pair.q, pair.v, pair.rest)
    expected = pair.to_pinocchio.T @ bias
    assert np.abs(pair.data.qfrc_bias - expected).max() < 1e-6 * np.abs(expected).max()
    # and they are no small part of it
    gravity = pair.to_pinocchio.T @ pinocchio.computeGeneralizedGravity(engines.pinocchio, engines.data, pair.q)
    assert np.abs(expected - gravity).max() > 1.0


@pytest.mark.parametrize("seed", range(10))
def test_forward_kinematics_of_the_feet(engines: Engines, seed: int) -> None:
    pair = engines.random_state(seed)
    model, data = engines.pinocchio, engines.data
    pinocchio.forwardKinematics(model, data, pair.q, pair.v)
    pinocchio.updateFramePlacements(model, data)
    geometry = pinocchio.buildGeomFromUrdf(
        model, str(urdf_path(GO2)), pinocchio.GeometryType.COLLISION, package_dirs=str(robots_folder().parent.parent)
    )
    for leg, link in zip(LEGS, GO2.foot_links, strict=True):
        frame = model.getFrameId(link)
        mesh = next(g.geometry for g in geometry.geometryObjects if g.parentFrame == frame)
        mesh.computeLocalAABB()
        # the contact sphere sits at the centre of the foot's mesh
        centre = (mesh.aabb_local.min_ + mesh.aabb_local.max_) / 2.0
        expected = data.oMf[frame].act(centre)
        assert np.abs(pair.data.site(foot_site(leg)).xpos - expected).max() < 1e-6
        assert np.abs(pair.data.sensor(f"{leg}_pos_w").data - expected).max() < 1e-6
        assert np.abs(pair.data.geom(foot_site(leg)).xpos - expected).max() < 1e-6
        twist = pinocchio.getFrameVelocity(model, data, frame, pinocchio.LOCAL_WORLD_ALIGNED)
        velocity = twist.linear + np.cross(twist.angular, data.oMf[frame].rotation @ centre)
        assert np.abs(pair.data.sensor(f"{leg}_vel_w").data - velocity).max() < 1e-6 * max(1.0, np.abs(velocity).max())
        half_height = (mesh.aabb_local.max_[2] - mesh.aabb_local.min_[2]) / 2.0
        assert engines.mujoco.geom(foot_site(leg)).size[0] == pytest.approx(half_height, rel=1e-5)


def test_only_feet_and_trunk_touch_the_floor(go2_model: mujoco.MjModel) -> None:
    # a robot in the floor up to its trunk: five contacts with the floor, none between its own parts
    data = mujoco.MjData(go2_model)
    data.qpos[2] = 0.02
    mujoco.mj_forward(go2_model, data)
    touching = {go2_model.geom(int(g)).name for contact in data.contact[: data.ncon] for g in contact.geom}
    assert touching == {"floor", "trunk", *(foot_site(leg) for leg in LEGS)}
    for contact in data.contact[: data.ncon]:
        assert "floor" in {go2_model.geom(int(g)).name for g in contact.geom}


def held_in_the_default_pose(go2_model: mujoco.MjModel, seconds: float) -> mujoco.MjData:
    """The robot dropped from a trunk height of 0.4 m, under the PD gains alone."""
    data = mujoco.MjData(go2_model)
    data.qpos[2], data.qpos[3] = 0.4, 1.0
    for joint, name, angle in zip(JOINTS, GO2.joint_names, GO2.default_joint_pos, strict=True):
        data.joint(name).qpos[0] = angle
        data.actuator(joint).ctrl[0] = angle
    for _ in range(round(seconds / go2_model.opt.timestep)):
        mujoco.mj_step(go2_model, data)
    return data


def tilt(data: mujoco.MjData) -> float:
    """Angle between the trunk's z axis and the vertical, rad."""
    return float(np.arccos(data.body(GO2.trunk).xmat.reshape(3, 3)[2, 2]))


@pytest.mark.parametrize("seconds", [2.0, 20.0])
def test_the_default_pose_stands(go2_model: mujoco.MjModel, seconds: float) -> None:
    # the claim beside the stance in go2.toml
    data = held_in_the_default_pose(go2_model, seconds)
    assert data.qpos[2] == pytest.approx(0.35, abs=0.005)
    assert tilt(data) < 0.02
    # loaded feet creep, but slowly: with a pyramidal cone and impratio 1 by 4 to 10 mm/s
    assert max(np.abs(data.sensor(f"{leg}_vel_w").data[:2]).max() for leg in LEGS) < 1.5e-3
    assert np.abs(data.qvel[:6]).max() < 0.05
    # the ground bears the weight, by the four feet alone
    forces = np.array([data.sensor(f"{leg}_force_w").data for leg in LEGS])
    assert -forces.sum(axis=0)[2] == pytest.approx(go2_model.body_mass.sum() * 9.81, rel=0.03)
    assert (-forces[:, 2] > 20.0).all()


@pytest.fixture
def looked_up_anew() -> None:
    """Where example-robot-data lies is not known from an earlier test."""
    robots_folder.cache_clear()


@pytest.mark.usefixtures("looked_up_anew")
def test_without_example_robot_data(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(name: str) -> None:
        raise importlib.metadata.PackageNotFoundError(name)

    monkeypatch.setattr(importlib.metadata, "files", missing)
    with pytest.raises(ResourceProblem, match="example-robot-data is not installed"):
        build_model(GO2)


@pytest.mark.usefixtures("looked_up_anew")
@pytest.mark.parametrize("listed", [None, []])
def test_with_an_example_robot_data_that_holds_no_robots(monkeypatch: pytest.MonkeyPatch, listed: list | None) -> None:
    monkeypatch.setattr(importlib.metadata, "files", lambda name: listed)
    with pytest.raises(ResourceProblem, match="holds no robots"):
        build_model(GO2)


def test_with_a_robot_that_it_does_not_hold() -> None:
    with pytest.raises(FileProblem, match=r"none\.urdf: the description of go2 is missing"):
        build_model(replace(GO2, urdf="example-robot-data:go2_description/urdf/none.urdf"))


def test_with_a_description_that_does_not_exist(tmp_path: Path) -> None:
    with pytest.raises(FileProblem, match=r"none\.urdf: the description of go2 does not exist"):
        build_model(replace(GO2, urdf=str(tmp_path / "none.urdf")))


def test_with_a_foot_that_the_urdf_does_not_have() -> None:
    with pytest.raises(FileProblem, match="has no link 'XX_foot' with a collision mesh"):
        build_model(replace(GO2, legs=replace(GO2.legs, LH=replace(GO2.legs.LH, foot="XX_foot"))))


def test_with_a_joint_that_the_urdf_does_not_have() -> None:
    joints = ("XX_hip_joint", *GO2.legs.LH.joints[1:])
    with pytest.raises(FileProblem, match="has no joint 'XX_hip_joint', which the robot file of go2 names"):
        build_model(replace(GO2, legs=replace(GO2.legs, LH=replace(GO2.legs.LH, joints=joints))))


def test_limits_of_the_robot_file_go_before_those_of_the_urdf() -> None:
    name = GO2.joint_names[4]
    model = build_model(replace(GO2, limits=(JointLimit(name, position=(-0.25, 0.75), torque=9.0),)))
    usual = build_model(GO2)
    assert model.joint(name).range == pytest.approx([-0.25, 0.75])
    assert model.actuator(JOINTS[4]).forcerange == pytest.approx([-9.0, 9.0])
    for joint in set(GO2.joint_names) - {name}:
        assert np.array_equal(model.joint(joint).range, usual.joint(joint).range)


def test_without_a_gear_ratio_no_joint_has_reflected_inertia() -> None:
    model, usual = build_model(replace(GO2, gear_ratio=None)), build_model(GO2)
    dofs = [model.joint(name).dofadr[0] for name in GO2.joint_names]
    assert not model.dof_armature[dofs].any()
    assert (usual.dof_armature[dofs] > 0.0).all()
