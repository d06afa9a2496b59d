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
    """What a log shows: desired against realised contacts, estimated against commanded velocity, torque, cost of
    transport by gait, timing, faults. Writes report.md, metrics.json and figures.

    Any LCM event log will do: those of symdyn deploy --log hold commands and gaits; of lcm-logger's, recorded beside
    another deployer, what the robot said is shown. A log that is cut short is analysed as far as it goes.

    Attributes:
        log: the file.
        robot: name or robot file of the robot; the log's if left out.
        out: directory of the results; the log's name under out/ if left out.
        contact: when a foot bears load; only for logs without ticks of symdyn deploy, which say it themselves.
        settle: seconds at the beginning of each gait and velocity that count for the settling time only; 0 counts all.
    """

    log: Annotated[Path, tyro.conf.Positional]
    robot: RobotOption = None
    out: Path | None = None
    settle: float = 1.0
    contact: ContactConfig = field(default_factory=ContactConfig)


def parse(arguments: Sequence[str]) -> AnalyzeArguments:
    """The arguments of the command line. Raises SymdynError for bad input, SystemExit after ``--help``."""
    return parsed(AnalyzeArguments, arguments, "symdyn analyze")
