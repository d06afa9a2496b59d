"""The command line of ``symdyn export``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from symdyn.io.command_line import parsed


@dataclass(frozen=True)
class ExportArguments:
    """Turn the newest checkpoint of a run into one ONNX file that holds everything that deploys it: weights, joint
    names, gains, observation layout, gaits, timing, and what it was trained with.

    Attributes:
        run: directory of the run.
        out: the file; RUN/policy.onnx if left out.
        checkpoint: a checkpoint of the run other than the newest; the mean of the weights of several, which often runs
            better than each of them (stochastic weight averaging).
    """

    run: Annotated[Path, tyro.conf.Positional]
    out: Path | None = None
    checkpoint: tuple[Path, ...] = ()


def parse(arguments: Sequence[str]) -> ExportArguments:
    """The arguments of the command line. Raises SymdynError for bad input, SystemExit after ``--help``."""
    return parsed(ExportArguments, arguments, "symdyn export")
