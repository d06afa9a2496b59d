"""Left and right: observations, rewards and policies of robots that are each other's mirror image, made by hand."""

from __future__ import annotations

import copy
from typing import TYPE_CHECKING

import mujoco
import numpy as np
import pytest
import torch
from rsl_rl.modules import MLP
from tensordict import TensorDict
from torch import nn
from torch.distributions import Normal, kl_divergence

from rl.learning.config import PPOConfig
from rl.learning.equivariant import EquivariantMLP, Lift, Project, Sheets, mirror_of_actions, mirror_of_groups
from rl.learning.learner import make_ppo
from rl.physics.batch import BatchPhysics
from rl.physics.dynamics import Dynamics
from rl.physics.randomization import NOMINAL
from rl.task.env import GaitEnv
from rl.task.privileged import PRIVILEGED, constant_terms, privileged_terms
from rl.task.settings import CommandConfig, EnvConfig, RewardConfig
from symdyn.errors import InvalidValue
from symdyn.gait.timing import TimingCurve
from symdyn.policy.observation import LAYOUTS
from tests.robots import GO2

if TYPE_CHECKING:
    from rsl_rl.algorithms import PPO

    from tests.rl.physics.real_states import RealStates
    from tests.symdyn.robot.mirrored_by_hand import MirroredByHand

GROUPS = ["policy", "privileged"]


def image_of(group: str, observation: torch.Tensor, by_hand: type[MirroredByHand]) -> torch.Tensor:
    """The mirror image of an observation, term by term, written out."""
    layout = LAYOUTS["paper"] if group == "policy" else PRIVILEGED
    image = observation.clone()
    for name, part in layout.slices.items():
        x = observation[:, part]
        if name in ("projected_gravity_b", "gravity_b", "base_lin_vel_b", "com_shift_b"):
            image[:, part] = x * torch.tensor([1.0, -1.0, 1.0])
        elif name == "base_ang_vel_b":
            image[:, part] = x * torch.tensor([-1.0, 1.0, -1.0])
        elif name in ("velocity_command", "velocity_h"):
            image[:, part] = x * torch.tensor([1.0, -1.0, -1.0])
        elif name in ("joint_pos_rel", "joint_vel", "last_action"):
            image[:, part] = by_hand.joints(x)
        elif name == "phase_offset":
            image[:, part] = x[:, [1, 0, 3, 2]]  # LF, RF, LH, RH
        elif name in ("clock_sin", "clock_cos", "foot_force", "foot_height", "foot_speed"):
            image[:, part] = by_hand.legs(x)
        else:
            assert name in ("duty_ratio", "base_height", "dynamics", "delay"), f"how is {name} mirrored?"
    return image


def mirror(values: torch.Tensor, index: np.ndarray, sign: np.ndarray) -> torch.Tensor:
    return values[..., torch.as_tensor(index)] * torch.as_tensor(sign, dtype=values.dtype)


# the maps


@pytest.mark.parametrize("groups", [["policy"], ["privileged"], GROUPS, GROUPS[::-1]])
def test_map_of_observation_groups_is_the_one_by_hand(groups: list[str], by_hand: type[MirroredByHand]) -> None:
    generator = torch.Generator().manual_seed(0)
    size = {"policy": LAYOUTS["paper"].size, "privileged": PRIVILEGED.size}
    parts = [torch.randn((5, size[group]), generator=generator) for group in groups]
    expected = torch.cat([image_of(group, part, by_hand) for group, part in zip(groups, parts, strict=True)], dim=1)
    assert torch.equal(mirror(torch.cat(parts, dim=1), *mirror_of_groups(groups, LAYOUTS["paper"])), expected)


def test_map_of_actions_is_the_one_by_hand(by_hand: type[MirroredByHand]) -> None:
    action = torch.randn((5, 12), generator=torch.Generator().manual_seed(0))
    assert torch.equal(mirror(action, *mirror_of_actions()), by_hand.joints(action))


@pytest.mark.parametrize("which", ["policy", "privileged", "actions"])
def test_mirror_of_mirror_is_identity(which: str) -> None:
    index, sign = mirror_of_actions() if which == "actions" else mirror_of_groups([which], LAYOUTS["paper"])
    x = torch.randn((5, len(index)), generator=torch.Generator().manual_seed(0))
    once = mirror(x, index, sign)
    assert torch.equal(mirror(once, index, sign), x)
    assert not torch.equal(once, x)


