"""The command line of ``symdyn train``."""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated

import tyro

from rl.learning.config import TrainConfig
from rl.learning.presets import DEFAULT_PRESET, preset
from rl.physics.fitted import ranges
from symdyn.errors import InvalidValue
from symdyn.io.command_line import parsed
from symdyn.io.settings_data import differences
from symdyn.robot.fit import Fit, load_fit
from symdyn.robot.robot_file import get_robot

_FIRST = (
    "settings",
    "write_settings",
    "out",
    "resume",
    "start_from",
    "seeds",
    "config.preset",
    "config.robot",
    "fit",
    "config.iterations",
    "config.num_envs",
    "config.seed",
    "config.threads",
    "config.timing",
    "config.env.observation",
    "config.env.commands.gaits",
    "config.env.commands.velocity_x",
    "config.env.rewards.temporal",
    "config.candidates",
    "config.ppo.equivariant",
)
"""The options that ``--help`` shows; ``--help-all`` shows all."""


@dataclass(frozen=True)
class TrainArguments:
    """Train one policy for every gait with PPO, from nothing to a policy file. --preset sets the defaults shown below:
    cpu (the default: one run in stages, on two cores); paper (section III-E of the paper); smoke (seconds, to check
    that training runs). Settings that change on the way are in the stages of a settings file: --write-settings FILE
    writes one, --settings FILE trains with it. Ctrl-C saves the run and prints the command that continues it.

    Attributes:
        settings: settings file to use instead of a preset, such as RUN/config.yaml.
        write_settings: write the settings to this file and do not train.
        out: run directory; runs/DATE-TIME-PRESET if left out.
        resume: run directory to continue, exactly as if it had not been interrupted. Its settings are kept; only
            --iterations, the total, may change.
        start_from: run directory whose networks and optimiser this new run starts with. All other settings may differ.
            RUN/origin.json keeps the number of samples before.
        fit: file from symdyn identify: strength, gains, delay and encoder offsets are drawn from its intervals. What it
            does not determine, and all else, stays as in the preset. Where stages set such a range, they take it from
            the fit. Joint friction, damping and rotor inertia stay the model's.
        start_std: standard deviation of the action noise to start with instead of that run's.
        seeds: train so many runs that differ in their seed, from --seed upwards, one for each processor at a time, and
            report the spread of what they reach. --resume on their common directory continues all of them.
        config: settings.
    """

    settings: Path | None = None
    write_settings: Path | None = None
    out: Path | None = None
    resume: Path | None = None
    start_from: Path | None = None
    fit: Path | None = None
    start_std: float | None = None
    seeds: int | None = None
    config: Annotated[TrainConfig, tyro.conf.arg(name="")] = field(default_factory=TrainConfig)


def parse(arguments: Sequence[str]) -> TrainArguments:
    """The arguments, with the defaults of the preset or of the run that is resumed.

    Raises:
        SymdynError: for a bad value, an unknown preset, a directory that is no run, or a resumed run's setting changed.
    """
    first = argparse.ArgumentParser(add_help=False, allow_abbrev=False)
    first.add_argument("--preset")
    first.add_argument("--settings", type=Path)
    first.add_argument("--resume", type=Path)
    first.add_argument("--fit", type=Path)
    known, _ = first.parse_known_args(list(arguments))
    if known.preset is not None and known.settings is not None:
        raise InvalidValue("--preset", known.preset, "left out with --settings, which has every setting")
    if known.resume is None and known.settings is None:
        default = preset(known.preset or DEFAULT_PRESET)
    else:
        from rl.learning import config_file, run_dir  # with torch, which help need not wait for

        own = str(known.settings) if known.resume is None else run_dir.existing(known.resume) / run_dir.CONFIG
        default = config_file.load(Path(own))
    fit = None
    if known.fit is not None:
        if known.resume is not None:
            raise InvalidValue("--fit", str(known.fit), "left out with --resume: a run keeps its ranges")
        fit = load_fit(known.fit)
        default = _drawn_from(fit, default)
    args = parsed(TrainArguments, arguments, "symdyn train", TrainArguments(config=default), first=_FIRST)
    if fit is not None:
        fit.check_robot(get_robot(args.config.robot), known.fit)
    if args.start_std is not None:
        if args.start_from is None:
            raise InvalidValue("--start-std", args.start_std, "left out without --start-from")
        if not 0.0 < args.start_std < math.inf:
            raise InvalidValue("--start-std", args.start_std, "a number > 0")
    given = differences(args.config, default)
    for stage in args.config.stages:
        if overruled := [name for name in given if name in stage.settings]:
            raise InvalidValue(
                ", ".join(overruled),
                "given as a flag",
                f"left out: stage {stage.name!r} sets it. Edit a settings file (--write-settings, --settings)",
            )
    if args.resume is not None:
        changed = differences(replace(args.config, iterations=default.iterations), default)
        if changed:
            raise InvalidValue(
                "--resume with settings", ", ".join(changed), "given without them: a run keeps its own settings"
            )
        others = (
            ("--out", args.out),
            ("--start-from", args.start_from),
            ("--settings", args.settings),
            ("--seeds", args.seeds),
        )
        for flag, value in others:
            if value is not None:
                raise InvalidValue(flag, str(value), "left out with --resume, which continues a run as it is")
    return args


def _drawn_from(fit: Fit, config: TrainConfig) -> TrainConfig:
    """The settings with the ranges of a fit: where stages set them, in those stages, else from the beginning."""
    found = {f"env.randomization.{name}": value for name, value in ranges(fit).items()}
    staged = {name for stage in config.stages for name in stage.settings}
    stages = tuple(
        replace(stage, settings={name: found.get(name, value) for name, value in stage.settings.items()})
        for stage in config.stages
    )
    at_once = {name.rpartition(".")[2]: value for name, value in found.items() if name not in staged}
    env = replace(config.env, randomization=replace(config.env.randomization, **at_once))
    return replace(config, env=env, stages=stages)
