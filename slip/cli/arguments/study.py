"""The command line of ``symdyn study``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import tyro

from slip.curves.settings import Grid, Selection, Workers
from symdyn.io.command_line import parsed
from symdyn.io.options import RobotOption


@dataclass(frozen=True)
class StudyArguments:
    """Trace the families of passive gaits of a grid of models, and fit the timing curves of each.

    Writes one file per model (cells/NAME.json) as soon as it is done, and the table study.csv. After an interruption
    the same command continues. A model that fails is listed in the table with the reason; the others go on.

    Attributes:
        grid: values to combine, as in --k 2 5 10 --ks 10 20 40 --J 0.2 2; what is not given is the base model's.
        robot: the base model is that of this robot: go2, go1, a1, b1, solo12, anymal_b, anymal_c or hyq; the
            literature's (k 10, ks 20, J 2) if left out.
        select: which orbits the curves are fitted to. A change needs no new tracing, but for another fastest speed.
        trot: search for trot and pace, too.
        carry: for families that no junction leads to, continue orbits of the reference parameters.
        workers: processes or cluster.
        retry_failed: repeat models that failed before.
        out: output directory.
    """

    grid: Annotated[Grid, tyro.conf.arg(name="")] = field(default_factory=Grid)
    robot: RobotOption = None
    select: Annotated[Selection, tyro.conf.arg(name="")] = field(default_factory=Selection)
    trot: bool = True
    carry: bool = False
    workers: Annotated[Workers, tyro.conf.arg(name="")] = field(default_factory=Workers)
    retry_failed: bool = False
    out: Path = Path("out/study")


def parse(arguments: Sequence[str]) -> StudyArguments:
    """The arguments of the command line. Raises SymdynError for bad input, SystemExit after ``--help``."""
    return parsed(StudyArguments, arguments, "symdyn study")