# the simulator


def test_privileged_observation_of_the_mirrored_robot_is_the_mirrored_one(
    real_states: RealStates, by_hand: type[MirroredByHand]
) -> None:
    n, generator = len(real_states.qpos), torch.Generator().manual_seed(0)
    velocity, phases = (torch.randn((n, k), generator=generator) for k in (3, 4))
    default = torch.tensor(GO2.default_joint_pos, dtype=torch.float32)
    flipped = velocity * torch.tensor([1.0, -1.0, -1.0])
    shift = np.random.default_rng(0).normal(scale=0.02, size=(n, 3))
    found = []
    for state, told, clock, shifted in (
        (real_states.state, velocity, phases, shift),
        (real_states.image, flipped, by_hand.legs(phases), shift * [1.0, -1.0, 1.0]),
    ):
        changing = privileged_terms(
            state, told, clock, default, state.base_pos_w[:, 2] - 0.4, state.foot_pos_w[..., 2] - 0.0194
        )
        found.append(PRIVILEGED.assemble(changing | constant_terms(Dynamics.nominal(n, com_shift_b=shifted))))
    original, image = found
    # forces are the least exact: the feet's meshes are off the sagittal plane by 0.04 mm, alike on both sides
    assert torch.allclose(mirror(original, *mirror_of_groups(["privileged"], LAYOUTS["paper"])), image, atol=5e-3)
    assert not torch.allclose(original, image, atol=0.5)


@pytest.fixture(scope="module")
def twins(go2_model: mujoco.MjModel, real_states: RealStates, by_hand: type[MirroredByHand]) -> GaitEnv:
    """Robots in real states and, behind them, their mirror images, told the mirror images of their commands."""
    n = len(real_states.qpos)
    physics = BatchPhysics(copy.copy(go2_model), GO2, 2 * n, num_threads=1)
    commands = CommandConfig(velocity_y=(-0.5, 0.5), yaw_rate=(-1.0, 1.0))
    config = EnvConfig(randomization=NOMINAL, commands=commands, rewards=RewardConfig(exp_share=1.0))
    env = GaitEnv(config, physics, TimingCurve(), GO2)
    physics.batch.qpos = np.concatenate([real_states.qpos, by_hand.qpos(real_states.qpos)])
    physics.batch.qvel = np.concatenate([real_states.qvel, by_hand.qvel(real_states.qvel)])
    physics.batch.qacc_warmstart = 0.0
    told = env.commands
    told.offsets[n:] = by_hand.legs(told.offsets[:n])
    told.velocity[n:] = told.velocity[:n] * torch.tensor([1.0, -1.0, -1.0])
    told.period_delta[n:] = told.period_delta[:n]
    told.duty_delta[n:] = told.duty_delta[:n]
    env.phase[n:] = env.phase[:n]
    env.told = told.velocity.clone()
    env.set_clock()
    env.last_torque[n:] = by_hand.joints(env.last_torque[:n])
    return env


def test_twins_observe_and_earn_the_same(twins: GaitEnv, by_hand: type[MirroredByHand]) -> None:
    # two control steps, eight of the physics: soon after, a foot lands in one world a step before it does in the other
    n, generator = twins.num_envs // 2, torch.Generator().manual_seed(1)
    for _ in range(2):
        action = 0.3 * torch.randn((n, 12), generator=generator)
        obs, reward, done, _ = twins.step(torch.cat([action, by_hand.joints(action)]))
        assert not done.any()
        for group in GROUPS:
            difference = (image_of(group, obs[group][:n], by_hand) - obs[group][n:]).abs()
            # not exact: the trunk's inertia and the feet are a little off the sagittal plane
            assert float(difference.max()) < 0.05
            assert float(difference.median()) < 1e-4
        assert torch.allclose(reward[:n], reward[n:], atol=1e-3)
        assert float(reward[:n].std()) > 0.02


# policies


