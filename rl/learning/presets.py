"""Presets: complete settings of a training run, by name."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

from rl.learning.config import PPOConfig, TrainConfig
from rl.learning.stages import Criterion, Stage
from rl.physics.engine import ENGINES
from rl.physics.randomization import RandomizationConfig
from rl.task.settings import CommandConfig, EnvConfig, ResetConfig, RewardConfig
from symdyn.errors import UnknownName
from symdyn.gait.library import LIBRARY
from symdyn.io.settings_data import plain


def _paper() -> TrainConfig:
    # 50,000 updates x 2048 robots x 24 steps = 2.46e9 samples
    return TrainConfig(preset="paper")


def _cpu() -> TrainConfig:
    # standing, stepping in place and running exactly straight come later: with them from the start, robots learn to
    # stand before they learn to run (docs/training.md)
    commands = CommandConfig(
        gaits=tuple(LIBRARY),
        noise_keeps_class=True,
        velocity_x=(-2.0, 2.0),
        velocity_y=(-0.4, 0.4),
        yaw_rate=(-1.0, 1.0),
        forward_share=0.55,
        velocity_first_s=(2.0, 6.0),
        velocity_again_s=(2.0, 6.0),
        gait_first_s=(2.0, 6.0),
        gait_again_s=(2.0, 6.0),
    )
    lenient = RewardConfig(
        x_velocity=0.8,
        x_rate=0.8,
        y_rate=4.0,
        yaw_rate=2.0,
        temporal=0.25,
        force_rate=0.01,
        foot_speed_rate=0.8,
        velocity_filter=0.5,
        softness=0.3,
    )
    randomization = RandomizationConfig(delay_s=(0.0, 0.01))
    return TrainConfig(
        preset="cpu",
        iterations=2000,
        num_envs=1024,
        torque_knee=0.5,
        keep_every=25,
        engine=ENGINES["fast"],
        env=EnvConfig(
            episode_s=10.0,
            observation="extended",
            commands=commands,
            reset=ResetConfig(commanded_share=1.0),
            rewards=lenient,
            randomization=randomization,
        ),
        ppo=PPOConfig(hidden=(256, 128, 128), epochs=4, privileged_critic=True, equivariant=True, entropy=0.005),
        stages=_STAGES,
    )


_STAGES = (
    Stage("move", samples=5e6, criterion=Criterion("task/x_velocity_error", at_most=0.45)),
    Stage(
        "keep time",
        samples=4e6,
        ramp=3.5e6,
        settings={
            "env.commands.steered": True,
            "env.commands.stand_share": 0.05,
            "env.commands.in_place_share": 0.06,
            "env.commands.turn_share": 0.5,
            "env.commands.sidestep_share": 0.4,
            "env.commands.hold_share": 0.3,
            "env.commands.lateral_acceleration": 1.1,
            # so that 2 m/s, 0.4 m/s and 1 rad/s lie within what was learned
            "env.commands.velocity_x": [-2.2, 2.2],
            "env.commands.velocity_y": [-0.45, 0.45],
            "env.commands.yaw_rate": [-1.1, 1.1],
            "env.rewards.joint_speed": 0.1,
            "env.rewards.stance": 0.2,
            "env.rewards.x_velocity": 0.5,
            "env.rewards.x_rate": 2.5,
            "env.rewards.y_velocity": 0.4,
            "env.rewards.yaw_velocity": 0.5,
            "env.rewards.yaw_rate": 4.0,
            "env.rewards.temporal": 0.45,
            "env.rewards.force_rate": 0.04,
            "env.rewards.foot_speed_rate": 2.0,
        },
    ),
    Stage(
        "tell gaits apart",
        samples=6e6,
        ramp=2e6,
        settings={
            "env.commands.mixture_share": 0.3,
            "env.commands.velocity_first_s": [1.5, 5.0],
            "env.commands.velocity_again_s": [1.5, 5.0],
            "env.commands.gait_first_s": [1.5, 5.0],
            "env.commands.gait_again_s": [1.5, 5.0],
            "env.rewards.x_velocity": 0.6,
            "env.rewards.x_rate": 4.0,
            "env.rewards.temporal": 0.6,
            "env.rewards.force_rate": 0.08,
            "env.rewards.kappa": 40.0,
            "env.rewards.morphological": 0.3,
            "env.rewards.pair_rate": 1.5,
            "env.rewards.torque_change": 0.15,
            "env.rewards.torque_rate": 0.015,
            "env.rewards.softness": 0.5,
            # asymmetric gaits yaw within every stride: the mean over a second counts for more than the moment
            "env.rewards.velocity_filter": 1.0,
            "env.rewards.yaw_velocity": 0.3,
            "env.rewards.heading": 0.4,
            "ppo.entropy": 0.0005,
        },
    ),
    Stage(
        "all-round",
        samples=8e6,
        settings={
            "env.randomization.added_mass": [-3.0, 3.0],
            "env.randomization.mass_pos_b": [0.15, 0.05, 0.0],
            "env.randomization.com_shift_b": [0.03, 0.02, 0.02],
            "env.randomization.friction": [0.3, 1.6],
            "env.randomization.strength": [0.8, 1.1],
            "env.randomization.gains": [0.8, 1.2],
            "env.randomization.joint_offset": 0.02,
            "env.randomization.delay_s": [0.0, 0.025],
            "env.randomization.slope": math.radians(8.0),
            "env.randomization.push": [-0.5, 0.5],
            "env.randomization.push_interval_s": [4.0, 8.0],
            "ppo.entropy": 0.0,
        },
    ),
    Stage(
        "harden",
        samples=4e6,
        settings={
            **{f"engine.{name}": value for name, value in plain(ENGINES["accurate"]).items()},
            "env.rewards.joint_speed": 0.3,
            "ppo.epochs": 3,
        },
    ),
)
"""Of the default run. First standing costs more than stumbling. Then the reward insists on the clock, while the action
noise is still wide. Then it tells gaits apart that differ by an eighth of a stride, while robots are still alike. Then
robots differ from the model. Last, all of it in the physics of the evaluation."""


def _smoke() -> TrainConfig:
    cpu = _cpu()
    return replace(
        cpu,
        preset="smoke",
        iterations=3,
        num_envs=16,
        checkpoint_every=1,
        candidates=0,
        ppo=replace(cpu.ppo, steps=8, epochs=2),
        stages=(
            Stage("move", samples=128.0),
            Stage("keep time", samples=256.0, settings={"env.rewards.temporal": 0.45}, ramp=128.0),
        ),
    )


DEFAULT_PRESET = "cpu"

PRESETS: dict[str, Callable[[], TrainConfig]] = {"cpu": _cpu, "paper": _paper, "smoke": _smoke}
"""``cpu``: one run in stages, from nothing to a policy that is fit for a robot, on two cores. ``paper``: section III-E
of the paper. ``smoke``: seconds, to see it run."""


def preset(name: str) -> TrainConfig:
    """The preset of that name. Raises UnknownName."""
    try:
        return PRESETS[name]()
    except KeyError:
        raise UnknownName("preset", name, PRESETS) from None
