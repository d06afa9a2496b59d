"""Settings of a training run, and the presets."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Literal

import tyro

from rl.physics.engine import EngineConfig
from rl.physics.randomization import RandomizationConfig
from rl.task.commands import CommandConfig
from rl.task.config import EnvConfig, ResetConfig
from rl.task.curriculum import RewardCurriculum
from rl.task.rewards import RewardConfig
from symdyn.errors import InvalidValue, UnknownName
from symdyn.robot.robot_file import DEFAULT_ROBOT

PresetName = Literal["cpu", "polish", "sharpen", "harden", "paper", "smoke"]


@dataclass(frozen=True)
class PPOConfig:
    """PPO as in rsl_rl; the defaults are the paper's (section III-E).

    Attributes:
        hidden: hidden sizes of actor and critic, ELU.
        initial_std: standard deviation of the action noise at the start.
        steps: environment steps between two updates.
        epochs: passes over the data of an update.
        mini_batches: per pass.
        learning_rate: at the start; adapted to ``desired_kl`` between updates.
        desired_kl: target of the adaptation.
        discount: gamma.
        gae_lambda: lambda.
        clip: epsilon.
        entropy: weight of the entropy bonus at the start.
        entropy_final: its weight at ``entropy_anneal_end``; equal to ``entropy`` for a constant one.
        entropy_anneal_start: samples after which it begins to go from the one to the other, linearly.
        entropy_anneal_end: samples after which it has arrived.
        value_weight: of the value loss.
        max_grad_norm: gradients are clipped to it.
        privileged_critic: whether the critic also sees what only the simulator knows.
        equivariant: whether actor and critic are equivariant under the left-right mirror by construction.
        mixed_precision: bfloat16 in the update: ``auto`` where the processor computes with it.
    """

    hidden: tuple[int, ...] = (512, 256, 128)
    initial_std: float = 1.0
    steps: int = 24
    epochs: int = 5
    mini_batches: int = 4
    learning_rate: float = 1e-3
    desired_kl: float = 0.01
    discount: float = 0.99
    gae_lambda: float = 0.95
    clip: float = 0.2
    entropy: float = 0.01
    entropy_final: float = 0.01
    entropy_anneal_start: float = 0.0
    entropy_anneal_end: float = 1.0
    value_weight: float = 1.0
    max_grad_norm: float = 1.0
    privileged_critic: bool = False
    equivariant: bool = False
    mixed_precision: Literal["auto", "on", "off"] = "auto"

    def __post_init__(self) -> None:
        if not self.hidden or min(self.hidden) < 1:
            raise InvalidValue("hidden", self.hidden, "at least one layer, each of at least one unit")
        positive = ("initial_std", "steps", "epochs", "mini_batches", "learning_rate", "desired_kl", "max_grad_norm")
        for name in positive:
            if not getattr(self, name) > 0:
                raise InvalidValue(name, getattr(self, name), "a number > 0")
        for name in ("discount", "gae_lambda"):
            if not 0.0 <= getattr(self, name) <= 1.0:
                raise InvalidValue(name, getattr(self, name), "in [0, 1]")
        if not self.entropy_anneal_start < self.entropy_anneal_end:
            raise InvalidValue("entropy_anneal_end", self.entropy_anneal_end, "larger than entropy_anneal_start")

    def entropy_at(self, samples: int) -> float:
        """Weight of the entropy bonus after so many samples."""
        span = self.entropy_anneal_end - self.entropy_anneal_start
        progress = min(max((samples - self.entropy_anneal_start) / span, 0.0), 1.0)
        return self.entropy + progress * (self.entropy_final - self.entropy)


@dataclass(frozen=True)
class TrainConfig:
    """A training run. Every setting is a flag of ``symdyn train``.

    Attributes:
        preset: where the defaults of this configuration came from.
        robot: name of the robot, or its robot file (symdyn robots lists the names).
        iterations: updates in total, those before a resume included.
        num_envs: robots simulated in parallel.
        seed: of everything random.
        threads: of physics and networks; 0 takes every processor.
        timing: a curves file (symdyn.gait.timing) to sample T(v) and beta(v) from; None takes the paper's constants.
        checkpoint_every: updates between two checkpoints.
        keep_every: checkpoints of every so many updates stay; of the others only the newest two.
        engine: settings of the physics that is learned in.
        env: the task.
        ppo: the learner.
    """

    preset: PresetName = "paper"
    robot: Annotated[str, tyro.conf.arg(metavar="NAME|FILE")] = DEFAULT_ROBOT
    iterations: int = 50_000
    num_envs: int = 2048
    seed: int = 0
    threads: int = 0
    timing: Path | None = None
    checkpoint_every: int = 25
    keep_every: int = 500
    engine: EngineConfig = field(default_factory=EngineConfig)
    env: EnvConfig = field(default_factory=EnvConfig)
    ppo: PPOConfig = field(default_factory=PPOConfig)

    def __post_init__(self) -> None:
        for name in ("iterations", "num_envs", "checkpoint_every", "keep_every"):
            if getattr(self, name) < 1:
                raise InvalidValue(name, getattr(self, name), "a whole number > 0")
        for name in ("seed", "threads"):
            if getattr(self, name) < 0:
                raise InvalidValue(name, getattr(self, name), "a whole number >= 0")
        # advantages are normalised by their standard deviation, which one sample does not have
        most = self.num_envs * self.ppo.steps // 2
        if self.ppo.mini_batches > most:
            raise InvalidValue("ppo.mini_batches", self.ppo.mini_batches, f"at most num_envs * ppo.steps / 2 = {most}")


def _paper() -> TrainConfig:
    # 50,000 updates x 2048 robots x 24 steps = 2.46e9 samples
    return TrainConfig(preset="paper")


def _cpu() -> TrainConfig:
    commands = CommandConfig(
        choose="class",
        noise_keeps_class=True,
        velocity_first_s=(2.0, 6.0),
        velocity_again_s=(2.0, 6.0),
        gait_first_s=(2.0, 6.0),
        gait_again_s=(2.0, 6.0),
        forward_share=0.6,
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
    insistent = replace(
        lenient,
        x_velocity=0.5,
        x_rate=2.5,
        temporal=0.45,
        force_rate=0.04,
        foot_speed_rate=2.0,
    )
    return TrainConfig(
        preset="cpu",
        iterations=6000,
        num_envs=1024,
        env=EnvConfig(
            episode_s=10.0,
            commands=commands,
            reset=ResetConfig(commanded_share=1.0),
            rewards=lenient,
            curriculum=RewardCurriculum(active=True, start=7e6, end=14e6, final=insistent),
        ),
        ppo=PPOConfig(
            epochs=5,
            privileged_critic=True,
            equivariant=True,
            entropy=0.005,
            entropy_final=0.001,
            entropy_anneal_start=12e6,
            entropy_anneal_end=25e6,
        ),
    )


def _polish() -> TrainConfig:
    cpu = _cpu()
    rewards = replace(
        cpu.env.curriculum.final,
        x_velocity=0.6,
        x_rate=4.0,
        temporal=0.6,
        force_rate=0.08,
        kappa=40.0,
        # with the paper's rates these two are saturated for any run of the Go2, and have no slope
        morphological=0.3,
        pair_rate=1.5,
        torque_change=0.15,
        torque_rate=0.015,
        softness=0.5,
    )
    commands = replace(
        cpu.env.commands,
        weights=tuple(1.5 if name == "rotary_gallop" else 1.0 for name in cpu.env.commands.gaits),
        velocity_x=(-2.2, 2.2),  # so that 2 m/s lies within what was learned
        forward_share=0.45,
        velocity_first_s=(1.5, 5.0),
        velocity_again_s=(1.5, 5.0),
        gait_first_s=(1.5, 5.0),
        gait_again_s=(1.5, 5.0),
    )
    return replace(
        cpu,
        preset="polish",
        iterations=1000,
        env=replace(cpu.env, commands=commands, rewards=rewards, curriculum=RewardCurriculum()),
        ppo=replace(
            cpu.ppo, epochs=3, entropy=5e-4, entropy_final=0.0, entropy_anneal_start=0.0, entropy_anneal_end=15e6
        ),
    )


def _sharpen() -> TrainConfig:
    polish = _polish()
    rewards = replace(
        polish.env.rewards,
        x_velocity=0.8,
        x_rate=5.0,
        temporal=0.8,
        force_rate=0.3,  # a foot that merely touches in its swing costs almost what one that stands there does
        foot_speed_rate=3.0,
        morphological=0.6,
        pair_rate=0.6,  # diagonal legs of a trot differ by 1 to 2 rad in sum
        torque_change=0.1,
    )
    return replace(
        polish,
        preset="sharpen",
        env=replace(polish.env, rewards=rewards),
        ppo=replace(polish.ppo, entropy=0.0, entropy_final=0.0),
    )


def _harden() -> TrainConfig:
    sharpen = _sharpen()
    randomization = RandomizationConfig(
        added_mass=(-3.0, 4.0), friction=(0.25, 2.0), push=(-0.5, 0.5), push_interval_s=(3.0, 8.0), late_share=0.3
    )
    return replace(sharpen, preset="harden", env=replace(sharpen.env, randomization=randomization))


def _smoke() -> TrainConfig:
    cpu = _cpu()
    return replace(
        cpu, preset="smoke", iterations=3, num_envs=16, checkpoint_every=1, ppo=replace(cpu.ppo, steps=8, epochs=2)
    )


PRESETS: dict[str, Callable[[], TrainConfig]] = {
    "cpu": _cpu,
    "polish": _polish,
    "sharpen": _sharpen,
    "harden": _harden,
    "paper": _paper,
    "smoke": _smoke,
}
"""``paper``: section III-E of the paper. ``cpu``: what learns fastest on two cores. Each of the next is to be started
from a run of the one before: ``polish``, sudden reversals and less effort; ``sharpen``, exact timing; ``harden``, late
commands, other loads, less friction, harder pushes. ``smoke``: to see it run."""


def preset(name: str) -> TrainConfig:
    """The preset of that name. Raises UnknownName."""
    try:
        return PRESETS[name]()
    except KeyError:
        raise UnknownName("preset", name, PRESETS) from None
