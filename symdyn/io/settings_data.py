"""Frozen dataclasses of settings as nested dicts of plain values, and back with every key and type checked."""

from __future__ import annotations

import math
import reprlib
from collections.abc import Mapping
from dataclasses import MISSING, asdict, fields, is_dataclass
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

from symdyn.errors import FileProblem, SymdynError

C = TypeVar("C")


def plain(config: Any) -> dict[str, Any]:
    """Settings as nested dicts of plain values: tuples become lists, paths text."""
    return _plain(asdict(config))


def rebuild(kind: type[C], data: Any, origin: object) -> C:
    """The settings from :func:`plain`. A setting that the data lack, as those of an older file do, takes its default.

    Args:
        kind: the dataclass.
        data: nested dicts.
        origin: what to call their source in an error.

    Raises:
        FileProblem: if a key is unknown, a key without a default is missing, or a value is of a wrong type or out of
            range; it names the key.
    """
    return _build(kind, data, "", origin)


def differences(a: Any, b: Any) -> list[str]:
    """Dotted names of the settings that differ between two of one kind, in order: ``env.commands.gaits``."""
    return _differences(a, b, "")


def _differences(a: Any, b: Any, prefix: str) -> list[str]:
    found = []
    for field in fields(a):
        mine, its, key = getattr(a, field.name), getattr(b, field.name), f"{prefix}{field.name}"
        if is_dataclass(mine):
            found += _differences(mine, its, f"{key}.")
        elif mine != its:
            found.append(key)
    return found


def _plain(value: Any) -> Any:
    match value:
        case dict():
            return {key: _plain(item) for key, item in value.items()}
        case tuple() | list():
            return [_plain(item) for item in value]
        case Path():
            return str(value)
        case _:
            return value


def _build(hint: Any, value: Any, key: str, origin: object) -> Any:
    """``value`` as the type hint asks for it. ``key`` is its dotted name, empty at the top."""
    if is_dataclass(hint):
        return _build_dataclass(hint, value, key, origin)
    kind, arguments = get_origin(hint), get_args(hint)
    if kind in (Union, UnionType):
        if value is None and NoneType in arguments:
            return None
        (hint,) = (argument for argument in arguments if argument is not NoneType)
        return _build(hint, value, key, origin)
    if kind is tuple and isinstance(value, list):
        endless = arguments[-1] is Ellipsis
        hints = [arguments[0]] * len(value) if endless else list(arguments)
        if len(hints) == len(value):
            pairs = enumerate(zip(hints, value, strict=True))
            return tuple(_build(item_hint, item, f"{key}[{i}]", origin) for i, (item_hint, item) in pairs)
    elif kind is Mapping:
        if isinstance(value, dict) and all(isinstance(name, str) for name in value):
            return value
    elif kind is Literal:
        if value in arguments:
            return value
    elif hint is float:
        if type(value) is int or isinstance(value, float):
            number = _to_float(value)
            if math.isfinite(number):
                return number
    elif hint is Path:
        if isinstance(value, str) and value:
            return Path(value)
    elif type(value) is hint:
        return value
    quoted = " without quotes (in YAML, write 1.0e-3, not 1e-3)" if hint is float and _is_number(value) else ""
    raise FileProblem(origin, f"{key} is {reprlib.repr(value)}, but must be {_allowed(hint)}{quoted}.")


def _build_dataclass(hint: Any, value: Any, key: str, origin: object) -> Any:
    name = key or "the file"
    if not isinstance(value, dict):
        raise FileProblem(origin, f"{name} is {reprlib.repr(value)}, but must be a table of settings.")
    hints = get_type_hints(hint)
    known = [field.name for field in fields(hint)]
    needed = [f.name for f in fields(hint) if f.default is MISSING and f.default_factory is MISSING]
    prefix = f"{key}." if key else ""
    unknown = [f"{prefix}{other}" for other in value if other not in known]
    if unknown:
        allowed = ", ".join(known)
        raise FileProblem(origin, f"has unknown settings: {', '.join(unknown)}. Known in {name}: {allowed}.")
    missing = [f"{prefix}{other}" for other in needed if other not in value]
    if missing:
        raise FileProblem(origin, f"lacks the settings {', '.join(missing)}.")
    values = {
        other: _build(hints[other], value[other], f"{prefix}{other}", origin) for other in known if other in value
    }
    try:
        return hint(**values)
    except SymdynError as error:
        raise FileProblem(origin, f"has a bad setting in {name}. {error}") from error


def _is_number(value: Any) -> bool:
    """Whether text reads as a number."""
    try:
        return isinstance(value, str) and math.isfinite(float(value))
    except ValueError:
        return False


def _to_float(value: float) -> float:
    try:
        return float(value)
    except OverflowError:
        return math.inf


def _allowed(hint: Any) -> str:
    kind, arguments = get_origin(hint), get_args(hint)
    if is_dataclass(hint):
        return "a table of settings"
    if kind is Literal:
        return f"one of {', '.join(map(repr, arguments))}"
    if kind is tuple:
        number = "" if arguments[-1] is Ellipsis else f" of {len(arguments)}"
        return f"a list{number}, each {_allowed(arguments[0])}"
    if kind is Mapping:
        return "a table"
    names = {
        float: "a finite number",
        int: "a whole number",
        bool: "true or false",
        str: "text",
        Path: "a path",
    }
    return names[hint]
