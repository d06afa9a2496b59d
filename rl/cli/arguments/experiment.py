"""The command line of ``symdyn experiment``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from symdyn.io.command_line import parsed
from symdyn.io.options import RobotOption


@dataclass(frozen=True)
class ExperimentArguments:
    """Run experiments of the paper's Results section on a policy file. Each writes figures, metrics.json and a table
    with the paper's value, the goal and the measured value. Seeds are fixed. Names: velocity (tracking of -2, -1, 0.2,
    2 m/s), gaits (strides in the commanded gait), transitions (every ordered pair of gaits), cot (cost of transport),
    ablation (policies trained without one symmetry), robustness (random commands, other robots, pushes, delays),
    steering (turns, sideways, straight ahead, standing), terrain (bumps of 4 cm), reversal (backwards compared with
    forwards), mixtures (gaits between two gaits), learning (checkpoints of training runs), or all (every one except
    learning).

    Attributes:
        names: experiments to run.
        policy: policy file; the shipped policy if left out.
        robot: name or robot file; the robot of the policy if left out.
        out: directory of the results; OUT/NAME holds those of one experiment.
        seeds: number of initial stride phases; docs/results.md uses five, one gives a first look.
        ablations: directory of the policies of the ablation, VARIANT-SEED/policy.onnx.
        learning: run directories for the experiment learning.
    """

    names: Annotated[tuple[str, ...], tyro.conf.Positional]
    policy: Path | None = None
    robot: RobotOption = None
    out: Path = Path("out/experiments")
    seeds: int = 5
    ablations: Path = Path("runs/ablation")
    learning: tuple[Path, ...] = ()


def parse(arguments: Sequence[str]) -> ExperimentArguments:
    """The arguments of the command line. Raises SymdynError for bad input, SystemExit after ``--help``."""
    return parsed(ExperimentArguments, arguments, "symdyn experiment")
