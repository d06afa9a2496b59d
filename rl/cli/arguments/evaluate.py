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
    """Evaluate a policy file on the nominal model with the paper's metrics (velocity tracking, gait consistency, cost
    of transport) and gait identity (share of strides in the commanded gait). Writes report.md, metrics.json and
    figures.

    With --sweep-timing instead, it varies stride period and duty factor around the policy's curves and writes a table
    of the cost of each. symdyn fit-curves --trials calibrates new curves from it. An interrupted sweep continues where
    it stopped.

    Attributes:
        policy: policy file; the shipped policy if left out.
        robot: name or robot file; the robot of the policy if left out.
        fit: file from symdyn identify; the policy is judged on that machine (its median delay, in steps of 5 ms), not
            on the nominal model.
        suite: quick (about half a minute, one seed) or paper (every protocol of the paper's Results section, five
            seeds).
        out: output directory; out/POLICY if left out.
        sweep_timing: write timing_sweep.csv and timing_sweep.json instead of running a suite.
        sweep: range of --sweep-timing.
    """

    policy: Annotated[Path | None, tyro.conf.Positional] = None
    robot: RobotOption = None
    fit: Path | None = None
    suite: str = "quick"
    out: Path | None = None
    sweep_timing: bool = False
    sweep: SweepConfig = field(default_factory=SweepConfig)


def parse(arguments: Sequence[str]) -> EvaluateArguments:
    """The arguments of the command line. Raises SymdynError for bad input, SystemExit after ``--help``."""
    return parsed(EvaluateArguments, arguments, "symdyn evaluate")
