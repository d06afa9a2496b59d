"""The command line of ``symdyn gaits``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from symdyn.io.command_line import parsed
from symdyn.robot.robot_file import DEFAULT_ROBOT


@dataclass(frozen=True)
class GaitsArguments:
    """The gait library: offsets theta, symmetry class (K: spatial, H: with a phase shift), stride period, duty factor.

    Attributes:
        name: one gait, shown with its footfalls; if left out, a table of all gaits. NAME_mirrored is the mirror image.
        robot: name or robot file; stride period and duty factor depend on its leg length.
        speed: forward velocity at which stride period and duty factor are shown, m/s.
        timing: a curves file instead of the paper's constants.
        json: print [{name, offsets, K, H, time_reversal_partner, symmetric_pairs}] and nothing else.
        observation: print every observation: the inputs of a policy in order, with scale and noise; nothing else.
        figure: also save a footfall diagram of NAME to this file (PNG, PDF or SVG by suffix).
    """

    name: Annotated[str | None, tyro.conf.Positional] = None
    robot: Annotated[str, tyro.conf.arg(metavar="NAME|FILE")] = DEFAULT_ROBOT
    speed: float = 0.5
    timing: Path | None = None
    json: bool = False
    observation: bool = False
    figure: Path | None = None


def parse(arguments: Sequence[str]) -> GaitsArguments:
    """The arguments of the command line. Raises SymdynError for bad input, SystemExit after ``--help``."""
    return parsed(GaitsArguments, arguments, "symdyn gaits")
