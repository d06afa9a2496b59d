"""``symdyn demo``: the main job at once, on the policy that comes with symdyn."""

from __future__ import annotations

from rl.physics.threads import wait_passively

wait_passively()  # before torch


from rl.cli.arguments.demo import DemoArguments  # noqa: E402
from rl.cli.evaluate import judge  # noqa: E402
from rl.judging.protocols import suite  # noqa: E402
from rl.pretrained import load_policy  # noqa: E402
from symdyn.io.console import log_to, make_console  # noqa: E402


def run(args: DemoArguments) -> int:
    """The command. Raises SymdynError for bad input."""
    console = make_console()
    log_to(console)
    path, policy = load_policy(None, args.robot)
    console.print(f"Running {path.name} through six gaits, four speeds and the paper's two sequences.")
    written = judge(policy, path, suite("quick"), args.out, console)
    console.print(f"Wrote {written}; open it. Next:")
    console.print("  symdyn record --out out/demo/film.mp4   # see it run")
    console.print("  symdyn experiment all                  # every experiment of the paper, half an hour")
    console.print("  symdyn train                           # your own policy")
    return 0
