"""The command line of ``symdyn train``."""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated

import tyro

from rl.learning.config import TrainConfig, preset
from symdyn.errors import InvalidValue
from symdyn.io.command_line import parsed
from symdyn.io.settings_data import differences

_FIRST = (
    "out",
    "resume",
    "start_from",
    "config.preset",
    "config.robot",
    "config.iterations",
    "config.num_envs",
    "config.seed",
    "config.threads",
    "config.timing",
    "config.env.observation",
    "config.env.episode_s",
    "config.env.commands.gaits",
    "config.env.commands.velocity_x",
    "config.env.rewards.x_velocity",
    "config.env.rewards.temporal",
    "config.env.rewards.morphological",
    "config.ppo.learning_rate",
    "config.ppo.epochs",
    "config.ppo.equivariant",
)
"""The twenty options that ``--help`` shows; ``--help-all`` shows all."""


@dataclass(frozen=True)
class TrainArguments:
    """Train one policy for every gait with PPO. --preset sets the defaults shown below: cpu (the default, fastest on
    two cores); polish, sharpen and harden (each started from a run of the one before: sudden reversals and less effort;
    exact timing; delayed commands, loads and pushes); paper (section III-E of the paper); smoke (seconds, to check that
    training runs). Ctrl-C saves the run and prints the command that continues it.

    Attributes:
        out: run directory; runs/DATE-TIME-PRESET if left out.
        resume: run directory to continue, exactly as if it had not been interrupted. Its settings are kept; only
            --iterations, the total, may change.
        start_from: run directory whose networks and optimiser this new run starts with. All other settings may differ.
            RUN/origin.json keeps the number of samples before.
        start_std: standard deviation of the action noise to start with instead of that run's.
        config: settings.
    """

    out: Path | None = None
    resume: Path | None = None
    start_from: Path | None = None
    start_std: float | None = None
    config: Annotated[TrainConfig, tyro.conf.arg(name="")] = field(default_factory=TrainConfig)


def parse(arguments: Sequence[str]) -> TrainArguments:
    """The arguments, with the defaults of the preset or of the run that is resumed.

    Raises:
        SymdynError: for a bad value, an unknown preset, a directory that is no run, or a resumed run's setting changed.
    """
    first = argparse.ArgumentParser(add_help=False, allow_abbrev=False)
    first.add_argument("--preset", default="cpu")
    first.add_argument("--resume", type=Path)
    known, _ = first.parse_known_args(list(arguments))
    if known.resume is None:
        default = preset(known.preset)
    else:
        from rl.learning import config_file, run_dir  # with torch, which help need not wait for

        default = config_file.load(run_dir.existing(known.resume) / run_dir.CONFIG)
    args = parsed(TrainArguments, arguments, "symdyn train", TrainArguments(config=default), first=_FIRST)
    if args.start_std is not None:
        if args.start_from is None:
            raise InvalidValue("--start-std", args.start_std, "left out without --start-from")
        if not 0.0 < args.start_std < math.inf:
            raise InvalidValue("--start-std", args.start_std, "a number > 0")
    if args.resume is not None:
        changed = differences(replace(args.config, iterations=default.iterations), default)
        if changed:
            raise InvalidValue(
                "--resume with other settings", ", ".join(changed), "given without them: a run keeps its own"
            )
        for flag, value in (("--out", args.out), ("--start-from", args.start_from)):
            if value is not None:
                raise InvalidValue(flag, str(value), "left out with --resume, which goes on with a run as it is")
    return args
