"""The environment as a reinforcement learner must be able to trust it, on the real simulator."""

from __future__ import annotations

import copy
import functools
import io
import json
import logging
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
import torch
from scipy.spatial.transform import Rotation
from scipy.stats import kstest

from rl.physics.batch import BatchPhysics
from rl.physics.model import build_model
from rl.physics.protocol import RobotState, heading_velocity
from rl.physics.randomization import NOMINAL
from rl.task.commands import CommandConfig
from rl.task.env import EnvConfig, GaitEnv, ResetConfig
from rl.task.privileged import PRIVILEGED
from rl.task.rewards import RewardConfig
from rl.task.termination import TerminationConfig, fallen
from symdyn.errors import InvalidValue
from symdyn.gait.timing import TimingCurve
from symdyn.policy.observation import LAYOUTS
from symdyn.robot.frames import yaw
from tests.robots import GO2

LIVELY = CommandConfig(
    velocity_first_s=(0.1, 0.3), velocity_again_s=(0.1, 0.3), gait_first_s=(0.1, 0.3), gait_again_s=(0.1, 0.3)
)
"""Commands that change all the time."""


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # MuJoCo appends its warnings to MUJOCO_LOG.TXT in the working directory
    monkeypatch.chdir(tmp_path)


@functools.cache
def _compiled() -> mujoco.MjModel:
    return build_model(GO2)


def make(n: int = 4, seed: int = 0, num_threads: int = 1, dump_dir: Path | None = None, **config: Any) -> GaitEnv:
    physics = BatchPhysics(copy.copy(_compiled()), GO2, n, num_threads)
    return GaitEnv(EnvConfig(**config), physics, TimingCurve(), GO2, seed=seed, dump_dir=dump_dir)


def physics_of(env: GaitEnv) -> BatchPhysics:
    assert isinstance(env.physics, BatchPhysics)
    return env.physics


def random_actions(n: int, steps: int, seed: int = 0, scale: float = 1.0) -> torch.Tensor:
    return scale * torch.randn((steps, n, 12), generator=torch.Generator().manual_seed(seed))


def bits(*tensors: torch.Tensor) -> list[bytes]:
    return [tensor.numpy().tobytes() for tensor in tensors]


def trajectory(env: GaitEnv, actions: torch.Tensor) -> list[list[bytes]]:
    """Everything that the learner gets, step by step, to the last bit."""
    found = []
    for action in actions:
        obs, reward, done, extras = env.step(action.clone())
        found.append(bits(obs["policy"], obs["privileged"], reward, done, extras["time_outs"]))
    return found


# what the learner sees


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
    np.testing.assert_allclose(part["dynamics"], env.dynamics)
    mass = [physics_of(env).batch.get_model(i).body_mass.sum() - _compiled().body_mass.sum() for i in range(5)]
    np.testing.assert_allclose(part["dynamics"][:, 0], mass, atol=1e-5)
    # without the noise of the policy's
    np.testing.assert_allclose(part["joint_pos_rel"], state.joint_pos.numpy() - GO2.default_joint_pos, atol=1e-6)
    noisy = obs["policy"][:, LAYOUTS["paper"].slices["joint_pos_rel"]]
    assert 0.0 < float((noisy - part["joint_pos_rel"]).abs().max()) <= 0.01 + 1e-6


def test_heading_velocity_is_that_of_a_frame_that_turns_with_the_yaw_alone() -> None:
    rng, n = np.random.default_rng(0), 200
    attitude = Rotation.from_euler("ZYX", rng.uniform([-3, -0.9, -0.7], [3, 0.9, 0.7], (n, 3)))
    velocity_w, angular_b = rng.normal(size=(2, n, 3))
    zeros = torch.zeros(n, 12)
    state = RobotState(
        base_pos_w=torch.zeros(n, 3),
        base_quat_w=torch.from_numpy(attitude.as_quat(scalar_first=True)),
        base_lin_vel_w=torch.from_numpy(velocity_w),
        base_ang_vel_b=torch.from_numpy(angular_b),
        joint_pos=zeros, joint_vel=zeros, joint_torque=zeros,
        foot_force_w=zeros.view(n, 4, 3), foot_pos_w=zeros.view(n, 4, 3), foot_vel_w=zeros.view(n, 4, 3),
    )  # fmt: skip
    heading = Rotation.from_euler("Z", attitude.as_euler("ZYX")[:, :1])
    expected = np.column_stack([heading.inv().apply(velocity_w)[:, :2], attitude.apply(angular_b)[:, 2]])
    np.testing.assert_allclose(heading_velocity(state).numpy(), expected, atol=1e-12)


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
    env = make(n=8, commands=LIVELY, randomization=replace(NOMINAL, added_mass=(-1.5, 1.5), friction=(0.3, 2.0)))
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


