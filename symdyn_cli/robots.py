"""``symdyn robots``: the robots that commands take by name."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.table import Table

from rl.pretrained import pretrained
from slip.robot.known import KNOWN_ROBOTS
from symdyn.errors import SymdynError
from symdyn.io.console import make_console
from symdyn.io.settings_data import plain
from symdyn.robot.definition import Robot
from symdyn.robot.descriptions import urdf_path
from symdyn.robot.robot_file import ROBOTS, get_robot
from symdyn_cli.arguments.robots import RobotsArguments


def run(args: RobotsArguments) -> int:
    """The command. Raises SymdynError for bad input."""
    console = make_console()
    robots = [get_robot(name) for name in (ROBOTS if args.robot is None else (args.robot,))]
    if args.json:
        console.out(json.dumps([plain(robot) for robot in robots], indent=2), highlight=False)
        return 0
    if args.robot is None:
        console.print(_table([_row(robot) for robot in robots], _COLUMNS))
        console.print(f"For analysis only, without a robot file: {', '.join(sorted(KNOWN_ROBOTS))}.")
        console.print("What a robot file says: symdyn robots NAME. A robot of your own: docs/howto/robot.md.")
        return 0
    (robot,) = robots
    console.print(_table([[key, _text(value)] for key, value in _flat(plain(robot))], ("key", "value")))
    try:
        console.print(f"Description: {urdf_path(robot)}", soft_wrap=True)
    except SymdynError as error:
        console.print(str(error), style="yellow")
    return 0


_COLUMNS = ("robot", "leg, m", "trunk height, m", "kp, N m/rad", "kd, N m s/rad", "control, Hz", "policy")


def _row(robot: Robot) -> list[str]:
    low, high = robot.base_height_range
    return [
        robot.name,
        f"{robot.leg_length:.2f}",
        f"{low:.2f} to {high:.2f}",
        f"{robot.kp:g}",
        f"{robot.kd:g}",
        f"{1.0 / robot.control_dt:g}",
        "yes" if robot.name in pretrained() else "no",
    ]


def _table(rows: list[list[str]], headings: Sequence[str]) -> Table:
    table = Table(*headings, box=SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False, show_edge=False)
    for row in rows:
        table.add_row(*row)
    return table


def _flat(data: dict[str, Any], prefix: str = "") -> list[tuple[str, Any]]:
    """Dotted keys and their values; what is not set is left out."""
    found: list[tuple[str, Any]] = []
    for key, value in data.items():
        if isinstance(value, dict):
            found += _flat(value, f"{prefix}{key}.")
        elif value not in (None, []):
            found.append((f"{prefix}{key}", value))
    return found


def _text(value: Any) -> str:
    return " ".join(map(str, value)) if isinstance(value, list) else str(value)
