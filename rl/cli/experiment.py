"""``symdyn experiment``: the paper's Results section for a policy file, one command an experiment."""

from __future__ import annotations

from rl.physics.threads import wait_passively

wait_passively()  # before torch

import time  # noqa: E402
from dataclasses import replace  # noqa: E402
from pathlib import Path  # noqa: E402

from rich.console import Console  # noqa: E402

from rl.cli.arguments.experiment import ExperimentArguments  # noqa: E402
from rl.experiments import ablation, learning, report  # noqa: E402
from rl.experiments.catalogue import EXPERIMENTS, chosen  # noqa: E402
from rl.experiments.result import Result, Subject  # noqa: E402
from rl.pretrained import load_policy  # noqa: E402
from symdyn.errors import FileProblem, InvalidValue  # noqa: E402
from symdyn.io.console import log_to, make_console, print_written  # noqa: E402
from symdyn.io.files import writable_directory  # noqa: E402
from symdyn.io.progress import progress  # noqa: E402

FIRST_SEED = 1000
"""Far from the seeds that anything else uses: the evaluation that chose a checkpoint is not the one reported here."""


def run(args: ExperimentArguments) -> int:
    """The command. Raises SymdynError for bad input."""
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
        print_written(console, f"Wrote {report.write_summary(results, subject, args.out)}; open it.")
    return 0


def _one(name: str, subject: Subject, out: Path, console: Console) -> Result:
    begin = time.monotonic()
    with progress(console, name) as report_progress:
        result = EXPERIMENTS[name](replace(subject, watch=report_progress))
    written = report.write(result, subject, out)
    wanted = [target for target in result.targets if not target.hypothesis]
    goals = f" {sum(target.met for target in wanted)} of {len(wanted)} goals reached." if wanted else ""
    print_written(console, f"{name}: {time.monotonic() - begin:.0f} s.{goals} Wrote {written}")
    return result
