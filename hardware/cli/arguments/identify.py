"""The command line of ``symdyn identify``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from symdyn.io.command_line import parsed
from symdyn.io.options import RobotOption


@dataclass(frozen=True)
class IdentifyArguments:
    """Fit the model of a robot to one machine: for each joint the delay from command to torque, strength, gains as
    realised, friction, damping, rotor inertia and offset of zero, each with a 95% interval. The log is of symdyn deploy
    POLICY --identify hung --log FILE.

    Prints a table, which says what the log does not determine. Writes the fit, for --fit of symdyn train, evaluate and
    robot-sim, and for a robot that hung a figure of measured against simulated motion beside it. A robot on its feet
    tells delays and gains only. Strength is relative to the masses of the URDF, and to the torque that motors report.

    Attributes:
        log: log file.
        robot: name or robot file; the robot of the log if left out.
        out: file to write, TOML; the figure has the same name and ends in .png.
    """

    log: Annotated[Path, tyro.conf.Positional]
    robot: RobotOption = None
    out: Path = Path("robot_fit.toml")


def parse(arguments: Sequence[str]) -> IdentifyArguments:
    """The arguments of the command line. Raises SymdynError for bad input, SystemExit after ``--help``."""
    return parsed(IdentifyArguments, arguments, "symdyn identify")
