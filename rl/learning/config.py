"""Settings of a training run."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Literal

import tyro

from rl.learning import stages
from rl.learning.stages import Stage
from rl.physics.engine import EngineConfig
from rl.task.settings import EnvConfig
from symdyn.errors import InvalidValue
from symdyn.io.settings_data import plain, rebuild
from symdyn.robot.robot_file import DEFAULT_ROBOT

PresetName = Literal["cpu", "paper", "smoke"]


@dataclass(frozen=True)
class PPOConfig:
    """PPO as in rsl_rl; the defaults are the paper's (section III-E).

    Attributes:
        hidden: hidden sizes of actor and critic, ELU.
        initial_std: standard deviation of the action noise at the start.
        steps: environment steps between two updates.
        epochs: passes over the data of an update.
        mini_batches: number of mini-batches in a pass.
        learning_rate: learning rate at the start; adapted to ``desired_kl`` between updates.
        desired_kl: target of that adaptation: KL divergence of an update.
        discount: discount factor gamma.
        gae_lambda: lambda of the generalised advantage estimate.
        clip: clipping range epsilon of the probability ratio.
        entropy: weight of the entropy bonus.
        value_weight: weight of the value loss.
        max_grad_norm: largest norm of the gradient; a larger one is scaled down.
        privileged_critic: whether the critic also sees quantities that only the simulator has.
        equivariant: whether actor and critic are equivariant under the left-right mirror by construction.
        mixed_precision: bfloat16 in the update; ``auto`` uses it where the processor supports it.
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
            if not 0 < getattr(self, name) < math.inf:
                raise InvalidValue(name, getattr(self, name), "a finite number > 0")
        for name in ("discount", "gae_lambda"):
            if not 0.0 <= getattr(self, name) <= 1.0:
                raise InvalidValue(name, getattr(self, name), "in [0, 1]")
        for name in ("clip", "entropy", "value_weight"):
            if not 0.0 <= getattr(self, name) < math.inf:
                raise InvalidValue(name, getattr(self, name), "a finite number >= 0")


@dataclass(frozen=True)
class TrainConfig:
    """A training run. Every setting but the stages is a flag of ``symdyn train``; a settings file has all of them.

    Attributes:
        preset: set of defaults that this configuration started from.
        robot: name of the robot, or its robot file (symdyn robots lists the names).
        iterations: total number of updates, those before a resume included.
        num_envs: robots simulated in parallel.
        seed: seed of all random numbers.
        threads: threads for physics and networks; 0 uses every processor.
        timing: curves file, as symdyn fit-curves writes it, for T(v) and beta(v); the paper's constants if left out.
        torque_knee: share of the velocity limit from which on a motor's torque falls in training (Robot.torque_knee);
            the robot file's if None.
        checkpoint_every: updates between two checkpoints.
        keep_every: keep the checkpoints of every so many updates; of the others only the newest two remain.
        candidates: how many of the last checkpoints are compared at the end, by validation on commands and seeds that
            no experiment uses; the best of them and their mean becomes RUN/policy.onnx. 0 exports nothing.
        engine: physics of the training.
        env: the task.
        ppo: the learner.
        stages: what changes on the way; empty for nothing. The run ends with its last stage, or with ``iterations``.
    """

    preset: PresetName = "paper"
    robot: Annotated[str, tyro.conf.arg(metavar="NAME|FILE")] = DEFAULT_ROBOT
    iterations: int = 50_000
    num_envs: int = 2048
    seed: int = 0
    threads: int = 0
    timing: Path | None = None
    torque_knee: float | None = None
    checkpoint_every: int = 25
    keep_every: int = 500
    candidates: int = 6
    engine: EngineConfig = field(default_factory=EngineConfig)
    env: EnvConfig = field(default_factory=EnvConfig)
    ppo: PPOConfig = field(default_factory=PPOConfig)
    stages: Annotated[tuple[Stage, ...], tyro.conf.Suppress] = ()

    def __post_init__(self) -> None:
        for name in ("iterations", "num_envs", "checkpoint_every", "keep_every"):
            if getattr(self, name) < 1:
                raise InvalidValue(name, getattr(self, name), "a whole number > 0")
        for name in ("seed", "threads", "candidates"):
            if getattr(self, name) < 0:
                raise InvalidValue(name, getattr(self, name), "a whole number >= 0")
        if self.torque_knee is not None and not 0.0 <= self.torque_knee < 1.0:
            raise InvalidValue("torque_knee", self.torque_knee, "in [0, 1)")
        # advantages are normalised by their standard deviation, which one sample does not have
        most = self.num_envs * self.ppo.steps // 2
        if self.ppo.mini_batches > most:
            raise InvalidValue("ppo.mini_batches", self.ppo.mini_batches, f"at most num_envs * ppo.steps / 2 = {most}")
        stages.check(self.stages)
        for stage in range(len(self.stages)):
            self.in_stage(stage)

    @property
    def samples_per_iteration(self) -> int:
        """Environment steps of one update."""
        return self.num_envs * self.ppo.steps

    @property
    def total_iterations(self) -> int:
        """Updates until the run ends, if no criterion ends a stage earlier."""
        if not self.stages or self.stages[-1].samples is None:
            return self.iterations
        samples = sum(stage.samples or 0.0 for stage in self.stages)
        return min(self.iterations, -int(-samples // self.samples_per_iteration))

    def in_stage(self, stage: int, samples: float | None = None) -> TrainConfig:
        """The settings that hold in a stage. Its result has no stages.

        Args:
            stage: its number, from 0; with none there is only the whole run, which is 0.
            samples: of the stage that lie behind; None for what the stage arrives at.

        Raises:
            InvalidValue, FileProblem: if a stage's setting does not exist or has a bad value.
        """
        data = plain(self)
        data["stages"] = []
        before = data
        for item in self.stages[: stage + 1]:
            settings = {
                name: list(value) if isinstance(value, tuple) else value for name, value in item.settings.items()
            }
            before = data
            data = plain(rebuild(TrainConfig, stages.changed(data, settings), f"stage {item.name!r}"))
        if self.stages and samples is not None:
            data = stages.blend(before, data, stages.share(self.stages[stage], samples))
        return rebuild(TrainConfig, data, "the settings")