# determinism


def test_the_same_seed_gives_the_same_trajectory_bit_for_bit() -> None:
    actions = random_actions(4, 60)
    config = {"commands": LIVELY, "episode_s": 0.7}
    first = trajectory(make(seed=3, **config), actions)
    assert first == trajectory(make(seed=3, num_threads=2, **config), actions)
    assert first != trajectory(make(seed=4, **config), actions)


def test_robots_begin_differently() -> None:
    env = make(n=32)
    state = env.physics.read()
    for values in (state.joint_pos, state.base_lin_vel_w, state.base_quat_w[:, [0, 3]]):
        assert values.std(dim=0).min() > 0.02
    assert float((state.joint_pos - torch.tensor(GO2.default_joint_pos)).abs().max()) <= 0.1 + 1e-6
    assert float(heading_velocity(state).abs().max()) <= 0.3 + 1e-6
    assert float(state.base_lin_vel_w[:, 2].abs().max()) <= 0.3 + 1e-6
    assert env.phase.std() > 0.2
    assert env.dynamics.std(dim=0).min() > 0.1


def test_each_robot_of_many_moves_as_it_would_alone() -> None:
    n, steps = 5, 40
    env, actions = make(n, commands=LIVELY), random_actions(n, steps, scale=0.5)
    physics = physics_of(env)
    alone = []
    for k in range(n):
        single = BatchPhysics(copy.copy(_compiled()), GO2, 1, 1)
        single.set_dynamics(env.dynamics[k : k + 1, 0].double().numpy(), env.dynamics[k : k + 1, 1].double().numpy())
        single.batch.state[:] = physics.batch.state[k : k + 1]
        alone.append(single)
    default = torch.tensor(GO2.default_joint_pos, dtype=torch.float32)
    for action in actions:
        _, _, done, _ = env.step(action.clone())
        assert not done.any()
        for k, single in enumerate(alone):
            single.step((default + 0.25 * action)[k : k + 1])
            assert single.batch.state[0].tobytes() == physics.batch.state[k].tobytes()


def test_state_dict_in_the_middle_of_an_episode_decides_the_future_bit_for_bit() -> None:
    config = {
        "commands": LIVELY,
        "episode_s": 0.9,
        "rewards": RewardConfig(velocity_filter=0.5, exp_share=0.5),
        "randomization": replace(NOMINAL, added_mass=(-1.5, 1.5), push=(-0.25, 0.25), push_interval_s=(0.1, 0.3),
                                 friction=(0.3, 2.0), observation_noise=True),
    }  # fmt: skip
    env = make(seed=5, **config)
    trajectory(env, random_actions(4, 30, seed=1))
    file = io.BytesIO()
    torch.save(env.state_dict(), file)
    now, future = env.get_observations(), random_actions(4, 60, seed=2)
    expected = trajectory(env, future)
    other = make(seed=6, **config)
    trajectory(other, random_actions(4, 7, seed=3))
    file.seek(0)
    other.load_state_dict(torch.load(file, weights_only=True))
    assert bits(other.get_observations()["policy"]) == bits(now["policy"])
    assert trajectory(other, future) == expected
    dones = {step[3] for step in expected}
    assert len(dones) > 1  # the future held resets


# rewards


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
        _, period = env.duty_and_period()
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
        error = np.abs(expected[:, 0] - env.commands.velocity[:, 0].double().numpy()).mean()
        assert float(extras["log"]["task/x_velocity_error"]) == pytest.approx(error, abs=1e-5)
    assert np.abs(expected - now).max() > 0.05 or strides == 0.0


def test_the_clock_advances_by_dt_over_the_commanded_period() -> None:
    env = make(n=6, commands=LIVELY)
    for action in random_actions(6, 20, scale=0.3):
        before, (_, period) = env.phase.clone(), env.duty_and_period()
        _, _, done, _ = env.step(action.clone())
        moved = env.phase - before - 0.02 / period
        assert (moved - moved.round()).abs()[done == 0].max() < 1e-6


def test_without_the_morphological_term_the_reward_is_the_same_but_for_it() -> None:
    full = make(n=1, seed=2, rewards=RewardConfig(exp_share=1.0))
    ablated = make(n=1, seed=2, rewards=RewardConfig(exp_share=1.0, morphological_term=False))
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


