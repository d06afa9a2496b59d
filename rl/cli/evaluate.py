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
from symdyn.errors import InvalidValue  # noqa: E402
from symdyn.io.console import log_to, make_console, print_command, print_written  # noqa: E402
from symdyn.io.files import writable_directory  # noqa: E402
from symdyn.io.progress import progress  # noqa: E402
from symdyn.policy.file import Policy  # noqa: E402
from symdyn.robot.fit import Fit, load_fit  # noqa: E402


def run(args: EvaluateArguments) -> int:
    """The command. Raises SymdynError for bad input."""
    console = make_console()
    log_to(console)
    suite = protocols.suite(args.suite)
    path, policy = load_policy(args.policy, args.robot)
    fit = None if args.fit is None else load_fit(args.fit, policy.robot)
    out = args.out or Path("out") / path.stem
    if args.sweep_timing:
        if fit is not None:
            raise InvalidValue("--fit", str(args.fit), "left out with --sweep-timing, which takes the nominal robot")
        table = sweep_timing(policy, path, args.sweep, out, console)
        print_written(console, f"Wrote {table}, and {table.with_suffix('.json').name} with settings and units. Next:")
        print_command(console, "symdyn", "fit-curves", "--trials", table.with_suffix(".json"))
        return 0
    written = judge(policy, path, suite, out, console, fit=fit)
    print_written(console, f"Wrote {written}, with metrics.json and figures beside it.")
    return 0


def judge(
    policy: Policy,
    path: Path,
    suite: Suite,
    out: Path,
    console: Console,
    remark: str = "",
    fit: Fit | None = None,
) -> Path:
    """Evaluate, on one machine if there is a fit, and write everything; the report's path. Raises SymdynError."""
    if fit is not None:
        remark = f"{remark} On the machine of {fit.source} ({fit.place}), not on the nominal robot.".strip()
    writable_directory(out)
    with progress(console, f"Suite {suite.name}") as report_progress:
        found = evaluate(policy, path, suite, report_progress, fit)
    return report.write(found, out, run_log.read(path.parent), remark)


def sweep_timing(policy: Policy, path: Path, config: SweepConfig, out: Path, console: Console) -> Path:
    """Run a timing sweep with a progress bar; the CSV table's path. Raises SymdynError."""
    with progress(console, f"{len(config.cells)} timings") as report_progress:
        return sweep(policy, path, config, out, report_progress)
