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
    """Put a log of symdyn deploy through a fresh controller: the same messages at the same times must give the same
    states, actions and targets, bit for bit. So a fault on the robot can be looked into at a desk, and a change of the
    controller can be tried on what a robot once met. Exit code 1 if anything comes out otherwise.

    Another processor or another onnxruntime may round the policy's actions differently in the last bits.

    Attributes:
        log: the file.
        policy: the policy file that it was made with; where the log says that it was if left out.
        robot: name or robot file of the robot; the policy's if left out.
    """

    log: Annotated[Path, tyro.conf.Positional]
    policy: Annotated[Path | None, tyro.conf.Positional] = None
    robot: RobotOption = None


def parse(arguments: Sequence[str]) -> ReplayArguments:
    """The arguments of the command line. Raises SymdynError for bad input, SystemExit after ``--help``."""
    return parsed(ReplayArguments, arguments, "symdyn replay")
