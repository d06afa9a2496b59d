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
    """Record a film (MP4 or GIF) of a policy that runs through gaits and speeds on the nominal model, from a stand.

    The text above the robot shows gait, commanded speed and measured speed (mean over the last stride). The strip below
    shows commanded (hollow) and measured (solid) footfalls in the colours of the feet. Rendering needs no screen; it
    uses EGL or OSMesa, whichever works, or what MUJOCO_GL names.

    Attributes:
        policy: policy file; the shipped policy if left out.
        robot: name or robot file; the robot of the policy if left out.
        gaits: names from symdyn gaits, run one after another.
        speeds: forward speeds, m/s: one for each gait, or one for all. One gait can also have several speeds.
        seconds: duration of each gait and speed, s.
        out: output file, .mp4 or .gif; out/ROBOT.mp4 if left out. MP4 needs imageio-ffmpeg.
        film: how it is shown.
        seed: seed of the initial stride phase.
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
