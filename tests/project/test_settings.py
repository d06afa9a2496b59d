"""Every setting of every command refuses what has no sense, where it is made."""

from __future__ import annotations

import importlib
import math
from collections.abc import Iterator
from dataclasses import fields, is_dataclass, replace
from typing import Any, get_args, get_type_hints

import pytest
from hypothesis import given
from hypothesis import strategies as st

from symdyn.errors import SymdynError
from symdyn_cli.commands import GROUPS

ANY_SIGN = {"speeds", "resting_angle", "velocity_x", "velocity_y", "yaw_rate", "added_mass", "push"}
"""Settings that may be negative, by name."""

UNBOUNDED = {"max_speed"}
"""Settings for which infinity means without a limit."""


def settings_of(kind: type) -> Iterator[Any]:
    """Instances, by default, of every dataclass of settings within one, and within those."""
    for item in fields(kind):
        hint = get_type_hints(kind)[item.name]
        if is_dataclass(hint):
            assert isinstance(hint, type)
            yield hint()
            yield from settings_of(hint)


def every_setting() -> list[tuple[Any, str]]:
    """An instance and the name of a field, for all commands."""
    found: dict[tuple[type, str], Any] = {}
    for command in (c for group in GROUPS.values() for c in group.values()):
        module = importlib.import_module(command.arguments)
        (kind,) = [
            its for its in vars(module).values()
            if isinstance(its, type) and is_dataclass(its) and its.__module__ == module.__name__
        ]  # fmt: skip
        for settings in settings_of(kind):
            for item in fields(settings):
                found[type(settings), item.name] = settings
    return [(settings, name) for (_, name), settings in found.items()]


def number_kind(settings: Any, name: str) -> str | None:
    """``float``, ``int`` or ``floats`` for a setting that is made of numbers."""
    hint, value = get_type_hints(type(settings))[name], getattr(settings, name)
    if hint in (float, int):
        return hint.__name__
    if isinstance(value, tuple) and float in get_args(hint):
        return "floats"
    return None


NUMBERS = [(settings, name) for settings, name in every_setting() if number_kind(settings, name)]
RANGES = [(settings, name) for settings, name in NUMBERS if get_type_hints(type(settings))[name] == tuple[float, float]]


def refused(settings: Any, name: str, value: Any) -> bool:
    try:
        replace(settings, **{name: value})
    except SymdynError:
        return True
    return False


def labels(pairs: list[tuple[Any, str]]) -> list[str]:
    return [f"{type(settings).__name__}.{name}" for settings, name in pairs]


def test_there_are_settings_to_look_at():
    assert len(NUMBERS) > 60
    assert len(RANGES) >= 1


@pytest.mark.parametrize(("settings", "name"), NUMBERS, ids=labels(NUMBERS))
@given(data=st.data())
def test_no_number_is_nan_infinite_or_below_zero(settings, name, data):
    kind, value = number_kind(settings, name), getattr(settings, name)
    odd: list[st.SearchStrategy[float]] = []
    if kind != "int":
        odd.append(st.just(math.nan))
        odd += [] if name in UNBOUNDED else [st.just(math.inf)]
    if name not in ANY_SIGN:
        below = st.integers(max_value=-1) if kind == "int" else st.floats(max_value=-1e-3, allow_infinity=True)
        odd.append(below)
    bad: Any = data.draw(st.one_of(odd))
    if kind == "floats":
        if not value:  # an empty list means: as the base model has it
            value = (1.0,)
        place = data.draw(st.integers(0, len(value) - 1))
        bad = (*value[:place], bad, *value[place + 1 :])
    assert refused(settings, name, bad), (name, bad)


@pytest.mark.parametrize(("settings", "name"), RANGES, ids=labels(RANGES))
@given(low=st.floats(0.0, 10.0), width=st.floats(1e-3, 10.0))
def test_no_range_has_its_ends_exchanged(settings, name, low, width):
    assert refused(settings, name, (low + width, low))
