"""``symdyn train``: PPO, resumable at every checkpoint."""

from __future__ import annotations

from rl.physics.threads import wait_passively

wait_passively()  # before torch

import argparse  # noqa: E402
import contextlib  # noqa: E402
import math  # noqa: E402
import shlex  # noqa: E402
from collections.abc import Sequence  # noqa: E402
from dataclasses import dataclass, field, replace  # noqa: E402
from pathlib import Path  # noqa: E402
from typing import TYPE_CHECKING, Annotated, Any  # noqa: E402

import torch  # noqa: E402
import tyro  # noqa: E402
from rich.console import Console  # noqa: E402
from rich.progress import Progress  # noqa: E402

from rl.judging.selection import select  # noqa: E402
from rl.learning import checkpoint, config_file, run_dir, run_lock, run_log  # noqa: E402
from rl.learning.config import TrainConfig  # noqa: E402
from rl.learning.display import TrainingDisplay  # noqa: E402
from rl.learning.presets import DEFAULT_PRESET, preset  # noqa: E402
from symdyn.errors import InvalidValue  # noqa: E402
from symdyn.io.console import log_to, make_console  # noqa: E402
from symdyn.io.exit_codes import INTERRUPTED  # noqa: E402
from symdyn.io.origin import commit  # noqa: E402
from symdyn.io.settings_data import differences  # noqa: E402

if TYPE_CHECKING:
    from rl.learning.trainer import Trainer


@dataclass(frozen=True)
class TrainArguments:
    """Train one policy for every gait with PPO, from nothing to a policy file. Presets: cpu (the default: one run in
    stages, on two cores), paper (section III-E of the paper), smoke (seconds, to see that it runs). --preset sets the
    defaults shown below; every one of them is a flag. What changes on the way stands in the stages of a settings file:
    --write-settings mine.yaml writes the preset's, --settings mine.yaml trains with yours. Ctrl-C saves and says how to
    go on.

    Attributes:
        settings: a settings file, such as RUN/config.yaml, to take instead of a preset.
        write_settings: write the settings to this file instead of training.
        out: directory of the new run; runs/DATE-TIME-PRESET if left out.
        resume: directory of a run to go on with, exactly as if it had not been interrupted. Its settings are kept; only
            --iterations, the total, may be given anew.
        start_from: directory of a run whose networks and optimiser this new run begins with. All else is new, and every
            setting but those of the networks may differ; how many samples lie behind them is kept in RUN/origin.json.
        start_std: standard deviation of the action noise to start with instead of that run's.
        config: settings.
    """

    settings: Path | None = None
    write_settings: Path | None = None
    out: Path | None = None
    resume: Path | None = None
    start_from: Path | None = None
    start_std: float | None = None
    config: Annotated[TrainConfig, tyro.conf.arg(name="")] = field(default_factory=TrainConfig)


def run(arguments: Sequence[str]) -> int:
    """The command. Raises SymdynError for bad input."""
    args = parse(arguments)
    console = make_console(lasting=True)
    log_to(console)
    if args.write_settings is not None:
        config_file.save(args.config, args.write_settings)
        console.print(f"Wrote {args.write_settings}. To train with it:")
        console.print(f"  symdyn train --settings {shlex.quote(str(args.write_settings))}", soft_wrap=True)
        return 0
    if args.resume is not None:
        return _train(args.resume, args, console)
    if args.out is not None:
        run_dir.check_fresh(args.out)
        return _train(args.out, args, console)
    reserved = run_dir.reserve(args.config.preset)
    try:
        return _train(reserved, args, console)
    finally:
        with contextlib.suppress(OSError):
            reserved.rmdir()  # if it is still empty, the settings were refused
            reserved.parent.rmdir()


