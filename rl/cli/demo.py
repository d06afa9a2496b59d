"""``symdyn demo``: the main job from beginning to end, in minutes."""

from __future__ import annotations

from rl.threads import wait_passively

wait_passively()  # before torch

import math  # noqa: E402
import os  # noqa: E402
import shutil  # noqa: E402
from collections.abc import Sequence  # noqa: E402
from dataclasses import dataclass, replace  # noqa: E402
from pathlib import Path  # noqa: E402

import tyro  # noqa: E402

from rl import run_dir  # noqa: E402
from rl.cli.evaluate import judge  # noqa: E402
from rl.cli.train import start  # noqa: E402
from rl.config import preset  # noqa: E402
from rl.export import export_policy  # noqa: E402
from rl.trainer import Trainer  # noqa: E402
from rl.training_display import TrainingDisplay  # noqa: E402
from symdyn.cli import INTERRUPTED  # noqa: E402
from symdyn.console import log_to, make_console  # noqa: E402
from symdyn.errors import FileProblem, InvalidValue  # noqa: E402
from symdyn.files import writable_directory  # noqa: E402


@dataclass(frozen=True)
class DemoArguments:
    """Train with the default settings for a few minutes, evaluate the policy that comes out, and write a report.

    A few minutes on two cores teach a robot to stand and perhaps to lift a foot. They do not teach it to run: that
    takes hours (symdyn train). The report shows what was learned, and what was not.

    Attributes:
        out: directory of the report, with the training run beside it in OUT/run. An earlier demo there is overwritten.
        minutes: of training.
        seed: of everything random.
    """

    out: Path = Path("out/demo")
    minutes: float = 4.0
    seed: int = 0


def run(arguments: Sequence[str]) -> int:
    """The command. Raises SymdynError for bad input."""
    args = tyro.cli(DemoArguments, args=list(arguments), prog="symdyn demo")
    if not 0.0 < args.minutes < math.inf:
        raise InvalidValue("--minutes", args.minutes, "a number > 0")
    console = make_console()
    log_to(console)
    directory = _clear(writable_directory(args.out) / "run")
    config = replace(preset("cpu"), seed=args.seed)
    trainer = Trainer(config, directory)
    start(trainer)
    console.print(
        f"Training for {args.minutes:g} minutes with {config.num_envs} robots on {os.cpu_count()} processors."
    )
    with TrainingDisplay(console, trainer.iteration, config.iterations) as display:
        trainer.train(display.update, time_limit_s=60.0 * args.minutes)
    if trainer.interrupted:
        console.print("Stopped; nothing was evaluated. To start again: symdyn demo")
        return INTERRUPTED
    policy = export_policy(directory)
    remark = _remark(trainer)
    console.print(f"{remark}\nEvaluating {policy}.")
    written = judge(policy, "quick", args.out, console, remark)
    console.print(f"Wrote {written}; open it. To train for longer: symdyn train --help")
    return 0


def _clear(directory: Path) -> Path:
    """An empty directory for the run; what an earlier demo left there goes, anything else is refused."""
    if directory.exists():
        if any(directory.iterdir()) and not (directory / run_dir.CONFIG).is_file():
            raise FileProblem(directory, "is no run of an earlier demo; move it away or choose another --out.")
        shutil.rmtree(directory)
    return writable_directory(directory)


def _remark(trainer: Trainer) -> str:
    samples = trainer.iteration * trainer.samples_per_iteration
    return (
        f"This policy was trained for {trainer.seconds / 60:.1f} minutes ({samples / 1e6:.2f} million samples; the "
        "paper used 2460 million). That teaches standing and hardly a step: read the figures below as the beginning of "
        "a learning curve, not as what the method can do."
    )
