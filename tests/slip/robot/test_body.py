"""A robot as a spring-loaded body, against MuJoCo's model, against statics and pendulums solved by other means."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

import mujoco
import numpy as np
import pinocchio
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import fsolve

from rl.physics.model import build_model, foot_site
from slip.robot.body import Gains, foot_compliance, measure, similar_gains
from slip.robot.quadruped import Leg, Quadruped
from slip.robot.urdf import load_urdf
from symdyn.errors import InvalidValue, SymdynError
from symdyn.gait.timing import GRAVITY
from symdyn.robot.descriptions import urdf_path
from symdyn.robot.legs import JOINTS, LEGS
from tests.robots import GO2
from tests.slip.robot.robots import every_robot, load_body_once, load_robot_once, other_urdf

LATERAL = np.array([0.0, 1.0, 0.0])


# Mass


@every_robot
def test_mass_is_the_sum_of_the_links(name: str) -> None:
    masses = ElementTree.parse(load_robot_once(name).urdf).getroot().findall("link/inertial/mass")
    total = sum(float(mass.get("value", "nan")) for mass in masses)
    assert load_body_once(name).mass == pytest.approx(total, rel=1e-9)


@pytest.fixture(scope="module")
def standing(go2_model: mujoco.MjModel) -> mujoco.MjData:
    """MuJoCo's Go2 in the nominal pose, base at the origin."""
    data = mujoco.MjData(go2_model)
    data.qpos[:7] = [0, 0, 0, 1, 0, 0, 0]
    for name, angle in zip(GO2.joint_names, GO2.default_joint_pos, strict=True):
        data.joint(name).qpos[0] = angle
    mujoco.mj_forward(go2_model, data)
    return data


def test_go2s_mass_centre_and_inertia_are_mujocos(go2_model: mujoco.MjModel, standing: mujoco.MjData) -> None:
    body, masses = load_body_once("go2"), go2_model.body_mass
    assert body.mass == pytest.approx(masses.sum(), rel=1e-9)
    centre = masses @ standing.xipos / masses.sum()
    assert np.abs(body.centre_of_mass - centre).max() < 1e-7
    inertia = 0.0
    for i in range(go2_model.nbody):
        axes = standing.ximat[i].reshape(3, 3)
        x, _, z = standing.xipos[i] - centre
        inertia += (axes @ np.diag(go2_model.body_inertia[i]) @ axes.T)[1, 1] + masses[i] * (x**2 + z**2)
    assert body.pitch_inertia == pytest.approx(inertia, rel=1e-6)


def test_go2s_hips_are_where_its_description_puts_them() -> None:
    root, body = ElementTree.parse(urdf_path(GO2)).getroot(), load_body_once("go2")

    def origin(joint: str) -> np.ndarray:
        element = root.find(f"joint[@name='{joint}']/origin")
        assert element is not None
        return np.array([float(x) for x in element.get("xyz", "").split()])

    for hip, joint in zip(body.hips, GO2.joint_names[1::3], strict=True):
        assert np.allclose(hip, origin(joint) + origin(joint.replace("thigh", "hip")), atol=1e-12)
    assert body.torso_length == pytest.approx(2 * 0.1934)
    assert body.leg_length == GO2.leg_length
    thigh = shank = 0.213  # two equal links: the line from hip to foot bisects the knee
    assert body.hip_to_foot == pytest.approx(np.full(4, (thigh + shank) * math.cos(0.6)))
    assert body.leg_angles == pytest.approx(np.full(4, -0.1)), "0.7 - 1.2 / 2 behind the hips"


# Leg stiffness


def leg_statics(robot: Quadruped, leg: Leg, gains: Gains, force: np.ndarray, held_sideways: bool) -> np.ndarray:
    """Displacement of a foot by a force on it, by solving for the equilibrium of its joints; (3,), m."""
    part, start = robot.joints_of(leg), robot.standing
    before = robot.feet(start)[robot.legs.index(leg)]

    def at(joints: np.ndarray) -> np.ndarray:
        angles = start.copy()
        angles[part] = joints
        return angles

    def displacement(joints: np.ndarray) -> np.ndarray:
        return robot.feet(at(joints))[robot.legs.index(leg)] - before

    def balance(unknowns: np.ndarray) -> np.ndarray:
        joints, lateral = unknowns[:-1], unknowns[-1]
        jacobian = robot.foot_jacobian(leg, robot.placed(at(joints)))
        torque = gains.kp * (start[part] - joints) + jacobian.T @ (force + lateral * LATERAL)
        return np.append(torque, displacement(joints)[1] * 1e3 if held_sideways else lateral)

    return displacement(fsolve(balance, np.append(start[part], 0.0), xtol=1e-13)[:-1])