def test_without_time_reversal_backward_robots_have_the_forward_clock() -> None:
    full, ablated = make(n=64, seed=2), make(n=64, seed=2, commands=CommandConfig(time_reversal=False))
    backward = full.commands.velocity[:, 0] < 0
    assert 10 < int(backward.sum()) < 54
    forward_clock = torch.remainder(full.phase[:, None] + full.commands.offsets, 1.0)
    assert torch.allclose(ablated.leg_phases(), forward_clock, atol=1e-6)
    assert torch.allclose(full.leg_phases()[~backward], forward_clock[~backward], atol=1e-6)
    assert torch.allclose(full.leg_phases()[backward], 1.0 - forward_clock[backward], atol=1e-6)
    # and the policy is told so
    clock = LAYOUTS["paper"].slices["clock_sin"]
    told, told_ablated = (env.get_observations()["policy"][:, clock] for env in (full, ablated))
    assert torch.allclose(told[backward], -told_ablated[backward], atol=1e-5)
    assert torch.equal(told[~backward], told_ablated[~backward])


# ends of episodes


def test_a_time_out_ends_the_episode_at_episode_s() -> None:
    env = make(n=3, episode_s=0.3, randomization=NOMINAL, commands=CommandConfig(velocity_first_s=(99.0, 99.0)))
    action = torch.full((3, 12), 0.1)
    for step in range(1, 31):
        velocity = env.commands.velocity.clone()
        obs, _, done, extras = env.step(action.clone())
        ends = step % 15 == 0
        assert done.tolist() == [int(ends)] * 3
        assert extras["time_outs"].tolist() == [float(ends)] * 3
        assert env.episode_length_buf.tolist() == [step % 15] * 3
        last_action = obs["policy"][:, LAYOUTS["paper"].slices["last_action"]]
        assert torch.equal(last_action, torch.zeros(3, 12) if ends else action)
        assert torch.equal(env.commands.velocity, velocity) != ends  # a new episode brings new commands
    assert float(env.physics.read().base_pos_w[:, 2].min()) > 0.3


def test_a_fallen_robot_is_reset_alone() -> None:
    fallen_one, upright = (make(n=4, seed=1, randomization=NOMINAL) for _ in range(2))
    actions = random_actions(4, 10, scale=0.3)
    assert trajectory(fallen_one, actions) == trajectory(upright, actions)
    physics_of(fallen_one).batch.qpos[2, 3:7] = [0.0, 1.0, 0.0, 0.0]  # on its back
    a_obs, a_reward, a_done, a_extras = fallen_one.step(actions[0].clone())
    b_obs, b_reward, b_done, _ = upright.step(actions[0].clone())
    assert a_done.tolist() == [0, 0, 1, 0]
    assert b_done.tolist() == [0, 0, 0, 0]
    assert not a_extras["time_outs"].any()
    assert float(a_extras["log"]["task/fell_per_s"]) == pytest.approx(0.25 / 0.02)
    others = [0, 1, 3]
    assert torch.equal(a_obs["policy"][others], b_obs["policy"][others])
    assert torch.equal(a_obs["privileged"][others], b_obs["privileged"][others])
    assert torch.equal(a_reward[others], b_reward[others])
    states = [physics_of(env).batch.state[others].tobytes() for env in (fallen_one, upright)]
    assert states[0] == states[1]
    assert fallen_one.episode_length_buf.tolist() == [11, 11, 0, 11]
    # it stands again, near the default pose, and its new episode is a normal one
    assert not fallen_one.last_torque[2].any()  # at rest in the pose that it is told to hold
    assert fallen_one.last_torque[others].any()
    state = fallen_one.physics.read()
    assert float(state.base_pos_w[2, 2]) == pytest.approx(0.4)
    assert not fallen(state, TerminationConfig()).any()
    assert not a_obs["policy"][2, LAYOUTS["paper"].slices["last_action"]].any()


