"""The command line of ``symdyn robots``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import tyro

from symdyn.io.command_line import parsed


@dataclass(frozen=True)
class RobotsArguments:
    """The robots that --robot takes by name, with what their robot files say; or one robot, given by name or file.

    Attributes:
        robot: one robot, shown whole; all of them as a table if left out.
        json: print the robot files as JSON and nothing else.
    """

    robot: Annotated[str | None, tyro.conf.Positional, tyro.conf.arg(metavar="[NAME|FILE]")] = None
    json: bool = False


def parse(arguments: Sequence[str]) -> RobotsArguments:
    """The arguments of the command line. Raises SymdynError for bad input, SystemExit after ``--help``."""
    return parsed(RobotsArguments, arguments, "symdyn robots")
