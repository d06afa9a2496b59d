"""The command line of ``symdyn calibrate-feet``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from symdyn.io.command_line import parsed


@dataclass(frozen=True)
class CalibrateFeetArguments:
    """Find the contact threshold of each foot's force sensor from a log of the running robot.

    The unit of the Go2's foot sensors is not documented, and the sensors differ. Record ten seconds of trot on hard,
    level ground with symdyn deploy --log (the built-in thresholds are good enough for that), calibrate, and deploy
    again.

    Attributes:
        log: log file of symdyn deploy or lcm-logger.
        out: file to write the thresholds to (JSON).
        figure: also draw histograms of the forces with the thresholds (PNG, PDF or SVG by suffix).
    """

    log: Annotated[Path, tyro.conf.Positional]
    out: Path = Path("feet.json")
    figure: Path | None = None


def parse(arguments: Sequence[str]) -> CalibrateFeetArguments:
    """The arguments of the command line. Raises SymdynError for bad input, SystemExit after ``--help``."""
    return parsed(CalibrateFeetArguments, arguments, "symdyn calibrate-feet")
