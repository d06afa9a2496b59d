"""The command line of ``symdyn evaluate``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import tyro

from rl.judging.sweep_config import SweepConfig
from symdyn.io.command_line import parsed
from symdyn.io.options import RobotOption


@dataclass(frozen=True)
class EvaluateArguments:
    """Judge a policy file on the nominal model: velocity tracking, gait consistency, cost of transport (the paper's
    metrics) and gait identity (are the strides of the commanded gait?). Writes metrics.json, figures and report.md.

    With --sweep-timing instead: vary stride period and duty factor about the policy's curves and write a table of what
    each costs, from which symdyn fit-curves --trials calibrates new curves. Interrupted, it goes on where it stopped.

    Attributes:
        policy: the file; the one that comes with symdyn if left out.
        robot: name or robot file of the robot; the policy's if left out.
        suite: quick (a minute or so, one seed) or paper (every protocol of the paper's Results section, five seeds).
        out: directory of the results; the policy's name under out/ if left out.
        sweep_timing: write timing_sweep.csv and timing_sweep.json instead of running a suite.
        sweep: what --sweep-timing tries.
    """

    policy: Annotated[Path | None, tyro.conf.Positional] = None
    robot: RobotOption = None
    suite: str = "quick"
    out: Path | None = None
    sweep_timing: bool = False
    sweep: SweepConfig = field(default_factory=SweepConfig)


def parse(arguments: Sequence[str]) -> EvaluateArguments:
    """The arguments of the command line. Raises SymdynError for bad input, SystemExit after ``--help``."""
    return parsed(EvaluateArguments, arguments, "symdyn evaluate")
