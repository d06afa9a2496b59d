"""Every error that symdyn raises on purpose.

The command line turns a :class:`SymdynError` into one sentence and exit code 2. An error names the bad value and says
what is allowed; anything else that escapes is a defect and keeps its traceback.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable


class SymdynError(Exception):
    """Base class: something outside the program (an argument, a file, the machine) is not as it must be."""


class InvalidValue(SymdynError):
    """A number or setting is outside its allowed range."""

    def __init__(self, name: str, value: object, allowed: str) -> None:
        super().__init__(f"{name} is {value!r}, but must be {allowed}.")


class UnknownName(SymdynError):
    """A name that is not in a list of known names."""

    def __init__(self, kind: str, name: str, known: Iterable[str]) -> None:
        names = sorted(known)
        close = difflib.get_close_matches(name, names, n=1)
        hint = f" Did you mean {close[0]!r}?" if close else ""
        super().__init__(f"Unknown {kind} {name!r}.{hint} Known: {', '.join(names)}.")


class FileProblem(SymdynError):
    """A file is missing, unreadable, unwritable or does not hold what it should."""

    def __init__(self, path: object, problem: str) -> None:
        super().__init__(f"{path}: {problem}")


class PolicyMismatch(SymdynError):
    """A policy file was made for another robot, layout or format."""


class ResourceProblem(SymdynError):
    """The machine lacks memory, a package or a device that the command needs."""
