"""The command line of ``symdyn replay``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from symdyn.io.command_line import parsed
from symdyn.io.options import RobotOption


@dataclass(frozen=True)
class ReplayArguments:
    """Run a new controller on a log of symdyn deploy. The same messages at the same times must give the same states,
    actions and targets bit for bit. Use it to investigate a fault of the robot at a desk, or to test a change of the
    controller on real data. Exit code 1 if anything differs.

    Another processor or another onnxruntime may round the policy's actions differently in the last bits.

    Attributes:
        log: log file.
        policy: policy file of the log; the path in the log if left out.
        robot: name or robot file; the robot of the policy if left out.
    """

    log: Annotated[Path, tyro.conf.Positional]
    policy: Annotated[Path | None, tyro.conf.Positional] = None
    robot: RobotOption = None


def parse(arguments: Sequence[str]) -> ReplayArguments:
    """The arguments of the command line. Raises SymdynError for bad input, SystemExit after ``--help``."""
    return parsed(ReplayArguments, arguments, "symdyn replay")
