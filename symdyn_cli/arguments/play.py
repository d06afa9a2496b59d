"""The command line of ``symdyn play``."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from rl.viewer.window.address import DEFAULT_HOST, DEFAULT_PORT
from symdyn.io.command_line import parsed
from symdyn.io.options import RobotOption

_ROBOT_SIM = "--robot-sim"


@dataclass(frozen=True)
class PlayArguments:
    """A policy live in the browser: the robot in MuJoCo in real time, with buttons for gaits, mixtures of gaits, speed,
    pushes, payload, friction and uneven ground, and what it makes of them: footfalls, velocity, timing, cost of
    transport. Needs no screen and no graphics card here; the page is for a browser on this or another computer.

    With --robot-sim instead: watch the robot that LCM tells of, simulated (symdyn robot-sim) or real. Nothing is sent.

    Attributes:
        policy: the file; the policy that comes with symdyn if left out.
        robot: name or robot file of the robot; the policy's if left out.
        port: of the page; 0 takes a free one.
        host: name or address of this computer under which others reach the page. 127.0.0.1 is for this computer alone;
            0.0.0.0 is for everybody in the network, and there is no password.
        robot_sim: watch LCM at this URL; without a URL at LCM_DEFAULT_URL, or at LCM's own default.
        seed: decides the stride phase of each start.
    """

    policy: Annotated[Path | None, tyro.conf.Positional] = None
    robot: RobotOption = None
    port: int = DEFAULT_PORT
    host: str = DEFAULT_HOST
    robot_sim: Annotated[str | None, tyro.conf.arg(metavar="[URL]")] = None
    seed: int = 0


def parse(arguments: Sequence[str]) -> PlayArguments:
    """The arguments of the command line. Raises SymdynError for bad input, SystemExit after ``--help``."""
    return parsed(PlayArguments, _with_url(arguments), "symdyn play")


def _with_url(arguments: Sequence[str]) -> list[str]:
    """The arguments, and after a bare --robot-sim the URL that is meant."""
    given = list(arguments)
    if _ROBOT_SIM in given:
        place = given.index(_ROBOT_SIM) + 1
        if place == len(given) or "://" not in given[place]:
            from hardware.wire.channels import DEFAULT_URL

            given.insert(place, os.environ.get("LCM_DEFAULT_URL") or DEFAULT_URL)
    return given
