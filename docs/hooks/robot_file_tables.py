"""The keys of a robot file, from the docstrings of its dataclasses, and the robot file of the Go2."""

from __future__ import annotations

import re
from dataclasses import MISSING, fields, is_dataclass
from types import NoneType
from typing import Any, get_args, get_origin, get_type_hints

from checkout import ROOT
from settings_page import documentation

from symdyn.io.markdown import table
from symdyn.robot.definition import JointLimit, Leg, Robot
from symdyn.robot.robot_file import DEFAULT_ROBOT

_UNIT = re.compile(r"(?:^|, )(N m s/rad|N m/rad|N m|rad/s|rad|m|s)(?=[.,:;]| of |$)")
"""Where a docstring names the unit: after a comma, or as its first word."""


def shown_file() -> list[str]:
    """The robot file of the robot that commands take where none is given."""
    name = f"{DEFAULT_ROBOT}.toml"
    text = (ROOT / "symdyn" / "robot" / "robots" / name).read_text(encoding="utf-8").rstrip()
    return [f'```toml title="symdyn/robot/robots/{name}"', *text.splitlines(), "```"]


def key_table(cls: type) -> list[str]:
    """Key, value, unit, whether it is required, and meaning of each attribute of a class of the robot file."""
    _, meanings = documentation(cls)
    hints, rows = get_type_hints(cls), []
    for field in fields(cls):
        meaning = meanings[field.name].replace("|", "\\|").replace("``", "`")
        unit = _UNIT.search(meaning)
        needed = "yes" if field.default is MISSING else "no"
        rows.append([f"`{field.name}`", _value(hints[field.name]), unit[1] if unit else "-", needed, meaning])
    return table(["key", "value", "unit", "required", "meaning"], rows)


def _value(hint: Any) -> str:
    """What stands in the file for a type, in words."""
    arguments = get_args(hint)
    if get_origin(hint) is tuple:
        if arguments[-1] is Ellipsis:
            return "list of tables"
        return f"list of {len(arguments)} {'numbers' if arguments[0] is float else 'texts'}"
    if NoneType in arguments:
        return _value(next(argument for argument in arguments if argument is not NoneType))
    if is_dataclass(hint):
        return "table"
    return {float: "number", str: "text"}[hint]


TABLES = {
    "<!-- robot file -->": shown_file,
    "<!-- robot file: keys -->": lambda: key_table(Robot),
    "<!-- robot file: leg keys -->": lambda: key_table(Leg),
    "<!-- robot file: limit keys -->": lambda: key_table(JointLimit),
}
"""Comments in pages in whose place a table is put."""
