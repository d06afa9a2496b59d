"""What the critic is told beyond the policy's observation, against the simulator's own numbers."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from rl.task.privileged import PRIVILEGED
from symdyn.policy.observation import LAYOUTS
from tests.rl.task.envs import LIVELY, compiled, make, physics_of, random_actions
from tests.robots import GO2


def test_privileged_observation_is_what_the_simulator_knows() -> None:
    env = make(n=5, commands=LIVELY)
    for action in random_actions(5, 10, scale=0.3):
        obs, _, done, _ = env.step(action.clone())
        assert not done.any()
    state, part = env.physics.read(), {name: obs["privileged"][:, s] for name, s in PRIVILEGED.slices.items()}
    world_from_body = Rotation.from_quat(state.base_quat_w.numpy(), scalar_first=True)
    velocity_w = state.base_lin_vel_w.double().numpy()
    np.testing.assert_allclose(part["base_lin_vel_b"], world_from_body.inv().apply(velocity_w), atol=1e-5)
    np.testing.assert_allclose(part["base_ang_vel_b"], 0.25 * state.base_ang_vel_b, rtol=1e-6)
    np.testing.assert_allclose(part["foot_force"], 0.01 * state.foot_force_w.norm(dim=-1), rtol=1e-5)
    np.testing.assert_allclose(part["foot_height"], 10.0 * (state.foot_pos_w[..., 2] - 0.0194243), atol=1e-5)
    dynamics = env.physics.dynamics
    np.testing.assert_allclose(part["dynamics"][:, 0], dynamics.added_mass, rtol=1e-6)
    np.testing.assert_allclose(part["dynamics"][:, 1], dynamics.friction, rtol=1e-6)
    mass = [physics_of(env).batch.get_model(i).body_mass.sum() - compiled().body_mass.sum() for i in range(5)]
    np.testing.assert_allclose(part["dynamics"][:, 0], mass, atol=1e-5)
    # without the noise of the policy's
    np.testing.assert_allclose(part["joint_pos_rel"], state.joint_pos.numpy() - GO2.default_joint_pos, atol=1e-6)
    noisy = obs["policy"][:, LAYOUTS["paper"].slices["joint_pos_rel"]]
    assert 0.0 < float((noisy - part["joint_pos_rel"]).abs().max()) <= 0.01 + 1e-6