def parse(arguments: Sequence[str]) -> TrainArguments:
    """The arguments, with the defaults of the preset or of the run that is resumed.

    Raises:
        SymdynError: for a bad value, an unknown preset, a directory that is no run, or a resumed run's setting changed.
    """
    first = argparse.ArgumentParser(add_help=False, allow_abbrev=False)
    first.add_argument("--preset")
    first.add_argument("--settings", type=Path)
    first.add_argument("--resume", type=Path)
    known, _ = first.parse_known_args(list(arguments))
    if known.resume is not None:
        default = config_file.load(run_dir.existing(known.resume) / run_dir.CONFIG)
    elif known.settings is not None:
        if known.preset is not None:
            raise InvalidValue("--preset", known.preset, "left out with --settings, which has every setting")
        default = config_file.load(known.settings)
    else:
        default = preset(known.preset or DEFAULT_PRESET)
    args = tyro.cli(TrainArguments, args=list(arguments), default=TrainArguments(config=default), prog="symdyn train")
    if args.start_std is not None:
        if args.start_from is None:
            raise InvalidValue("--start-std", args.start_std, "left out without --start-from")
        if not 0.0 < args.start_std < math.inf:
            raise InvalidValue("--start-std", args.start_std, "a number > 0")
    given = differences(args.config, default)
    for stage in args.config.stages:
        for name in given:
            if name in stage.settings:
                raise InvalidValue(
                    f"--{name.replace('_', '-')}",
                    "a flag",
                    f"left out: stage {stage.name!r} sets {name}. Change it there (--write-settings, --settings)",
                )
    if args.resume is not None:
        changed = differences(replace(args.config, iterations=default.iterations), default)
        if changed:
            raise InvalidValue(
                "--resume with other settings", ", ".join(changed), "given without them: a run keeps its own"
            )
        others = (("--out", args.out), ("--start-from", args.start_from), ("--settings", args.settings))
        for flag, value in others:
            if value is not None:
                raise InvalidValue(flag, str(value), "left out with --resume, which goes on with a run as it is")
    return args


def _train(directory: Path, args: TrainArguments, console: Console) -> int:
    from rl.learning.trainer import Trainer  # two seconds' worth of the learner's library, which --help does without

    config = args.config
    if config.threads:
        torch.set_num_threads(config.threads)
    trainer = Trainer(config, directory)  # refuses bad settings before anything is written
    started_from = None
    if args.start_from is not None:
        started_from = trainer.start_from(args.start_from, args.start_std)
        console.print(f"Starting from {args.start_from}, after {started_from['samples'] / 1e6:.3g} million samples.")
    with run_lock.held(directory):
        if args.resume is None:
            run_dir.check_fresh(directory)
        elif checkpoint.list_checkpoints(directory) or run_log.read(directory):
            trainer.resume()
            console.print(f"Going on with {directory} after {trainer.iteration} updates.")
        start(trainer, started_from)
        return _run(trainer, console)


def _run(trainer: Trainer, console: Console) -> int:
    config, directory = trainer.config, trainer.run
    samples = config.total_iterations * config.samples_per_iteration
    console.print(
        f"Training {directory} (preset {config.preset}, {trainer.robot.name}): {config.num_envs} robots, "
        f"{config.total_iterations} updates, "
        f"{samples / 1e6:.3g} million samples. Curves: tensorboard --logdir {directory}"
    )
    with TrainingDisplay(console, config) as display:
        done = trainer.train(display.update)
    if not done:
        console.print(f"Stopped after {trainer.iteration} of {config.iterations} updates. To go on:")
        console.print(f"  symdyn train --resume {directory}")
        return INTERRUPTED
    console.print(f"Done after {trainer.iteration} updates.")
    if config.candidates:
        console.print(_select(trainer, console), soft_wrap=True)
    console.print("Next:")
    if not config.candidates:
        console.print(f"  symdyn export {shlex.quote(str(directory))}", soft_wrap=True)
    robot, policy = run_dir.robot_flag(config.robot), shlex.quote(str(directory / run_dir.POLICY))
    console.print(f"  symdyn evaluate {policy} --suite quick{robot}", soft_wrap=True)
    console.print(f"  symdyn play {policy}{robot}", soft_wrap=True)
    return 0


def _select(trainer: Trainer, console: Console) -> str:
    with Progress(console=console, disable=not console.is_terminal) as progress:
        task = progress.add_task("comparing late checkpoints", total=None)
        best = select(
            trainer.run,
            trainer.robot,
            trainer.config.candidates,
            lambda done, total: progress.update(task, completed=done, total=total),
        )
    v = best.validation
    return (
        f"Wrote {trainer.run / run_dir.POLICY} from {best.name} (in validation: GC stance {v.gc_stance:.3f}, identity "
        f"{v.identity:.2f}, speed error {v.speed_error:.2f} m/s, {v.fell:.0%} of the runs fell)."
    )


def start(trainer: Trainer, started_from: dict[str, Any] | None = None) -> None:
    """Write settings, robot, timing and origin of a run before it runs.

    Args:
        trainer: of the run.
        started_from: as :meth:`Trainer.start_from` has it.

    Raises:
        FileProblem: if they cannot be written.
    """
    origin = {"commit": commit()} | ({} if started_from is None else {run_dir.STARTED_FROM: started_from})
    run_dir.begin(trainer.run, trainer.robot, trainer.env.timing, origin)
    config_file.save(trainer.config, trainer.run / run_dir.CONFIG)
