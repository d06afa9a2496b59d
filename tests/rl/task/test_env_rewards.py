"""The reward as the environment adds, filters and logs it."""

from __future__ import annotations

import math

import numpy as np
import pytest
import torch
from scipy.spatial.transform import Rotation

from rl.physics.protocol import heading_velocity
from rl.task.privileged import PRIVILEGED
from rl.task.settings import CommandConfig, RewardConfig
from tests.rl.task.envs import make, random_actions


@pytest.mark.parametrize("exp_share", [0.0, 1.0, 0.3])
def test_logged_terms_add_up_to_the_reward(exp_share: float) -> None:
    env = make(n=1, rewards=RewardConfig(exp_share=exp_share))
    clipped = 0
    for action in random_actions(1, 40, scale=0.7):
        _, reward, _, extras = env.step(action.clone())
        terms = {name: float(v) for name, v in extras["log"].items() if name.startswith("reward/")}
        assert len(terms) == 9
        penalty = sum(terms.values())
        expected = (1 - exp_share) * max(0.0, 1.0 + penalty) + exp_share * math.exp(penalty)
        assert float(reward) == pytest.approx(expected, abs=1e-6)
        clipped += penalty < -1.0
        assert all(value <= 0.0 for value in terms.values())
    assert 0 < clipped < 40


def test_terms_lie_within_their_weights() -> None:
    c, env = RewardConfig(), make(n=1, commands=CommandConfig(gaits=("trot",), offset_noise=0.0))
    bounds = {f"reward/{name}": getattr(c, name) for name in (
        "x_velocity", "y_velocity", "yaw_velocity", "base_height", "torque_change", "hip_action", "clearance",
        "temporal", "morphological")}  # fmt: skip
    bounds["reward/temporal"] *= 4.0  # per leg
    lowest = dict.fromkeys(bounds, 0.0)
    for action in random_actions(1, 60, scale=4.0):
        log = env.step(action.clone())[3]["log"]
        for name, weight in bounds.items():
            assert -weight - 1e-6 <= float(log[name]) <= 0.0
            lowest[name] = min(lowest[name], float(log[name]))
    assert max(lowest.values()) < 0.0, lowest  # each of them was felt


@pytest.mark.parametrize("strides", [0.0, 0.5])
def test_judged_velocities_are_low_passed_over_a_share_of_a_stride(strides: float) -> None:
    env = make(n=3, rewards=RewardConfig(velocity_filter=strides))
    expected = heading_velocity(env.physics.read()).double().numpy()
    for action in random_actions(3, 15, scale=0.3):
        period = env.period
        obs, _, done, extras = env.step(action.clone())
        assert not done.any()
        state = env.physics.read()
        world_from_body = Rotation.from_quat(state.base_quat_w.double().numpy(), scalar_first=True)
        heading = Rotation.from_euler("Z", world_from_body.as_euler("ZYX")[:, :1])
        now = heading.inv().apply(state.base_lin_vel_w.double().numpy())
        now[:, 2] = world_from_body.apply(state.base_ang_vel_b.double().numpy())[:, 2]
        # a first-order lag with a time constant of so many strides, exact for a velocity held over the step
        keep = np.exp(-0.02 / (strides * period.double().numpy()))[:, None] if strides else 0.0
        expected = keep * expected + (1.0 - keep) * now
        np.testing.assert_allclose(obs["privileged"][:, PRIVILEGED.slices["velocity_h"]], expected, atol=1e-5)
        for k, name in enumerate(("x_velocity", "y_velocity", "yaw_rate")):
            error = np.abs(expected[:, k] - env.commands.velocity[:, k].double().numpy()).mean()
            assert float(extras["log"][f"task/{name}_error"]) == pytest.approx(error, abs=1e-5)
    assert np.abs(expected - now).max() > 0.05 or strides == 0.0


def test_without_the_morphological_term_the_reward_is_the_same_but_for_it() -> None:
    trot = CommandConfig(gaits=("trot",), offset_noise=0.0)
    full = make(n=1, seed=2, commands=trot, rewards=RewardConfig(exp_share=1.0))
    ablated = make(n=1, seed=2, commands=trot, rewards=RewardConfig(exp_share=1.0, morphological_term=False))
    felt = 0.0
    for action in random_actions(1, 30, scale=0.5):
        _, with_term, _, full_extras = full.step(action.clone())
        obs, without, _, extras = ablated.step(action.clone())
        term = full_extras["log"]["reward/morphological"]
        felt = min(felt, float(term))
        assert "reward/morphological" not in extras["log"]
        assert torch.log(with_term) - torch.log(without) == pytest.approx(float(term), abs=1e-5)
        assert torch.equal(obs["policy"], full.get_observations()["policy"])
    assert felt < -0.01
