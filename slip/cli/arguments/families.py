"""The command line of ``symdyn families``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import tyro

from slip.cli.passive_model import PassiveModelArguments
from symdyn.io.command_line import parsed


@dataclass(frozen=True)
class FamiliesArguments:
    """Find all families of passive gaits of the spring-loaded model, starting from hopping in place.

    Writes families.npz and families.json (orbits, branches, junctions, parameters, tolerances) and families.png.

    Attributes:
        model: the spring-loaded model.
        max_speed: apex speed at which the tracing of a branch stops, in sqrt(g torso length); in m/s for a robot.
        trot: search for trot and pace, too.
        carry: for families that no junction leads to, continue orbits of the reference parameters (about a minute).
        out: output directory.
        cache: use and keep results of earlier searches.
    """

    model: Annotated[PassiveModelArguments, tyro.conf.arg(name="")] = field(default_factory=PassiveModelArguments)
    max_speed: float | None = None
    trot: bool = True
    carry: bool = True
    out: Path = Path("out/families")
    cache: bool = True


def parse(arguments: Sequence[str]) -> FamiliesArguments:
    """The arguments of the command line. Raises SymdynError for bad input, SystemExit after ``--help``."""
    return parsed(FamiliesArguments, arguments, "symdyn families")
