"""``symdyn replay``: a log of the robot through the controller once more."""

from __future__ import annotations

from pathlib import Path

from rich.console import Console

from hardware.cli.arguments.replay import ReplayArguments
from hardware.logs.replay import Replay, policy_of, replay, session_of
from hardware.running.session import Session
from hardware.wire.event_log import LogReader
from symdyn.errors import FileProblem
from symdyn.io.console import make_console
from symdyn.io.origin import commit
from symdyn.io.progress import progress
from symdyn.robot.robot_file import chosen_robot

DIFFERENT = 1
"""Exit code if anything came out otherwise."""


def run(args: ReplayArguments) -> int:
    """The command: 0, or 1 if anything came out otherwise. Raises SymdynError for bad input."""
    console = make_console()
    reader = LogReader(args.log)
    session = session_of(reader)
    policy = policy_of(session, args.policy, args.log, chosen_robot(args.robot))
    with progress(console, "replaying") as report_progress:
        found = replay(reader, session, policy, report_progress)
    if not found.ticks:
        raise FileProblem(args.log, "cannot be replayed: it contains no ticks.")
    _tell(console, found, session)
    return DIFFERENT if found.different else 0


def _tell(console: Console, found: Replay, session: Session) -> None:
    for problem in found.problems:
        console.print(problem, style="yellow")
    compared = f"{found.ticks} ticks and {found.targets} messages to the motors"
    if found.first is None:
        console.print(f"{compared}: all as in the log, bit for bit.")
        return
    first = found.first
    fields = ", ".join(f"{name} in {count}" for name, count in found.fields.items())
    console.print(f"{compared}: {found.different} ticks differ ({fields}).", style="red")
    console.print(f"The first is tick {first.tick}, {first.time:.3f} s into the log. Its {first.what} was")
    console.print(f"  {first.logged!r}, and is now\n  {first.replayed!r}.", markup=False)
    console.print(
        f"Largest difference of an action: {found.action_error:.3g}, of a joint target: {found.target_error:.3g} rad."
    )
    here = commit(Path(__file__).parent)
    if session.commit != here:
        console.print(f"The log was made by commit {session.commit} of symdyn; this is {here}.")
