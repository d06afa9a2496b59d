"""The command line of ``symdyn demo``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from symdyn.io.command_line import parsed
from symdyn.io.options import RobotOption


@dataclass(frozen=True)
class DemoArguments:
    """Evaluate the shipped policy: one network, six gaits, both directions. Nothing is trained. Writes report.md with
    figures (footfalls, velocity tracking, cost of transport).

    Attributes:
        robot: name or robot file of the robot whose shipped policy is evaluated; the Go2 if left out.
        out: output directory.
    """

    robot: RobotOption = None
    out: Path = Path("out/demo")


def parse(arguments: Sequence[str]) -> DemoArguments:
    """The arguments of the command line. Raises SymdynError for bad input, SystemExit after ``--help``."""
    return parsed(DemoArguments, arguments, "symdyn demo")