def equivariant_ppo(env: GaitEnv, equivariant: bool = True) -> PPO:
    torch.manual_seed(0)
    config = PPOConfig(
        hidden=(32, 32), steps=4, epochs=2, mini_batches=2, privileged_critic=True, equivariant=equivariant,
        mixed_precision="off",
    )  # fmt: skip
    ppo = make_ppo(config, env)
    # rsl_rl begins near zero output; far from it a wrong map shows
    with torch.no_grad():
        for parameter in [*ppo.actor.parameters(), *ppo.critic.parameters()]:
            if parameter.dim() > 1:
                parameter.mul_(2.0)
    return ppo


def observations(env: GaitEnv) -> TensorDict:
    return TensorDict({group: env.get_observations()[group].clone() for group in GROUPS}, [env.num_envs])


def image_of_all(obs: TensorDict, by_hand: type[MirroredByHand]) -> TensorDict:
    return TensorDict({group: image_of(group, obs[group], by_hand) for group in GROUPS}, obs.batch_size)


def learn(ppo: PPO, env: GaitEnv, updates: int = 2) -> None:
    """A little of real learning."""
    obs = env.get_observations()
    for _ in range(updates):
        with torch.inference_mode():
            for _ in range(4):
                obs, reward, done, extras = env.step(ppo.act(obs).clone())
                ppo.process_env_step(obs, reward, done, extras)
            ppo.compute_returns(obs)
        ppo.update()


@pytest.mark.parametrize("trained", [False, True])
def test_equivariant_networks_cannot_tell_left_from_right(
    twins: GaitEnv, by_hand: type[MirroredByHand], trained: bool
) -> None:
    ppo = equivariant_ppo(twins)
    if trained:
        learn(ppo, twins)
    obs = observations(twins)
    image = image_of_all(obs, by_hand)
    with torch.no_grad():
        mean, value = ppo.actor(obs), ppo.critic(obs)
        mean_of_image, value_of_image = ppo.actor(image), ppo.critic(image)
    assert torch.allclose(mean_of_image, by_hand.joints(mean), atol=1e-5)
    assert torch.allclose(value_of_image, value, atol=1e-5)
    assert float(mean.std()) > 0.05
    assert float(value.std()) > 0.05


def test_plain_networks_can_tell(twins: GaitEnv, by_hand: type[MirroredByHand]) -> None:
    ppo, obs = equivariant_ppo(twins, equivariant=False), observations(twins)
    image = image_of_all(obs, by_hand)
    with torch.no_grad():
        assert not torch.allclose(ppo.actor(image), by_hand.joints(ppo.actor(obs)), atol=0.1)
        assert not torch.allclose(ppo.critic(image), ppo.critic(obs), atol=0.1)


def mirrored_kl(ppo: PPO, obs: TensorDict, by_hand: type[MirroredByHand]) -> torch.Tensor:
    """KL between the mirrored policy at a state and the policy at the mirrored state, (n,)."""
    with torch.no_grad():
        ppo.actor(obs, stochastic_output=True)
        mean, std = (p.clone() for p in ppo.actor.output_distribution_params)
        ppo.actor(image_of_all(obs, by_hand), stochastic_output=True)
        new_mean, new_std = ppo.actor.output_distribution_params
    # a standard deviation has no sign
    old = Normal(by_hand.joints(mean), by_hand.joints(std).abs())
    return kl_divergence(old, Normal(new_mean, new_std)).sum(dim=1)


def test_kl_divergence_of_an_equivariant_policy_from_its_mirror_image_is_zero(
    twins: GaitEnv, by_hand: type[MirroredByHand]
) -> None:
    obs = observations(twins)
    assert float(mirrored_kl(equivariant_ppo(twins), obs, by_hand).max()) < 1e-6
    assert float(mirrored_kl(equivariant_ppo(twins, equivariant=False), obs, by_hand).mean()) > 0.01


def test_kl_divergence_is_still_zero_after_learning(twins: GaitEnv, by_hand: type[MirroredByHand]) -> None:
    ppo = equivariant_ppo(twins)
    learn(ppo, twins)
    assert float(mirrored_kl(ppo, observations(twins), by_hand).max()) < 1e-6


# the network


def small_network(invariant: bool = False) -> EquivariantMLP:
    torch.manual_seed(0)
    return EquivariantMLP(
        mirror_of_groups(["policy"], LAYOUTS["paper"]),
        None if invariant else mirror_of_actions(),
        (40, 24),
        1 if invariant else 12,
    )


