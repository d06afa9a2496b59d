"""``symdyn experiment``: the paper's Results section for a policy file, one command an experiment."""

from __future__ import annotations

from rl.physics.threads import wait_passively

wait_passively()  # before torch

import time  # noqa: E402
from collections.abc import Sequence  # noqa: E402
from dataclasses import dataclass, replace  # noqa: E402
from pathlib import Path  # noqa: E402
from typing import Annotated  # noqa: E402

import tyro  # noqa: E402
from rich.console import Console  # noqa: E402
from rich.progress import Progress  # noqa: E402

from rl.experiments import ablation, learning, report  # noqa: E402
from rl.experiments.catalogue import EXPERIMENTS, chosen  # noqa: E402
from rl.experiments.result import Result, Subject  # noqa: E402
from rl.pretrained import load_policy  # noqa: E402
from symdyn.errors import FileProblem, InvalidValue  # noqa: E402
from symdyn.io.console import log_to, make_console  # noqa: E402
from symdyn.io.files import writable_directory  # noqa: E402
from symdyn.io.options import RobotOption  # noqa: E402

FIRST_SEED = 1000
"""Far from the seeds that anything else uses: the evaluation that chose a checkpoint is not the one reported here."""


@dataclass(frozen=True)
class ExperimentArguments:
    """Run experiments of the paper's Results section on a policy file: fixed seeds, figures, metrics.json and a table
    paper against goal against here. Names: velocity (following -2, -1, 0.2, 2 m/s), gaits (is it the gait that was
    asked for?), transitions (every ordered pair), cot (cost of transport), ablation (without one of the symmetries),
    robustness (random sequences; other robots, pushes, delays), steering (turning, sideways,
    straight ahead, standing), terrain (bumps of 4 cm), reversal (backwards against
    forwards), mixtures (gaits between gaits), learning (the checkpoints of training runs), or all of them but learning.

    Attributes:
        names: experiments to run.
        policy: the policy file; the one that comes with symdyn if left out.
        robot: name or robot file of the robot; the policy's if left out.
        out: directory of the results; OUT/NAME holds those of one experiment.
        seeds: how many initial stride phases; five is what docs/results.md has, one gives a first look.
        ablations: directory of the policies of the ablation, VARIANT-SEED/policy.onnx.
        learning: runs of symdyn train, for the experiment learning.
    """

    names: Annotated[tuple[str, ...], tyro.conf.Positional]
    policy: Path | None = None
    robot: RobotOption = None
    out: Path = Path("out/experiments")
    seeds: int = 5
    ablations: Path = Path("runs/ablation")
    learning: tuple[Path, ...] = ()


def run(arguments: Sequence[str]) -> int:
    """The command. Raises SymdynError for bad input."""
    args = tyro.cli(ExperimentArguments, args=list(arguments), prog="symdyn experiment")
    if not args.names:
        raise InvalidValue("The list of experiments", "empty", f"names of {', '.join(EXPERIMENTS)}, or all")
    names = chosen(args.names)
    if args.seeds < 1:
        raise InvalidValue("--seeds", args.seeds, "a whole number > 0")
    console = make_console()
    log_to(console)
    path, policy = load_policy(args.policy, args.robot)
    subject = Subject(
        policy=policy,
        path=path,
        seeds=tuple(range(FIRST_SEED, FIRST_SEED + args.seeds)),
        runs=args.ablations,
        learning=args.learning,
    )
    if "ablation" in names:
        try:
            ablation.policies(args.ablations)
        except FileProblem as error:
            if "ablation" in args.names:
                raise
            console.print(f"Leaving out ablation. {error}")
            names = tuple(name for name in names if name != "ablation")
    if "learning" in names:
        learning.checkpoints(args.learning)
    writable_directory(args.out)
    results = [_one(name, subject, args.out, console) for name in names]
    if len(results) > 1:
        console.print(f"Wrote {report.write_summary(results, subject, args.out)}; open it.")
    return 0


def _one(name: str, subject: Subject, out: Path, console: Console) -> Result:
    begin = time.monotonic()
    with Progress(console=console, disable=not console.is_terminal) as progress:
        task = progress.add_task(name, total=None)
        watched = replace(subject, watch=lambda done, total: progress.update(task, completed=done, total=total))
        result = EXPERIMENTS[name](watched)
    written = report.write(result, subject, out)
    wanted = [target for target in result.targets if not target.hypothesis]
    goals = f" {sum(target.met for target in wanted)} of {len(wanted)} goals reached." if wanted else ""
    console.print(f"{name}: {time.monotonic() - begin:.0f} s.{goals} Wrote {written}")
    return result
