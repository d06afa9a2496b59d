"""The command line of ``symdyn orbit``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Literal

import tyro

from slip.cli.passive_model import PassiveModelArguments
from slip.figures.animation_config import AnimationConfig
from symdyn.io.command_line import parsed


@dataclass(frozen=True)
class OrbitArguments:
    """Compute one passive gait of the spring-loaded model, by family and speed.

    Writes orbit.json (everything), orbit.png (footfalls, forces, trajectories, phase plots) and an animation.

    Attributes:
        family: PK, BG, BE, FG, FE, HG, HE, GG, GE, TR or PC, or a branch such as HG2: what symdyn families lists.
        speed: forward speed at the apex, in sqrt(g torso length); in m/s for a robot.
        model: the spring-loaded model.
        which: number of the gait if the family has several at this speed.
        out: output directory.
        animate: format of the animation. MP4 needs imageio-ffmpeg.
        animation: the animation.
        cache: use and keep results of earlier searches.
    """

    family: str
    speed: float
    model: Annotated[PassiveModelArguments, tyro.conf.arg(name="")] = field(default_factory=PassiveModelArguments)
    which: int = 1
    out: Path = Path("out/orbit")
    animate: Literal["gif", "mp4", "none"] = "gif"
    animation: AnimationConfig = field(default_factory=AnimationConfig)
    cache: bool = True


def parse(arguments: Sequence[str]) -> OrbitArguments:
    """The arguments of the command line. Raises SymdynError for bad input, SystemExit after ``--help``."""
    return parsed(OrbitArguments, arguments, "symdyn orbit")
