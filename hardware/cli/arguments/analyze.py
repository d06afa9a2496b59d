"""The command line of ``symdyn analyze``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import tyro

from hardware.estimation.settings import ContactConfig
from symdyn.io.command_line import parsed
from symdyn.io.options import RobotOption


@dataclass(frozen=True)
class AnalyzeArguments:
    """Analyse a log: commanded and measured contacts, commanded and estimated velocity, torque, cost of transport by
    gait, timing, faults. Writes report.md, metrics.json and figures.

    Any LCM event log works. Logs of symdyn deploy --log include commands and gaits. For logs that lcm-logger recorded
    with another deployer, the report shows the robot's messages only. A truncated log is analysed as far as it goes.

    Attributes:
        log: log file.
        robot: name or robot file; the robot of the log if left out.
        out: output directory; out/LOG if left out.
        contact: when a foot bears load; only for logs without ticks of symdyn deploy, which say it themselves.
        settle: time after each change of command that counts only for the settling time, s; 0 counts everything.
    """

    log: Annotated[Path, tyro.conf.Positional]
    robot: RobotOption = None
    out: Path | None = None
    settle: float = 1.0
    contact: ContactConfig = field(default_factory=ContactConfig)


def parse(arguments: Sequence[str]) -> AnalyzeArguments:
    """The arguments of the command line. Raises SymdynError for bad input, SystemExit after ``--help``."""
    return parsed(AnalyzeArguments, arguments, "symdyn analyze")