def test_hidden_sheets_change_places_under_the_mirror(by_hand: type[MirroredByHand]) -> None:
    # every layer by itself, not only the whole
    x = torch.randn(10, LAYOUTS["paper"].size)
    straight, mirrored = x, image_of("policy", x, by_hand)
    for layer in list(small_network())[:-1]:
        straight, mirrored = layer(straight), layer(mirrored)
        first, second = straight.chunk(2, dim=1)
        assert torch.allclose(mirrored, torch.cat([second, first], dim=1), atol=1e-6)
        assert not torch.allclose(first, second, atol=0.1)


def test_layers_are_the_formulas_in_their_docstrings(by_hand: type[MirroredByHand]) -> None:
    lift, _, sheets, _, project = small_network()
    assert isinstance(lift, Lift)
    assert isinstance(sheets, Sheets)
    assert isinstance(project, Project)
    x = torch.randn(10, LAYOUTS["paper"].size)
    a, b = (nn.functional.linear(y, lift.weight, lift.bias) for y in (x, image_of("policy", x, by_hand)))
    assert torch.allclose(lift(x), torch.cat([a, b], dim=1), atol=1e-6)
    (p, q), c = sheets.weight, sheets.bias
    expected = torch.cat([a @ p.T + b @ q.T + c, a @ q.T + b @ p.T + c], dim=1)
    assert torch.allclose(sheets(torch.cat([a, b], dim=1)), expected, atol=1e-5)
    a, b, w, c = a[:, :12], b[:, :12], project.weight, project.bias
    expected = a @ w.T + by_hand.joints(b @ w.T) + 0.5 * (c + by_hand.joints(c[None]))
    assert torch.allclose(project(torch.cat([a, b], dim=1)), expected, atol=1e-5)


@pytest.mark.parametrize("invariant", [False, True])
def test_plain_network_is_the_same_function(invariant: bool) -> None:
    network = small_network(invariant)
    x = torch.randn(10, LAYOUTS["paper"].size)
    assert torch.equal(network.plain()(x), network(x))
    tied, untied = (sum(p.numel() for p in net.parameters()) for net in (network, network.plain()))
    assert tied == pytest.approx(untied / 2, rel=0.02)


def test_tied_weights_begin_as_spread_as_those_of_a_plain_network() -> None:
    sizes = (512, 256, 128)
    tied = EquivariantMLP(mirror_of_groups(["policy"], LAYOUTS["paper"]), mirror_of_actions(), sizes, 12).plain()
    for ours, theirs in zip(tied, MLP(LAYOUTS["paper"].size, 12, sizes, "elu"), strict=True):
        if isinstance(theirs, nn.Linear):
            assert isinstance(ours, nn.Linear)
            assert ours.weight.std().item() == pytest.approx(theirs.weight.std().item(), rel=0.05)
            assert ours.weight.abs().max().item() == pytest.approx(theirs.weight.abs().max().item(), rel=0.02)


@pytest.mark.parametrize("invariant", [False, True])
def test_every_weight_learns(invariant: bool) -> None:
    network = small_network(invariant)
    network(torch.randn(64, LAYOUTS["paper"].size)).square().sum().backward()
    for parameter in network.parameters():
        assert parameter.grad is not None
        assert float((parameter.grad.abs() > 0).float().mean()) > 0.9


def test_learning_from_a_robot_is_learning_from_its_mirror_image(by_hand: type[MirroredByHand]) -> None:
    x, target = torch.randn(64, LAYOUTS["paper"].size), torch.randn(64, 12)
    gradients = []
    for inputs, wanted in ((x, target), (image_of("policy", x, by_hand), by_hand.joints(target))):
        network = small_network()
        (network(inputs) - wanted).square().mean().backward()
        gradients.append(torch.cat([p.grad.flatten() for p in network.parameters() if p.grad is not None]))
    assert torch.allclose(*gradients, atol=1e-6)
    assert float(gradients[0].abs().max()) > 1e-3


def test_odd_widths_are_refused() -> None:
    with pytest.raises(InvalidValue, match="even widths"):
        EquivariantMLP(mirror_of_groups(["policy"], LAYOUTS["paper"]), mirror_of_actions(), (32, 15), 12)
