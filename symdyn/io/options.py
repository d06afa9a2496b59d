"""Options that several commands have."""

from __future__ import annotations

from typing import Annotated

import tyro

RobotOption = Annotated[str | None, tyro.conf.arg(metavar="NAME|FILE")]
"""``--robot``: for :func:`symdyn.robot.robot_file.get_robot`."""