@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
def test_episodes_begin_at_up_to_a_share_of_the_commanded_velocity(share: float) -> None:
    commands = CommandConfig(velocity_x=(-2.0, -1.0), velocity_y=(0.5, 1.0))
    env = make(n=200, reset=ResetConfig(joint_noise=0.0, velocity_noise=0.0, commanded_share=share), commands=commands)
    state = env.physics.read()
    velocity = heading_velocity(state)
    ratio = velocity[:, :2] / env.commands.velocity[:, :2]
    assert torch.allclose(ratio[:, 0], ratio[:, 1], atol=1e-5)  # along the commanded direction, whatever the heading
    assert float(yaw(state.base_quat_w).std()) > 1.0
    assert ratio.min() >= -1e-6
    assert ratio.max() <= share + 1e-6
    assert float(ratio.mean()) == pytest.approx(share / 2.0, abs=0.1 * share + 1e-6)
    assert not velocity[:, 2].any()
    # the filter of the judged velocity begins with it
    assert torch.allclose(env.velocity_h, velocity, atol=1e-5)


def test_a_robot_that_falls_as_its_time_is_up_has_fallen() -> None:
    # a time-out would let the learner bootstrap from the value of a robot on its back
    env = make(n=2, episode_s=0.1, randomization=NOMINAL)
    for _ in range(4):
        env.step(torch.zeros(2, 12))
    physics_of(env).batch.qpos[1, 3:7] = [0.0, 1.0, 0.0, 0.0]
    _, _, done, extras = env.step(torch.zeros(2, 12))
    assert done.tolist() == [1, 1]
    assert extras["time_outs"].tolist() == [1.0, 0.0]


@pytest.mark.parametrize(
    ("height", "attitude", "expected"),
    [
        (0.181, (0.0, 0.0, 0.0), False),
        (0.179, (0.0, 0.0, 0.0), True),
        (0.4, (2.0, 0.0, 0.79), False),
        (0.4, (2.0, 0.0, -0.81), True),
        (0.4, (-1.0, 0.99, 0.0), False),
        (0.4, (-1.0, 1.01, 0.0), True),
        (0.4, (-1.0, -1.01, 0.0), True),
        (0.4, (0.0, 0.0, math.pi), True),
        (0.4, (0.0, math.pi, 0.0), True),
    ],
)
def test_fallen(height: float, attitude: tuple[float, float, float], expected: bool) -> None:
    # yaw, pitch, roll
    quat = Rotation.from_euler("ZYX", attitude).as_quat(scalar_first=True)
    zeros, legs = torch.zeros(1, 12), torch.zeros(1, 4, 3)
    state = RobotState(
        torch.tensor([[0.0, 0.0, height]]), torch.from_numpy(quat)[None].float(), torch.zeros(1, 3), torch.zeros(1, 3),
        zeros, zeros, zeros, legs, legs, legs,
    )  # fmt: skip
    assert fallen(state, TerminationConfig()).tolist() == [expected]


def test_pushes_change_the_velocity_of_the_robots_that_are_due() -> None:
    pushed, calm = (
        make(n=3, seed=1, randomization=replace(NOMINAL, push=(p, p), push_interval_s=(0.1, 0.2))) for p in (0.25, 0.0)
    )
    due, steps = pushed.push_due.clone(), [math.ceil(float(t) / 0.02 - 1e-4) for t in pushed.push_due]
    assert float(due.min()) >= 0.1
    assert float(due.max()) <= 0.2
    for step in range(1, min(steps) + 1):
        action = 0.1 * torch.ones(3, 12)
        obs = pushed.step(action)[0]
        calm.step(action)
        change = pushed.physics.read().base_lin_vel_w - calm.physics.read().base_lin_vel_w
        for k in range(3):
            expected = [0.25, 0.25, 0.0] if step == steps[k] else [0.0, 0.0, 0.0]
            assert change[k].tolist() == pytest.approx(expected, abs=1e-6)
    again = [k for k in range(3) if steps[k] == min(steps)]
    for k in again:
        gap = float(pushed.push_due[k]) - min(steps) * 0.02
        assert 0.1 - 1e-6 <= gap <= 0.2 + 1e-6
        # the critic sees the velocity after the push
        seen = obs["privileged"][k, PRIVILEGED.slices["base_lin_vel_b"]]
        assert float(seen.norm()) == pytest.approx(float(pushed.physics.read().base_lin_vel_w[k].norm()), abs=1e-5)


# what goes wrong


