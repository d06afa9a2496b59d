"""The command line of ``symdyn record``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import tyro

from rl.judging.paper_protocol import GAIT_SEQUENCE, GAIT_SPEED
from rl.pictures.film_config import FilmConfig
from symdyn.io.command_line import parsed
from symdyn.io.options import RobotOption


@dataclass(frozen=True)
class RecordArguments:
    """A film of a policy that goes through gaits and speeds, on the nominal model from a stand: MP4 or GIF.

    Above the robot stand the gait, the commanded speed and the measured one (the mean over the last stride); below it
    the footfalls, desired (hollow) and realised (solid), in the colours of the feet. Rendered without a screen, by EGL
    or OSMesa, whichever works; MUJOCO_GL decides where it is set.

    Attributes:
        policy: the file; the policy that comes with symdyn if left out.
        robot: name or robot file of the robot; the policy's if left out.
        gaits: one after the other.
        speeds: forward speeds, m/s: one for each gait, or one for all. One gait can also have several speeds.
        seconds: of running for each.
        out: the file; its suffix, .mp4 or .gif, is the format. MP4 needs imageio-ffmpeg. out/ROBOT.mp4 if left out.
        film: how it is shown.
        seed: decides the initial stride phase.
    """

    policy: Annotated[Path | None, tyro.conf.Positional] = None
    robot: RobotOption = None
    gaits: tuple[str, ...] = GAIT_SEQUENCE
    speeds: tuple[float, ...] = (GAIT_SPEED,)
    seconds: float = 2.0
    out: Path | None = None
    film: Annotated[FilmConfig, tyro.conf.arg(name="")] = field(default_factory=FilmConfig)
    seed: int = 0


def parse(arguments: Sequence[str]) -> RecordArguments:
    """The arguments of the command line. Raises SymdynError for bad input, SystemExit after ``--help``."""
    return parsed(RecordArguments, arguments, "symdyn record")
