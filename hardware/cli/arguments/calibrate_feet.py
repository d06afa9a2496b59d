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
    """The raw foot force above which a foot bears load, foot by foot, from a log of the robot running.

    The Go2's feet have no documented unit, and no two are alike. Record ten seconds of trot on hard, level ground with
    symdyn deploy --log, with the built-in thresholds, which need not be right for that; calibrate; deploy again.

    Attributes:
        log: event log of symdyn deploy or lcm-logger.
        out: file of the thresholds to write (JSON).
        figure: also draw the forces' histograms and the thresholds (PNG, PDF or SVG by its suffix).
    """

    log: Annotated[Path, tyro.conf.Positional]
    out: Path = Path("feet.json")
    figure: Path | None = None


def parse(arguments: Sequence[str]) -> CalibrateFeetArguments:
    """The arguments of the command line. Raises SymdynError for bad input, SystemExit after ``--help``."""
    return parsed(CalibrateFeetArguments, arguments, "symdyn calibrate-feet")
