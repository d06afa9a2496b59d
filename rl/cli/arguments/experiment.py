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
    """Run experiments of the paper's Results section on a policy file: fixed seeds, figures, metrics.json and a table
    paper against goal against here. Names: velocity (following -2, -1, 0.2, 2 m/s), gaits (is it the gait that was
    asked for?), transitions (every ordered pair), cot (cost of transport), ablation (without one of the symmetries),
    robustness (random sequences; other robots, pushes, latency), terrain (bumps of 4 cm), reversal (backwards against
    forwards), mixtures (gaits between gaits), learning (the checkpoints of training runs), or all of them but learning.

    Attributes:
        names: experiments to run.
        policy: the policy file; the one that comes with symdyn if left out.
        robot: name or robot file of the robot; the policy's if left out.
        out: directory of the results; OUT/NAME holds those of one experiment.
        seeds: how many initial stride phases; five is what docs/results.md has, one gives a first look.
        ablations: directory of the policies of the ablation, VARIANT-SEED/policy.onnx.
        learning: runs of symdyn train, for the experiment learning.
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
