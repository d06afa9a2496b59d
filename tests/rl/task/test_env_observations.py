"""What the environment tells the learner, against SciPy and the simulator's own numbers."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import torch
from scipy.spatial.transform import Rotation
from scipy.stats import kstest

from rl.physics.randomization import NOMINAL
from rl.task.privileged import PRIVILEGED
from rl.task.settings import CommandConfig, ResetConfig
from symdyn.policy.observation import LAYOUTS
from tests.rl.task.envs import LIVELY, bits, make, random_actions
from tests.robots import GO2


def test_observation_is_what_the_robot_and_the_command_say() -> None:
    env = make(n=5, randomization=NOMINAL, commands=LIVELY)
    for action in random_actions(5, 10, scale=0.3):
        obs, _, done, _ = env.step(action.clone())
        assert not done.any()
        state, part = env.physics.read(), {name: obs["policy"][:, s] for name, s in LAYOUTS["paper"].slices.items()}
        body = Rotation.from_quat(state.base_quat_w.numpy(), scalar_first=True).inv()
        np.testing.assert_allclose(part["projected_gravity_b"], body.apply([0.0, 0.0, -1.0]), atol=1e-6)
        np.testing.assert_allclose(part["joint_pos_rel"], state.joint_pos.numpy() - GO2.default_joint_pos, atol=1e-6)
        np.testing.assert_allclose(part["joint_vel"], 0.05 * state.joint_vel, rtol=1e-6)
        assert torch.equal(part["last_action"], action)
        assert torch.equal(part["velocity_command"], env.commands.velocity)
        theta, v = env.commands.offsets.double().numpy(), env.commands.velocity[:, 0].double().numpy()
        sense = np.where(v < 0, -1.0, 1.0)[:, None]
        clock = np.sin(sense * 2 * np.pi * (env.phase.double().numpy()[:, None] + theta))
        np.testing.assert_allclose(part["clock_sin"], clock, atol=1e-5)
        np.testing.assert_allclose(part["phase_offset"], theta[:, [1, 2, 0, 3]])
        v_star = np.abs(v) / math.sqrt(9.81 * 0.4)
        delta = env.commands.duty_delta.double().numpy()
        beta = np.clip(0.5588 * (1 + 0.2 * delta * v_star) * np.exp(-0.681 * v_star), 0.1, 0.9)
        np.testing.assert_allclose(part["duty_ratio"], np.column_stack([beta, 1 - beta]), atol=1e-6)


def test_noise_has_the_amplitudes_of_the_table() -> None:
    # robots at rest in the default pose, so that what they should see is known
    n = 400
    env = make(
        n,
        randomization=replace(NOMINAL, observation_noise=True),
        reset=ResetConfig(joint_noise=0.0, velocity_noise=0.0),
        commands=CommandConfig(offset_noise=0.0),
    )
    obs = env.get_observations()["policy"]
    amplitude = {"projected_gravity_b": 0.05, "joint_pos_rel": 0.01, "joint_vel": 1.5 * 0.05}
    for name, bound in amplitude.items():
        clean = torch.tensor([0.0, 0.0, -1.0]) if name == "projected_gravity_b" else torch.zeros(12)
        noise = obs[:, LAYOUTS["paper"].slices[name]] - clean
        assert kstest(noise.flatten().numpy(), "uniform", (-bound, 2 * bound)).pvalue > 1e-4
        for column in noise.T:
            assert -bound - 1e-6 <= float(column.min()) < -0.95 * bound
            assert 0.95 * bound < float(column.max()) <= bound + 1e-6
        correlation = np.corrcoef(noise.numpy().T)
        assert np.abs(correlation - np.eye(len(correlation))).max() < 0.25  # each number has noise of its own
    quiet = make(n, randomization=NOMINAL, commands=CommandConfig(offset_noise=0.0)).get_observations()["policy"]
    for name, part in LAYOUTS["paper"].slices.items():
        if name == "last_action":
            assert not obs[:, part].any()
        elif name not in amplitude:
            # commands and clock come from the same draws in both, and have no noise
            assert torch.equal(obs[:, part], quiet[:, part])


def test_no_number_of_the_observations_is_constant_but_the_commands_that_are() -> None:
    varied = replace(
        NOMINAL,
        added_mass=(-1.5, 1.5),
        friction=(0.3, 2.0),
        strength=(0.9, 1.1),
        delay_s=(0.0, 0.02),
        com_shift_b=(0.01, 0.01, 0.01),
    )
    env = make(n=8, commands=LIVELY, randomization=varied)
    seen: dict[str, list[torch.Tensor]] = {"policy": [], "privileged": []}
    for action in random_actions(8, 60):
        obs = env.step(action.clone())[0]
        for group, rows in seen.items():
            rows.append(obs[group])
    constant = set()
    for group, layout in (("policy", LAYOUTS["paper"]), ("privileged", PRIVILEGED)):
        spread = torch.stack(seen[group]).flatten(0, 1).std(dim=0)
        labels = [f"{term.name}.{label}" for term in layout.terms for label in term.labels]
        constant |= {label for label, value in zip(labels, spread.tolist(), strict=True) if value < 1e-6}
    assert constant == {"velocity_command.v_y", "velocity_command.yaw_rate"}


def test_observations_share_no_memory_between_steps() -> None:
    env = make(n=3)
    kept = [env.get_observations()]
    before = [bits(kept[0]["policy"], kept[0]["privileged"])]
    for action in random_actions(3, 5, scale=3.0):
        obs = env.step(action.clone())[0]
        assert env.get_observations() is obs
        kept.append(obs)
        before.append(bits(obs["policy"], obs["privileged"]))
    assert [bits(obs["policy"], obs["privileged"]) for obs in kept] == before
    assert len({obs[group].data_ptr() for obs in kept for group in ("policy", "privileged")}) == 2 * len(kept)


def test_step_does_not_write_to_the_learners_actions() -> None:
    # rsl_rl stores the tensor that it handed to step() after step() returns
    env = make(n=2, episode_s=0.04)
    for action in random_actions(2, 3):
        given = action.clone()
        env.step(given)
        assert torch.equal(given, action)
