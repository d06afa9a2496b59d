"""``symdyn train``: PPO, resumable at every checkpoint."""

from __future__ import annotations

from rl.physics.threads import wait_passively

wait_passively()  # before torch

import contextlib  # noqa: E402
import shlex  # noqa: E402
from pathlib import Path  # noqa: E402
from typing import Any  # noqa: E402

import torch  # noqa: E402
from rich.console import Console  # noqa: E402

from rl.cli.arguments.train import TrainArguments  # noqa: E402
from rl.cli.train_seeds import train_seeds  # noqa: E402
from rl.judging.selection import select  # noqa: E402
from rl.learning import checkpoint, config_file, run_dir, run_lock, run_log, seeds  # noqa: E402
from rl.learning.display import TrainingDisplay  # noqa: E402
from rl.learning.trainer import Trainer  # noqa: E402
from symdyn.io.console import log_to, make_console, print_command  # noqa: E402
from symdyn.io.exit_codes import INTERRUPTED  # noqa: E402
from symdyn.io.origin import commit  # noqa: E402
from symdyn.io.progress import progress  # noqa: E402


def run(args: TrainArguments) -> int:
    """The command. Raises SymdynError for bad input."""
    console = make_console(lasting=True)
    log_to(console)
    if args.write_settings is not None:
        config_file.save(args.config, args.write_settings)
        console.print(f"Wrote {args.write_settings}. To train with it:", soft_wrap=True)
        print_command(console, "symdyn", "train", "--settings", args.write_settings)
        return 0
    train = _train if args.seeds is None else train_seeds
    if args.resume is not None:
        several = (args.resume / seeds.FILE).is_file()
        return (train_seeds if several else _train)(args.resume, args, console)
    if args.out is not None:
        run_dir.check_fresh(args.out)
        return train(args.out, args, console)
    reserved = run_dir.reserve(args.config.preset)
    try:
        return train(reserved, args, console)
    finally:
        with contextlib.suppress(OSError):
            reserved.rmdir()  # if it is still empty, the settings were refused
            reserved.parent.rmdir()


def _train(directory: Path, args: TrainArguments, console: Console) -> int:
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
            console.print(f"Continuing {directory} after {trainer.iteration} updates.")
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
        console.print(f"Stopped after {trainer.iteration} of {config.total_iterations} updates. To continue:")
        print_command(console, "symdyn", "train", "--resume", directory)
        return INTERRUPTED
    console.print(f"Done after {trainer.iteration} updates.")
    if config.candidates:
        console.print(_select(trainer, console), soft_wrap=True)
    console.print("Next:")
    if not config.candidates:
        print_command(console, "symdyn", "export", directory)
    robot = shlex.split(run_dir.robot_flag(config.robot))
    print_command(console, "symdyn", "evaluate", directory / run_dir.POLICY, "--suite", "quick", *robot)
    print_command(console, "symdyn", "play", directory / run_dir.POLICY, *robot)
    return 0


def _select(trainer: Trainer, console: Console) -> str:
    with progress(console, "comparing late checkpoints") as report_progress:
        best = select(trainer.run, trainer.robot, trainer.config.candidates, report_progress)
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
