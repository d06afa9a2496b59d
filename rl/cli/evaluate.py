"""``symdyn evaluate``: the paper's metrics, protocols and figures for a policy file."""

from __future__ import annotations

from rl.physics.threads import wait_passively

wait_passively()  # before torch

from pathlib import Path  # noqa: E402

from rich.console import Console  # noqa: E402

from rl.cli.arguments.evaluate import EvaluateArguments  # noqa: E402
from rl.judging import protocols, report  # noqa: E402
from rl.judging.evaluate import evaluate  # noqa: E402
from rl.judging.protocols import Suite  # noqa: E402
from rl.judging.sweep import sweep  # noqa: E402
from rl.judging.sweep_config import SweepConfig  # noqa: E402
from rl.learning import run_log  # noqa: E402
from rl.pretrained import load_policy  # noqa: E402
from symdyn.io.console import log_to, make_console, print_command, print_written  # noqa: E402
from symdyn.io.files import writable_directory  # noqa: E402
from symdyn.io.progress import progress  # noqa: E402
from symdyn.policy.file import Policy  # noqa: E402


def run(args: EvaluateArguments) -> int:
    """The command. Raises SymdynError for bad input."""
    console = make_console()
    log_to(console)
    suite = protocols.suite(args.suite)
    path, policy = load_policy(args.policy, args.robot)
    out = args.out or Path("out") / path.stem
    if args.sweep_timing:
        table = sweep_timing(policy, path, args.sweep, out, console)
        print_written(console, f"Wrote {table}, and {table.with_suffix('.json').name} with settings and units. Next:")
        print_command(console, "symdyn", "fit-curves", "--trials", table.with_suffix(".json"))
        return 0
    written = judge(policy, path, suite, out, console)
    print_written(console, f"Wrote {written}, with metrics.json and figures beside it.")
    return 0


def judge(policy: Policy, path: Path, suite: Suite, out: Path, console: Console, remark: str = "") -> Path:
    """Evaluate and write everything, with a progress bar; the report's path. Raises SymdynError."""
    writable_directory(out)
    with progress(console, f"Suite {suite.name}") as report_progress:
        found = evaluate(policy, path, suite, report_progress)
    return report.write(found, out, run_log.read(path.parent), remark)


def sweep_timing(policy: Policy, path: Path, config: SweepConfig, out: Path, console: Console) -> Path:
    """Run a timing sweep with a progress bar; the CSV table's path. Raises SymdynError."""
    with progress(console, f"{len(config.cells)} timings") as report_progress:
        return sweep(policy, path, config, out, report_progress)
