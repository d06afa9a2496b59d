"""How long one waits for an import and for the help, in units of a bare interpreter's start."""

from __future__ import annotations

import subprocess
import sys

from benchmarks.result import Result, in_turns

_ROUNDS = 11


def _start(*arguments: str) -> None:
    subprocess.run([sys.executable, *arguments], check=True, capture_output=True)


def measure() -> list[Result]:
    """Ratios to ``python -c pass``."""
    bare, imported, helped = in_turns(
        [
            lambda: _start("-c", "pass"),
            lambda: _start("-c", "import symdyn"),
            lambda: _start("-m", "symdyn", "--help"),
        ],
        _ROUNDS,
    )
    details = {"python_s": bare}
    return [
        Result("import symdyn", imported, "s", at_most=0.2, details=details),
        Result("import symdyn / python -c pass", imported / bare, "", at_most=10.0, details=details),
        Result("symdyn --help", helped, "s", at_most=0.5, details=details),
        Result("symdyn --help / python -c pass", helped / bare, "", at_most=10.0, details=details),
    ]
