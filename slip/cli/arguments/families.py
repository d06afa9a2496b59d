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
    """All families of passive gaits of the spring-loaded model, found from hopping in place alone.

    Writes families.npz and families.json (orbits, branches, junctions, parameters, tolerances) and families.png.

    Attributes:
        model: the spring-loaded model.
        max_speed: apex speed at which a branch is left, in sqrt(g torso length); in m/s for a robot.
        trot: look for trot and pace, too.
        carry: carry over, from the reference parameters, families that no junction leads to: about a minute.
        out: directory of the results.
        cache: use what was explored before, and keep what is explored now.
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
