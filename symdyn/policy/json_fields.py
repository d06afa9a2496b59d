"""Reading JSON objects of policy files: every key is checked as it is taken."""

from __future__ import annotations

import reprlib
import sys
from typing import Any

from symdyn.errors import FileProblem


class Fields:
    """The keys of a JSON object, each checked as it is taken.

    Args:
        data: the object.
        origin: the file, for errors.
        prefix: where in the file the object stands, for errors.

    Raises:
        FileProblem: from every method, for a key that is missing or not what it should be.
    """

    def __init__(self, data: Any, origin: object, prefix: str = "") -> None:
        self.origin = origin
        self._prefix = prefix
        if not isinstance(data, dict):
            name = prefix.rstrip(".") or "top level"
            raise FileProblem(origin, f"has metadata whose {name} is {reprlib.repr(data)}, but must be an object.")
        self.data: dict[str, Any] = data

    def __getitem__(self, key: str) -> Any:
        if key not in self.data:
            raise FileProblem(self.origin, f"has metadata without {self._prefix}{key}.")
        return self.data[key]

    def wrong(self, key: str, value: object, allowed: str) -> FileProblem:
        """The error for a value that is not as it must be."""
        where = f"{self._prefix}{key}"
        return FileProblem(self.origin, f"has metadata whose {where} is {reprlib.repr(value)}, but must be {allowed}.")

    def nested(self, key: str) -> Fields:
        return Fields(self[key], self.origin, f"{self._prefix}{key}.")

    def text(self, key: str) -> str:
        value = self[key]
        if not isinstance(value, str):
            raise self.wrong(key, value, "text")
        return value

    def flag(self, key: str) -> bool:
        value = self[key]
        if not isinstance(value, bool):
            raise self.wrong(key, value, "true or false")
        return value

    def whole(self, key: str) -> int:
        value = self[key]
        if type(value) is not int or value < 0:
            raise self.wrong(key, value, "a whole number >= 0")
        return value

    def number(self, key: str, positive: bool = False) -> float:
        value = self[key]
        if not is_number(value) or (positive and not value > 0):
            raise self.wrong(key, value, "a finite number > 0" if positive else "a finite number")
        return float(value)

    def numbers(self, key: str, length: int) -> tuple[float, ...]:
        value = self[key]
        if not isinstance(value, list) or len(value) != length or not all(map(is_number, value)):
            raise self.wrong(key, value, f"a list of {length} finite numbers")
        return tuple(map(float, value))

    def texts(self, key: str, length: int) -> tuple[str, ...]:
        value = self[key]
        if not isinstance(value, list) or len(value) != length or not all(isinstance(v, str) for v in value):
            raise self.wrong(key, value, f"a list of {length} names")
        return tuple(value)

    def bounds(self, key: str) -> tuple[float, float]:
        low, high = self.numbers(key, 2)
        if low > high:
            raise self.wrong(key, [low, high], "two numbers, the smaller first")
        return low, high


def is_number(value: object) -> bool:
    """Whether a JSON value is a number that fits a float; NaN and infinity were refused by the parser."""
    return (isinstance(value, float) or type(value) is int) and abs(value) <= sys.float_info.max
