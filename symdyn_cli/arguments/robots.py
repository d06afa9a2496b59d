"""The command line of ``symdyn robots``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import tyro

from symdyn.io.command_line import parsed


@dataclass(frozen=True)
class RobotsArguments:
    """List the robots that --robot takes by name, or print the robot file of one robot.

    Attributes:
        robot: print this robot's file; if left out, a table of all robots.
        json: print the robot files as JSON and nothing else.
    """

    robot: Annotated[str | None, tyro.conf.Positional, tyro.conf.arg(metavar="[NAME|FILE]")] = None
    json: bool = False


def parse(arguments: Sequence[str]) -> RobotsArguments:
    """The arguments of the command line. Raises SymdynError for bad input, SystemExit after ``--help``."""
    return parsed(RobotsArguments, arguments, "symdyn robots")
