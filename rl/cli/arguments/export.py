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
    """Export the newest checkpoint of a run as one ONNX file with everything that deployment needs: weights, joint
    names, gains, observation layout, gaits, timing curves and training settings.

    Attributes:
        run: run directory.
        out: policy file to write; RUN/policy.onnx if left out.
        checkpoint: checkpoint of the run to export instead of the newest. Several are averaged, which often runs better
            than each of them (stochastic weight averaging).
    """

    run: Annotated[Path, tyro.conf.Positional]
    out: Path | None = None
    checkpoint: tuple[Path, ...] = ()


def parse(arguments: Sequence[str]) -> ExportArguments:
    """The arguments of the command line. Raises SymdynError for bad input, SystemExit after ``--help``."""
    return parsed(ExportArguments, arguments, "symdyn export")
