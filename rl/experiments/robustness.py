"""Does it keep its feet: random sequences of commands, and a robot that is not the one it was trained on."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

import numpy as np
import torch
from numpy.typing import NDArray

from rl.experiments import figures
from rl.experiments.result import Result, Subject
from rl.judging.protocols import random_scripts
from rl.judging.target import Target
from rl.physics.batch import BatchPhysics
from rl.physics.model import build_model
from rl.physics.randomization import NOMINAL, RandomizationConfig
from rl.task.env import GaitEnv
from rl.task.settings import CommandConfig, EnvConfig, ResetConfig
from symdyn.gait.library import PAPER_GAITS
from symdyn.policy.steering import Steering

SEQUENCES = 100
TOP_SPEED = 1.8
"""m/s, of the random sequences."""

HOLD_S, SEQUENCE_S = 2.0, 20.0
ROBOTS = 256
EPISODE_S = 30.0
_CHANGES_S = (2.0, 6.0)
_LATERAL_ACCELERATION = 1.0
"""m/s^2; a robot at 2 m/s is told to turn at 0.5 rad/s at most."""

_GOALS = {"late 30 ms": 0.95, "all together": 0.97}


@dataclass(frozen=True)
class World:
    """What a column of the table is like.

    Attributes:
        what: in words.
        randomization: of the robots.
    """

    what: str
    randomization: RandomizationConfig = field(default_factory=RandomizationConfig)


_PAPER = RandomizationConfig()
WORLDS: Mapping[str, World] = MappingProxyType(
    {
        "nominal": World("the nominal robot, no noise", NOMINAL),
        "randomised": World("the paper's randomisation: mass, friction, pushes, noise", _PAPER),
        "pushes": World("the same with pushes of up to 0.5 m/s along x and y", replace(_PAPER, push=(-0.5, 0.5))),
        "payload +3 kg": World("the same with 3 kg on the trunk", replace(_PAPER, added_mass=(3.0, 3.0))),
        "payload -3 kg": World("the same with a trunk 3 kg lighter", replace(_PAPER, added_mass=(-3.0, -3.0))),
        "friction 0.3": World("the same with 0.3 of the friction", replace(_PAPER, friction=(0.3, 0.3))),
        "payload +3 kg behind": World(
            "the same with 3 kg on the trunk, up to 0.15 m before or behind its centre",
            replace(_PAPER, added_mass=(3.0, 3.0), mass_pos_b=(0.15, 0.0, 0.0)),
        ),
        "strength 0.8": World("the same with motors of 0.8 of the torque", replace(_PAPER, strength=(0.8, 0.8))),
        "gains +-20%": World(
            "the same with kp and kd of each joint off by up to 20%", replace(_PAPER, gains=(0.8, 1.2))
        ),
        "slope 10 degrees": World("the same on slopes of up to 10 degrees", replace(_PAPER, slope=math.radians(10.0))),
        "late 20 ms": World("the same with every command 20 ms late", replace(_PAPER, delay_s=(0.02, 0.02))),
        "late 30 ms": World("the same with every command 30 ms late", replace(_PAPER, delay_s=(0.03, 0.03))),
        "all together": World(
            "all of it at half size",
            RandomizationConfig(
                added_mass=(-1.5, 1.5),
                mass_pos_b=(0.075, 0.0, 0.0),
                friction=(0.65, 1.5),
                push=(-0.25, 0.25),
                strength=(0.9, 1.0),
                gains=(0.9, 1.1),
                slope=math.radians(5.0),
                delay_s=(0.0, 0.015),
            ),
        ),
    }
)


def run(subject: Subject, sequences: int = SEQUENCES, robots: int = ROBOTS, seconds: float = EPISODE_S) -> Result:
    """Random sequences on the nominal robot, then many robots in each world."""
    scripts = random_scripts(sequences, PAPER_GAITS, TOP_SPEED, HOLD_S, SEQUENCE_S, subject.seeds[0])
    steps = round(seconds / subject.policy.metadata.control_dt)
    total = sequences + len(WORLDS) * steps
    episodes = replace(subject, watch=lambda done, _: subject.watch(done, total)).simulate({"random": scripts})[
        "random"
    ]
    falls = [episode for episode in episodes if episode.fell_at is not None]
    stood = {}
    for rank, (name, world) in enumerate(WORLDS.items()):
        before = sequences + rank * steps
        fell = _fell(subject, world, robots, seconds, lambda done, before=before: subject.watch(before + done, total))
        stood[name] = float(1.0 - fell.mean())
    return Result(
        name="robustness",
        title="Does it keep its feet?",
        protocol=f"Sequences: {sequences} of a new gait and a new velocity in +-{TOP_SPEED:g} m/s every {HOLD_S:g} s "
        f"for {SEQUENCE_S:g} s, reversals included, nominal robot. Worlds: {robots} robots, episodes of {seconds:g} s, "
        "a new velocity (v_x in +-2 m/s, v_y and yaw rate as in the training) and a new gait each "
        f"{_CHANGES_S[0]:g} to {_CHANGES_S[1]:g} s; "
        + "; ".join(f"{name}: {world.what}" for name, world in WORLDS.items())
        + ".",
        metrics={
            "sequences": {"run": sequences, "fell": len(falls), "falls": [_describe(e) for e in falls]},
            "did_not_fall": stood,
            "robots": robots,
        },
        targets=(
            Target(f"falls in {sequences} random sequences", float(len(falls)), 0.0),
            *(
                Target(f"{name}: share of robots that did not fall", share, _GOALS.get(name, 0.99), at_least=True)
                for name, share in stood.items()
            ),
        ),
        figures={
            "robustness.png": (
                figures.rate_bars(stood, f"{robots} robots, {seconds:g} s ({subject.path.name})", "did not fall"),
                "Share of robots that did not fall.",
            )
        },
    )


def _describe(episode) -> dict:
    """What was commanded when it fell."""
    before = [s for s in episode.script.segments if s.start <= episode.fell_at][-2:]
    return {
        "sequence": episode.script.name,
        "fell_at_s": episode.fell_at,
        "commands": [{"start_s": s.start, "gait": s.gait.name, "velocity_x": s.velocity[0]} for s in before],
    }


def _fell(subject: Subject, world: World, robots: int, seconds: float, watch) -> NDArray[np.bool_]:
    """Which of the robots fell at least once in their first episode, (robots,)."""
    policy = subject.policy
    robot = policy.robot
    physics = BatchPhysics(build_model(robot), robot, robots)
    config = EnvConfig(
        episode_s=2.0 * seconds,  # no robot is put back before the end
        commands=CommandConfig(
            gaits=tuple(policy.gaits),
            velocity_y=policy.metadata.command_range["velocity_y"],
            yaw_rate=policy.metadata.command_range["yaw_rate"],
            lateral_acceleration=_LATERAL_ACCELERATION,
            turn_share=0.5,
            sidestep_share=0.5,
            velocity_first_s=_CHANGES_S,
            velocity_again_s=_CHANGES_S,
            gait_first_s=_CHANGES_S,
            gait_again_s=_CHANGES_S,
            time_reversal=subject.time_reversal,
            steered=policy.metadata.steering is not None,
            steering=policy.metadata.steering or Steering(),
        ),
        randomization=world.randomization,
        reset=ResetConfig(),
    )
    env = GaitEnv(config, physics, policy.timing, robot, seed=subject.seeds[0], layout=policy.metadata.observation)
    fell = np.zeros(robots, dtype=np.bool_)
    obs = env.get_observations()["policy"]
    for step in range(round(seconds / robot.control_dt)):
        actions = torch.from_numpy(policy.act(obs.numpy())).float()
        found, _, dones, _ = env.step(actions)
        obs = found["policy"]
        fell |= dones.numpy().astype(np.bool_)
        watch(step + 1)
    return fell
