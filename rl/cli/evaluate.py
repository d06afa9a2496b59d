"""``symdyn evaluate``: the paper's metrics, protocols and figures for a policy file."""

from __future__ import annotations

from rl.physics.threads import wait_passively

wait_passively()  # before torch

from collections.abc import Sequence  # noqa: E402
from dataclasses import dataclass, field  # noqa: E402
from pathlib import Path  # noqa: E402
from typing import Annotated  # noqa: E402

import tyro  # noqa: E402
from rich.console import Console  # noqa: E402
from rich.progress import Progress  # noqa: E402

from rl.judging import protocols, report  # noqa: E402
from rl.judging.evaluate import evaluate  # noqa: E402
from rl.judging.protocols import Suite  # noqa: E402
from rl.judging.sweep import SweepConfig, sweep  # noqa: E402
from rl.learning import run_log  # noqa: E402
from rl.pretrained import load_policy  # noqa: E402
from symdyn.io.console import log_to, make_console  # noqa: E402
from symdyn.io.files import writable_directory  # noqa: E402
from symdyn.io.options import RobotOption  # noqa: E402
from symdyn.policy.file import Policy  # noqa: E402


@dataclass(frozen=True)
class EvaluateArguments:
    """Judge a policy file on the nominal model: velocity tracking, gait consistency, cost of transport (the paper's
    metrics) and gait identity (are the strides of the commanded gait?). Writes metrics.json, figures and report.md.

    With --sweep-timing instead: vary stride period and duty factor about the policy's curves and write a table of what
    each costs, from which symdyn fit-curves --trials calibrates new curves. Interrupted, it goes on where it stopped.

    Attributes:
        policy: the file; the one that comes with symdyn if left out.
        robot: name or robot file of the robot; the policy's if left out.
        suite: quick (a minute or so, one seed) or paper (every protocol of the paper's Results section, five seeds).
        out: directory of the results; the policy's name under out/ if left out.
        sweep_timing: write timing_sweep.csv and timing_sweep.json instead of running a suite.
        sweep: what --sweep-timing tries.
    """

    policy: Annotated[Path | None, tyro.conf.Positional] = None
    robot: RobotOption = None
    suite: str = "quick"
    out: Path | None = None
    sweep_timing: bool = False
    sweep: SweepConfig = field(default_factory=SweepConfig)


def run(arguments: Sequence[str]) -> int:
    """The command. Raises SymdynError for bad input."""
    args = tyro.cli(EvaluateArguments, args=list(arguments), prog="symdyn evaluate")
    console = make_console()
    log_to(console)
    suite = protocols.suite(args.suite)
    path, policy = load_policy(args.policy, args.robot)
    out = args.out or Path("out") / path.stem
    if args.sweep_timing:
        table = sweep_timing(policy, path, args.sweep, out, console)
        console.print(f"Wrote {table}, and {table.with_suffix('.json').name} with settings and units. Next:")
        console.print(f"  symdyn fit-curves --trials {table.with_suffix('.json')}")
        return 0
    written = judge(policy, path, suite, out, console)
    console.print(f"Wrote {written}, with metrics.json and figures beside it.")
    return 0


def judge(policy: Policy, path: Path, suite: Suite, out: Path, console: Console, remark: str = "") -> Path:
    """Evaluate and write everything, with a progress bar; the report's path. Raises SymdynError."""
    writable_directory(out)
    with Progress(console=console, disable=not console.is_terminal) as progress:
        task = progress.add_task(f"suite {suite.name}", total=None)
        found = evaluate(policy, path, suite, lambda done, total: progress.update(task, completed=done, total=total))
    return report.write(found, out, run_log.read(path.parent), remark)


def sweep_timing(policy: Policy, path: Path, config: SweepConfig, out: Path, console: Console) -> Path:
    """Run a timing sweep with a progress bar; the CSV table's path. Raises SymdynError."""
    with Progress(console=console, disable=not console.is_terminal) as progress:
        task = progress.add_task(f"{len(config.cells)} timings", total=config.trials)
        return sweep(policy, path, config, out, lambda done, total: progress.update(task, completed=done))