def test_a_late_robot_moves_as_one_that_is_told_a_step_later_and_the_others_do_not_notice() -> None:
    # robots 0 and 1 of four are late: told something at step k, they do what a punctual one does when told at k + 1
    late = make(randomization=replace(NOMINAL, late_share=0.5))
    punctual, shifted = make(randomization=NOMINAL), make(randomization=NOMINAL)
    actions = 0.3 * random_actions(4, 8)
    delayed = torch.cat([torch.zeros(1, 4, 12), actions[:-1]])
    for given, then in zip(actions, delayed, strict=True):
        for env, action in ((late, given), (punctual, given), (shifted, then)):
            env.step(action.clone())
        states = [env.physics.read().joint_pos for env in (late, punctual, shifted)]
        assert torch.equal(states[0][:2], states[2][:2])
        assert torch.equal(states[0][2:], states[1][2:])
        assert torch.equal(late.last_action, given), "the policy is told what it said, not what was done"
    assert not torch.equal(states[0][:2], states[1][:2])


def diverge(env: GaitEnv, k: int, value: float = math.nan) -> None:
    physics_of(env).batch.qvel[k, 7] = value


@pytest.mark.parametrize("value", [math.nan, math.inf, 1e30])
def test_a_diverged_simulation_is_reset_alone_and_logged(value: float, caplog: pytest.LogCaptureFixture) -> None:
    sick, well = (make(n=4, seed=1, randomization=NOMINAL) for _ in range(2))
    actions = random_actions(4, 10, scale=0.3)
    trajectory(sick, actions[:5])
    trajectory(well, actions[:5])
    diverge(sick, 2, value)
    with caplog.at_level(logging.WARNING, logger="rl.task.env"):
        obs, reward, done, extras = sick.step(actions[5].clone())
    assert "1 of 4 simulations diverged and are reset: [2]" in caplog.text
    expected_obs, expected_reward, _, _ = well.step(actions[5].clone())
    others = [0, 1, 3]
    for group in ("policy", "privileged"):
        assert torch.equal(obs[group][others], expected_obs[group][others])
        assert torch.isfinite(obs[group]).all()
    assert torch.equal(reward[others], expected_reward[others])
    assert float(reward[2]) == 0.0
    assert done.tolist() == [0, 0, 1, 0]
    assert not extras["time_outs"].any()
    assert all(math.isfinite(float(v)) for v in extras["log"].values())
    # and it goes on as a healthy robot
    for action in actions[6:]:
        obs, reward, done, _ = sick.step(action.clone())
        assert torch.isfinite(obs["policy"]).all()
        assert torch.isfinite(reward).all()
        assert not done.any()


def test_a_diverged_simulation_is_dumped_and_can_be_read_back(tmp_path: Path) -> None:
    env = make(n=3, dump_dir=tmp_path / "diverged")
    env.step(torch.zeros(3, 12))
    command, dynamics = env.commands.state_dict(), env.dynamics.clone()
    diverge(env, 1)
    env.step(torch.zeros(3, 12))
    (file,) = (tmp_path / "diverged").iterdir()
    dump = json.loads(file.read_text())
    assert dump["env"] == 1
    assert dump["commands"]["offsets"] == command["offsets"][1].tolist()
    assert dump["commands"]["velocity"] == command["velocity"][1].tolist()
    assert [float(x) for x in dump["added_mass"]] == [float(dynamics[1, 0])]
    assert [float(x) for x in dump["friction_scale"]] == [float(dynamics[1, 1])]
    assert {name: len(dump[name]) for name in ("qpos", "qvel", "ctrl")} == {"qpos": 19, "qvel": 18, "ctrl": 12}
    assert any(math.isnan(float(x)) for x in dump["qvel"])  # the culprit stands in it


def test_a_simulation_that_diverges_after_the_last_change_of_command_is_dumped(tmp_path: Path) -> None:
    # with the paper's schedule: any time after 10 s
    env = make(n=2, dump_dir=tmp_path / "diverged", commands=CommandConfig(velocity_first_s=(0.02, 0.02)))
    env.step(torch.zeros(2, 12))
    diverge(env, 1)
    env.step(torch.zeros(2, 12))
    (file,) = (tmp_path / "diverged").iterdir()
    assert json.loads(file.read_text())["env"] == 1


def test_an_action_that_is_no_number_ends_its_robots_episode_alone() -> None:
    env, actions = make(n=3), torch.zeros(3, 12)
    actions[1, 4] = math.nan
    obs, reward, done, extras = env.step(actions)
    assert done.tolist() == [0, 1, 0]
    assert torch.isfinite(reward).all()
    assert torch.isfinite(obs["policy"]).all()
    assert all(math.isfinite(float(v)) for v in extras["log"].values())


def test_an_episode_shorter_than_a_step_is_refused() -> None:
    with pytest.raises(InvalidValue, match="episode_s"):
        make(n=1, episode_s=0.01)
