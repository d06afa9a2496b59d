"""The settings of the task; apart from the environment, so that they are read without the learner's library."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from rl.physics.randomization import RandomizationConfig
from rl.task.commands import CommandConfig
from rl.task.curriculum import RewardCurriculum
from rl.task.rewards import RewardConfig
from rl.task.termination import TerminationConfig
from symdyn.errors import InvalidValue
from symdyn.policy.observation import get_layout


@dataclass(frozen=True)
class ResetConfig:
    """How an episode begins: the default pose just above the ground, disturbed.

    Attributes:
        joint_noise: half-width on every joint angle, rad.
        velocity_noise: half-width on each component of the trunk's velocity in the heading frame, m/s.
        commanded_share: the trunk already moves at up to this share of the commanded velocity, drawn uniformly: a robot
            that is thrown forward has to run, and finds out what running is worth (cf. the initial states of
            Peng et al. 2018).
    """

    joint_noise: float = 0.1
    velocity_noise: float = 0.3
    commanded_share: float = 0.0

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not 0.0 <= value < math.inf:
                raise InvalidValue(f"reset.{name}", value, "a number >= 0")


@dataclass(frozen=True)
class EnvConfig:
    """Everything about the task.

    Attributes:
        episode_s: length of an episode, s (paper).
        observation: what the policy sees, by its name in symdyn.policy.observation; symdyn gaits --observation lists
            them.
        curriculum: how the reward changes while training.
    """

    episode_s: float = 30.0
    observation: str = "paper"
    commands: CommandConfig = field(default_factory=CommandConfig)
    rewards: RewardConfig = field(default_factory=RewardConfig)
    curriculum: RewardCurriculum = field(default_factory=RewardCurriculum)
    randomization: RandomizationConfig = field(default_factory=RandomizationConfig)
    termination: TerminationConfig = field(default_factory=TerminationConfig)
    reset: ResetConfig = field(default_factory=ResetConfig)

    def __post_init__(self) -> None:
        get_layout(self.observation)
