"""Robot files: what a URDF cannot say about a robot, as TOML (or JSON), by name or by path.

The keys are the attributes of :class:`symdyn.robot.definition.Robot`. The robots that come with symdyn lie in the
folder ``robots`` beside this module.
"""

from __future__ import annotations

import json
import tomllib
from dataclasses import replace
from functools import cache
from pathlib import Path

from symdyn.errors import FileProblem, UnknownName
from symdyn.io.files import write_json
from symdyn.io.settings_data import plain, rebuild
from symdyn.robot.definition import Robot

DEFAULT_ROBOT = "go2"
"""Name of the robot that commands take where none is given."""

EXAMPLE_ROBOT_DATA = "example-robot-data:"
"""What a ``urdf`` begins with that lies in the package example-robot-data."""

_SHIPPED = Path(__file__).parent / "robots"
_SUFFIXES = (".toml", ".json")


ROBOTS: tuple[str, ...] = tuple(sorted(path.stem for path in _SHIPPED.glob("*.toml")))
"""Names of the robots that come with symdyn."""


def is_robot_file(name: str) -> bool:
    """Whether a value of ``--robot`` is the path of a robot file."""
    return name.endswith(_SUFFIXES)


def get_robot(name_or_file: str) -> Robot:
    """A robot by its name or by the path of its file: the option ``--robot NAME|FILE`` of every command.

    Args:
        name_or_file: of :data:`ROBOTS`, or a path that ends in .toml or .json.

    Raises:
        UnknownName: if it is neither.
        FileProblem: if the file is missing or no robot file.
    """
    if name_or_file in ROBOTS:
        return _shipped(name_or_file)
    if is_robot_file(name_or_file):
        return load_robot_file(Path(name_or_file))
    raise UnknownName("robot", name_or_file, (*ROBOTS, "FILE.toml"))


def chosen_robot(option: str | None) -> Robot | None:
    """The robot of an option ``--robot`` that may be left out: :func:`get_robot`, or None. Raises what that raises."""
    return None if option is None else get_robot(option)


@cache
def _shipped(name: str) -> Robot:
    return load_robot_file(_SHIPPED / f"{name}.toml")


def load_robot_file(path: Path) -> Robot:
    """Read a robot file.

    Raises:
        FileProblem: if it is missing, no TOML (or JSON, by its suffix), or a key is unknown, missing or out of range.
    """
    try:
        text = path.read_text(encoding="utf-8")
        data = json.loads(text) if path.suffix == ".json" else tomllib.loads(text)
    except OSError as error:
        raise FileProblem(path, f"cannot be read: {error.strerror or error}.") from error
    except (ValueError, RecursionError) as error:  # both parsers' errors are ValueErrors
        kind = "JSON" if path.suffix == ".json" else "TOML"
        raise FileProblem(path, f"is not a robot file: it is not valid {kind} ({error}).") from error
    robot = rebuild(Robot, data, path)
    if robot.urdf.startswith(EXAMPLE_ROBOT_DATA):
        return robot
    return replace(robot, urdf=str((path.parent / robot.urdf).resolve()))


def save_robot_file(robot: Robot, path: Path) -> None:
    """Write a robot as JSON that :func:`load_robot_file` reads. Raises FileProblem."""
    write_json(path, plain(robot))
