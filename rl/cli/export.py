"""``symdyn export``: one policy file from a run."""

from __future__ import annotations

from rl.physics.threads import wait_passively

wait_passively()  # before torch


import shlex  # noqa: E402

from rl.cli.arguments.export import ExportArguments  # noqa: E402
from rl.learning import config_file, run_dir  # noqa: E402
from rl.learning.export import export_policy  # noqa: E402
from symdyn.io.console import log_to, make_console, print_command, print_written  # noqa: E402


def run(args: ExportArguments) -> int:
    """The command. Raises SymdynError for bad input."""
    console = make_console()
    log_to(console)
    path = export_policy(run_dir.existing(args.run), args.out, args.checkpoint)
    robot = run_dir.robot_flag(config_file.load(args.run / run_dir.CONFIG).robot)
    print_written(console, f"Wrote {path} ({path.stat().st_size / 1024:.0f} KiB). Next:")
    print_command(console, "symdyn", "evaluate", path, "--suite", "quick", *shlex.split(robot))
    return 0
