"""The command line of ``symdyn fit-curves``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import tyro

from slip.cli.passive_model import PassiveModelArguments
from slip.curves.settings import ChoiceConfig, CurveName, IdentifyConfig, Selection
from symdyn.io.command_line import parsed


@dataclass(frozen=True)
class FitArguments:
    """Fit stride period, T* = a_T (1 + b_T delta |v*|) exp(-c_T |v*|), and duty factor (same form) over speed.

    Makes two separate fits: passive, to orbits of the spring-loaded model; calibrated, to trials of a trained policy,
    if a table of them is given (symdyn evaluate --sweep-timing writes one). Writes curves.json for symdyn train
    --timing, a figure and a report. Without trials the active curve of the file is the paper's, and the file says so.

    Attributes:
        model: the spring-loaded model: the go2's if no robot is named, with what is given instead.
        reference: use the literature's model (k 10, ks 20, J 2), which is not that of any robot.
        identify: choose k and ks so that the pronk at rest meets the targets; then only the decay is a result of the
            model.
        target: targets of --identify.
        select: which orbits count, and how much.
        trials: table of trials, CSV or JSON.
        choice: which trials calibrate.
        active: the curve that training uses: passive, calibrated or paper. Default: calibrated if there are trials,
            else paper.
        bootstrap: number of bootstrap samples of whole families, or gaits, for the intervals. 0, or fewer than four of
            them, uses the covariance.
        trot: search for trot and pace, too.
        carry: for families that no junction leads to, continue orbits of the reference parameters.
        cache: use and keep results of earlier searches.
        out: output directory.
    """

    model: Annotated[PassiveModelArguments, tyro.conf.arg(name="")] = field(default_factory=PassiveModelArguments)
    reference: bool = False
    identify: bool = False
    target: IdentifyConfig = field(default_factory=IdentifyConfig)
    select: Annotated[Selection, tyro.conf.arg(name="")] = field(default_factory=Selection)
    trials: Path | None = None
    choice: Annotated[ChoiceConfig, tyro.conf.arg(name="")] = field(default_factory=ChoiceConfig)
    active: CurveName | None = None
    bootstrap: int = 0
    trot: bool = True
    carry: bool = True
    cache: bool = True
    out: Path = Path("out/curves")


def parse(arguments: Sequence[str]) -> FitArguments:
    """The arguments of the command line. Raises SymdynError for bad input, SystemExit after ``--help``."""
    return parsed(FitArguments, arguments, "symdyn fit-curves")