@every_robot
def test_leg_stiffness_by_statics(name: str) -> None:
    robot, body = load_robot_once(name), load_body_once(name)
    for i, leg in enumerate(robot.legs):
        line = (body.feet[i] - body.hips[i]) * [1, 0, 1]
        line /= np.linalg.norm(line)
        for stiffness, held in ((body.leg_stiffness[i], True), (body.leg_stiffness_sliding[i], False)):
            small = 1e-5 * stiffness  # N: the force of 10 micrometres
            moved = leg_statics(robot, leg, body.gains, -small * line, held) @ line
            assert moved == pytest.approx(-1e-5, rel=1e-3)


@every_robot
def test_compliance_is_symmetric_and_the_planar_foot_is_the_stiffer(name: str) -> None:
    robot, body = load_robot_once(name), load_body_once(name)
    for leg in robot.legs:
        compliance = foot_compliance(robot, leg, robot.placed(robot.standing), body.gains)
        np.testing.assert_allclose(compliance, compliance.T)
        assert np.linalg.eigvalsh(compliance).min() > -1e-12
    assert (body.leg_stiffness >= body.leg_stiffness_sliding * (1 - 1e-9)).all()


def test_go2s_leg_stiffness_in_closed_form() -> None:
    # the line shortens by 2 a sin(knee / 2) / 2 a radian of the knee, and the hip's gain does no work along it
    lever = 0.213 * math.sin(0.6)
    assert load_body_once("go2").leg_stiffness == pytest.approx(np.full(4, GO2.kp / lever**2))


def test_go2_settles_in_mujoco_as_the_planar_stiffness_says() -> None:
    go2_model = build_model(GO2)
    # feet that do not creep
    go2_model.opt.cone, go2_model.opt.impratio = mujoco.mjtCone.mjCONE_ELLIPTIC, 10.0
    body, data = load_body_once("go2"), mujoco.MjData(go2_model)
    data.qpos[2], data.qpos[3] = 0.38, 1.0
    for joint, name, angle in zip(JOINTS, GO2.joint_names, GO2.default_joint_pos, strict=True):
        data.joint(name).qpos[0] = data.actuator(joint).ctrl[0] = angle
    mujoco.mj_forward(go2_model, data)
    sole = np.mean([data.site(foot_site(leg)).xpos[2] - go2_model.geom(foot_site(leg)).size[0] for leg in LEGS])
    unloaded = data.qpos[2] - sole
    for _ in range(round(2.0 / go2_model.opt.timestep)):
        mujoco.mj_step(go2_model, data)
    sunk = unloaded - data.qpos[2]
    weight = body.mass * GRAVITY / 4.0
    # the knee's lever grows as the leg gives way, so that the linear spring is a little too stiff
    assert 0.97 * weight / body.leg_stiffness.mean() < sunk < 1.25 * weight / body.leg_stiffness.mean()
    assert sunk < 0.85 * weight / body.leg_stiffness_sliding.mean()


def test_a_robot_with_two_joints_a_leg() -> None:
    solo8 = other_urdf("solo_description", "robots/solo.urdf")
    body = measure(load_urdf(solo8, srdf=other_urdf("solo_description", "srdf/solo.srdf")))
    # without abduction a foot cannot slide sideways
    np.testing.assert_allclose(body.leg_stiffness, body.leg_stiffness_sliding, rtol=1e-9)


# Swing


def test_go2s_leg_inertia_is_mujocos_with_its_rotor(go2_model: mujoco.MjModel, standing: mujoco.MjData) -> None:
    full = np.zeros((go2_model.nv, go2_model.nv))
    mujoco.mj_fullM(go2_model, standing, full)
    dofs = [go2_model.joint(name).dofadr[0] for name in GO2.joint_names[1::3]]
    assert load_body_once("go2").leg_inertia == pytest.approx(np.diag(full)[dofs], rel=1e-6)


