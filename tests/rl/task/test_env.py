"""The environment as a reinforcement learner must be able to trust it, on the real simulator."""

from __future__ import annotations

import copy
import io
import math
from dataclasses import replace

import numpy as np
import pytest
import torch

from rl.physics.batch import BatchPhysics
from rl.physics.dynamics import Dynamics
from rl.physics.protocol import heading_velocity
from rl.physics.randomization import NOMINAL
from rl.task.privileged import PRIVILEGED
from rl.task.settings import CommandConfig, ResetConfig, RewardConfig, TerminationConfig
from rl.task.termination import fallen
from symdyn.errors import InvalidValue
from symdyn.policy.observation import LAYOUTS
from symdyn.robot.frames import yaw
from tests.rl.task.envs import LIVELY, bits, compiled, make, physics_of, random_actions, trajectory
from tests.robots import GO2

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
    assert min(env.physics.dynamics.added_mass.std(), env.physics.dynamics.friction.std()) > 0.1


def test_each_robot_of_many_moves_as_it_would_alone() -> None:
    n, steps = 5, 40
    env, actions = make(n, commands=LIVELY), random_actions(n, steps, scale=0.5)
    physics = physics_of(env)
    alone = []
    for k in range(n):
        single = BatchPhysics(copy.copy(compiled()), GO2, 1, 1)
        single.set_dynamics(Dynamics(**{name: value[k : k + 1] for name, value in vars(physics.dynamics).items()}))
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


# the clock


def test_the_clock_advances_by_dt_over_the_commanded_period() -> None:
    env = make(n=6, commands=LIVELY)
    for action in random_actions(6, 20, scale=0.3):
        before, period = env.phase.clone(), env.period.clone()
        _, _, done, _ = env.step(action.clone())
        moved = env.phase - before - 0.02 / period
        assert (moved - moved.round()).abs()[done == 0].max() < 1e-6


def test_without_time_reversal_backward_robots_have_the_forward_clock() -> None:
    full, ablated = make(n=64, seed=2), make(n=64, seed=2, commands=CommandConfig(time_reversal=False))
    backward = full.commands.velocity[:, 0] < 0
    assert 10 < int(backward.sum()) < 54
    forward_clock = torch.remainder(full.phase[:, None] + full.commands.offsets, 1.0)
    assert torch.allclose(ablated.leg_phases, forward_clock, atol=1e-6)
    assert torch.allclose(full.leg_phases[~backward], forward_clock[~backward], atol=1e-6)
    assert torch.allclose(full.leg_phases[backward], 1.0 - forward_clock[backward], atol=1e-6)
    # and the policy is told so
    clock = LAYOUTS["paper"].slices["clock_sin"]
    told, told_ablated = (env.get_observations()["policy"][:, clock] for env in (full, ablated))
    assert torch.allclose(told[backward], -told_ablated[backward], atol=1e-5)
    assert torch.equal(told[~backward], told_ablated[~backward])


# episodes


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


def test_an_episode_shorter_than_a_step_is_refused() -> None:
    with pytest.raises(InvalidValue, match="episode_s"):
        make(n=1, episode_s=0.01)


# pushes and delays


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


def test_a_late_robot_moves_as_one_that_is_told_a_step_later_and_the_others_do_not_notice() -> None:
    # robots 0 and 1 of four are late: told something at step k, they do what a punctual one does when told at k + 1
    late, punctual, shifted = (make(randomization=NOMINAL, reset=ResetConfig(joint_noise=0.0)) for _ in range(3))
    late.physics.set_dynamics(Dynamics.nominal(4, delay=np.array([GO2.control_dt, GO2.control_dt, 0.0, 0.0])))
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
