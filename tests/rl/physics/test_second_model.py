"""The second model differs in what it says, and in nothing else; its motors are explicit."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from rl.physics.model import FLOOR, TRUNK_GEOM, build_model, foot_site
from rl.physics.second_model import SecondModel
from symdyn.robot.legs import LEGS
from tests.robots import GO2


@pytest.fixture(scope="module")
def models() -> tuple[mujoco.MjModel, mujoco.MjModel]:
    return build_model(GO2), SecondModel().build(GO2)


def test_its_mass_and_friction_are_those_of_the_other_simulator(
    models: tuple[mujoco.MjModel, mujoco.MjModel],
) -> None:
    _, second = models
    assert second.body_mass.sum() == pytest.approx(15.2, abs=0.01)
    assert second.geom(FLOOR).friction[0] == 0.4
    joints = [second.joint(name) for name in GO2.joint_names]
    assert all(joint.frictionloss[0] == 0.2 and joint.damping[0] == 0.1 for joint in joints)
    assert second.geom(foot_site(LEGS[0])).size[0] == pytest.approx(0.022, abs=1e-4)


def test_what_it_does_not_name_is_as_in_the_first(models: tuple[mujoco.MjModel, mujoco.MjModel]) -> None:
    first, second = models
    np.testing.assert_array_equal(first.body_pos, second.body_pos)
    np.testing.assert_array_equal(first.jnt_range, second.jnt_range)
    np.testing.assert_array_equal(first.actuator_gainprm, second.actuator_gainprm)
    np.testing.assert_array_equal(first.actuator_forcerange, second.actuator_forcerange)
    others = [i for i in range(first.nbody) if i != first.body(GO2.trunk).id]
    np.testing.assert_array_equal(first.body_mass[others], second.body_mass[others])


def test_the_capsule_lies_along_the_trunk_and_within_its_length(
    models: tuple[mujoco.MjModel, mujoco.MjModel],
) -> None:
    first, second = models
    axis = np.zeros(3)
    mujoco.mju_rotVecQuat(axis, np.array([0.0, 0.0, 1.0]), second.geom(TRUNK_GEOM).quat)
    np.testing.assert_allclose(np.abs(axis), [1.0, 0.0, 0.0], atol=1e-12)
    radius, half = second.geom(TRUNK_GEOM).size[:2]
    assert radius + half == pytest.approx(first.geom(TRUNK_GEOM).size[0])


def test_a_torque_follows_from_the_state_at_the_beginning_of_a_step(
    models: tuple[mujoco.MjModel, mujoco.MjModel],
) -> None:
    _, model = models
    data = mujoco.MjData(model)
    data.qpos[2] = 1.0  # in the air
    name = GO2.joint_names[1]
    joint = model.joint(name)
    q, speed = GO2.default_joint_pos[1], 1.5
    data.qpos[joint.qposadr[0]], data.qvel[joint.dofadr[0]] = q, speed
    actuator = next(i for i in range(model.nu) if model.actuator_trnid[i, 0] == joint.id)
    data.ctrl[actuator] = q + 0.1
    mujoco.mj_step(model, data)
    assert data.actuator_force[actuator] == pytest.approx(GO2.kp * 0.1 - GO2.kd * speed)