@pytest.mark.parametrize("name", ["a1", "solo12", "anymal_b"])
@pytest.mark.parametrize("by", ["gains", "pendulum"])
def test_swing_frequency_by_letting_a_leg_swing(name: str, by: str) -> None:
    # every joint but the left front leg's second locked, the trunk held: small oscillations, timed
    robot, body = load_robot_once(name), load_body_once(name)
    fixed = pinocchio.buildModelFromUrdf(str(robot.urdf))
    leg = robot.legs[LEGS.index("LF")]
    swinging = leg.joints[1]
    pose = pinocchio.neutral(fixed)
    for joint, angle in zip(robot.joints, robot.standing, strict=True):
        found = fixed.joints[fixed.getJointId(joint)]
        if found.nq == 1:
            pose[found.idx_q] = angle
        else:
            pose[found.idx_q : found.idx_q + 2] = math.cos(angle), math.sin(angle)
    locked = [i for i in range(1, fixed.njoints) if fixed.names[i] != swinging]
    model = pinocchio.buildReducedModel(fixed, locked, pose)
    data = model.createData()
    start = robot.standing[robot.joints.index(swinging)]
    if by == "gains":
        model.gravity.linear = np.zeros(3)

    def configuration(angle: float) -> np.ndarray:
        return np.array([angle]) if model.nq == 1 else np.array([math.cos(angle), math.sin(angle)])

    def acceleration(angle: float, rate: float) -> float:
        torque = body.gains.kp * (start - angle) if by == "gains" else 0.0
        found = pinocchio.aba(model, data, configuration(angle), np.array([rate]), np.array([torque]))
        return float(found[0])

    rest = start if by == "gains" else float(fsolve(lambda x: acceleration(x[0], 0.0), start)[0])
    crossing: Callable[..., float] = lambda t, y: y[0] - rest  # noqa: E731
    crossing.direction = 1.0  # type: ignore[attr-defined]
    omega = body.swing_frequency if by == "gains" else body.pendulum_frequency
    swing = solve_ivp(
        lambda t, y: [y[1], acceleration(*y)], (0.0, 8.0 * math.pi / omega), [rest + 1e-3, 0.0], events=crossing,
        rtol=1e-9, atol=1e-12,
    )  # fmt: skip
    periods = np.diff(swing.t_events[0])
    assert len(periods) >= 2
    # the body's numbers are the mean of four legs that are not quite alike
    assert 2.0 * math.pi / periods.mean() == pytest.approx(omega, rel=5e-3)


# Gains


def test_default_gains_are_dynamically_similar_to_the_go2s() -> None:
    go2 = load_body_once("go2")
    same = similar_gains(go2.mass, float(go2.hip_to_foot.mean()))
    assert (same.kp, same.kd) == pytest.approx((GO2.kp, GO2.kd))
    large = similar_gains(8.0 * go2.mass, 2.0 * float(go2.hip_to_foot.mean()))  # twice as long in every direction
    assert large.kp == pytest.approx(16.0 * GO2.kp)
    assert large.kd == pytest.approx(16.0 * math.sqrt(2.0) * GO2.kd)
    assert load_body_once("a1").gains.source != go2.gains.source


def test_given_gains_and_leg_length_are_taken() -> None:
    robot = load_robot_once("go2")
    once, twice = measure(robot), measure(robot, Gains(2.0 * GO2.kp, GO2.kd), leg_length=0.3)
    np.testing.assert_allclose(twice.leg_stiffness, 2.0 * once.leg_stiffness)
    assert twice.swing_frequency == pytest.approx(math.sqrt(2.0) * once.swing_frequency)
    assert twice.swing_damping_ratio == pytest.approx(once.swing_damping_ratio / math.sqrt(2.0))
    assert twice.leg_length == 0.3


# Bad input


def straight_legged() -> Quadruped:
    return load_urdf(other_urdf("solo_description", "robots/solo12.urdf"))


def test_a_straight_leg_is_no_spring() -> None:
    with pytest.raises(SymdynError, match="LH is straight in the nominal stance"):
        measure(straight_legged())


def test_legs_that_do_not_swing(tmp_path: Path) -> None:
    # every joint of the Go2 turned to turn about the forward axis
    path = tmp_path / "crab.urdf"
    path.write_text(urdf_path(GO2).read_text().replace('xyz="0 1 0"', 'xyz="1 0 0"'))
    with pytest.raises(SymdynError, match=r"no joint of LH .* swings the leg fore and aft"):
        measure(load_urdf(path))


@pytest.mark.parametrize(
    ("kp", "kd"), [(0.0, 1.0), (-1.0, 1.0), (math.nan, 1.0), (math.inf, 1.0), (1.0, -1.0), (1.0, math.nan)]
)
def test_gains_that_are_none(kp: float, kd: float) -> None:
    with pytest.raises(InvalidValue, match=r"k[pd] is"):
        Gains(kp, kd)


@pytest.mark.parametrize("bad", [0.0, -1.0, math.nan])
def test_a_leg_length_that_is_none(bad: float) -> None:
    with pytest.raises(InvalidValue, match="leg_length"):
        measure(load_robot_once("go2"), leg_length=bad)
