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
    """Run a policy live in the browser: the robot in MuJoCo in real time, with controls for gait, mixtures of gaits,
    speed, pushes, payload, friction and uneven ground. The page shows footfalls, velocity, timing and cost of
    transport. This computer needs neither a screen nor a graphics card.

    With --robot-sim it shows a robot that publishes on LCM instead, simulated (symdyn robot-sim) or real. Nothing is
    sent to that robot.

    Attributes:
        policy: policy file; the shipped policy if left out.
        robot: name or robot file; the robot of the policy if left out.
        port: port of the page; 0 chooses a free one.
        host: address on which the page is served. 127.0.0.1 serves this computer only; 0.0.0.0 serves everybody on the
            network, without a password.
        robot_sim: show the robot on this LCM URL; without a URL LCM_DEFAULT_URL, or LCM's default.
        seed: seed of the stride phase at each start.
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
