"""``symdyn demo``: the main job at once, on the policy that comes with symdyn."""

from __future__ import annotations

from rl.physics.threads import wait_passively

wait_passively()  # before torch


from rl.cli.arguments.demo import DemoArguments  # noqa: E402
from rl.cli.evaluate import judge  # noqa: E402
from rl.judging.protocols import suite  # noqa: E402
from rl.pretrained import load_policy  # noqa: E402
from symdyn.io.console import log_to, make_console, print_command, print_written  # noqa: E402


def run(args: DemoArguments) -> int:
    """The command. Raises SymdynError for bad input."""
    console = make_console()
    log_to(console)
    path, policy = load_policy(None, args.robot)
    console.print(f"Running {path.name} through six gaits, four speeds and the paper's two sequences.")
    written = judge(policy, path, suite("quick"), args.out, console)
    print_written(console, f"Wrote {written}; open it. Next:")
    print_command(console, "symdyn", "record", "--out", args.out / "film.mp4", comment="a film of it")
    print_command(console, "symdyn", "experiment", "all", comment="every experiment of the paper")
    print_command(console, "symdyn", "train", comment="train your own policy")
    return 0
