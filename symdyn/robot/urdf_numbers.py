"""The numbers of a URDF, checked before a library reads it: parsers differ in what they drop or take in silence."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from pathlib import Path
from xml.parsers import expat

from symdyn.errors import FileProblem

_POSE = {"xyz": 3, "rpy": 3}
_TENSOR = dict.fromkeys(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), 1)
_NUMBERS: Mapping[str, Mapping[str, int]] = {
    "origin": _POSE,
    "axis": {"xyz": 3},
    "mass": {"value": 1},
    "inertia": {str(name): size for name, size in _TENSOR.items()},
    "limit": {"lower": 1, "upper": 1, "effort": 1, "velocity": 1},
    "dynamics": {"damping": 1, "friction": 1},
    "box": {"size": 3},
    "sphere": {"radius": 1},
    "cylinder": {"radius": 1, "length": 1},
}
"""How many numbers each attribute of each element holds."""

_NOT_NEGATIVE = {
    ("mass", "value"), ("inertia", "ixx"), ("inertia", "iyy"), ("inertia", "izz"), ("limit", "effort"),
    ("limit", "velocity"), ("dynamics", "damping"), ("dynamics", "friction"), ("box", "size"), ("sphere", "radius"),
    ("cylinder", "radius"), ("cylinder", "length"),
}  # fmt: skip

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")


def check_numbers(urdf: Path) -> None:
    """Check every number of links and joints.

    What is no XML is left to whoever reads it.

    Raises:
        FileProblem: if one is no number, not finite, or negative where that has no sense; it names the line.
    """
    try:
        content = urdf.read_bytes()
    except OSError:
        return
    parser = expat.ParserCreate()
    stack: list[tuple[str, str]] = []

    def start(element: str, attributes: dict[str, str]) -> None:
        owner = next((f" of {kind} {name!r}" for kind, name in reversed(stack) if kind in ("link", "joint")), "")
        stack.append((element, attributes.get("name", "")))
        for attribute, count in _NUMBERS.get(element, {}).items():
            if owner and attribute in attributes:
                problem = _problem(element, attribute, attributes[attribute], count)
                if problem:
                    where = f'line {parser.CurrentLineNumber}: <{element} {attribute}="{attributes[attribute]}">{owner}'
                    raise FileProblem(urdf, f"{where}: {problem}")

    def end(_element: str) -> None:
        stack.pop()

    parser.StartElementHandler, parser.EndElementHandler = start, end
    try:
        parser.Parse(content, True)
    except expat.ExpatError:
        return


def _problem(element: str, attribute: str, text: str, count: int) -> str:
    """What is wrong with the value of an attribute, or nothing."""
    if "${" in text:
        return "is an expression of xacro, not a number; convert the file with xacro first."
    words = text.split()
    for word in words:
        if not _NUMBER.fullmatch(word):
            comma = " (a decimal point is needed)" if re.fullmatch(r"[+-]?\d+,\d+", word) else ""
            return f"{word!r} is not a finite number{comma}."
        if not math.isfinite(float(word)):
            return f"{word!r} is not a finite number."
    if len(words) != count:
        return f"{len(words)} numbers, but must be {count}."
    if (element, attribute) in _NOT_NEGATIVE and min(float(word) for word in words) < 0.0:
        return "must not be negative."
    return ""
