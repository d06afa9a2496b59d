"""What every command shares about talking to a person: one console, one way to log."""

from __future__ import annotations

import contextlib
import logging
import os
import shlex
import sys
from typing import IO, Any

from rich.console import Console
from rich.logging import RichHandler


class _Unreadable:
    """A stream that goes silent once it can no longer be written to: its reader has gone, or its disk is full."""

    def __init__(self, stream: IO[str]) -> None:
        self._stream = stream
        self._silent = False

    def write(self, text: str) -> int:
        self._unless_silent(lambda: self._stream.write(text))
        return len(text)

    def flush(self) -> None:
        self._unless_silent(self._stream.flush)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def _unless_silent(self, act: Any) -> None:
        if self._silent:
            return
        try:
            act()
        except OSError:
            self._silent = True
            # else the interpreter tries once more when it ends, and complains
            with contextlib.suppress(OSError, ValueError):
                os.dup2(os.open(os.devnull, os.O_WRONLY), self._stream.fileno())


def make_console(lasting: bool = False) -> Console:
    """A console on standard output.

    Args:
        lasting: for work that must not end because nobody reads it any more, or the disk that it is written to is full.
    """
    return Console(highlight=False, file=_Unreadable(sys.stdout) if lasting else None)  # type: ignore[arg-type]


def print_command(console: Console, *words: object, comment: str = "") -> None:
    """Print a command that can be pasted: quoted as a shell wants it, in one line however narrow the terminal.

    Args:
        console: to print on.
        words: program, options and their values; paths may hold spaces.
        comment: what the command does.
    """
    line = shlex.join(map(str, words))
    console.print(f"  {line}{f'   # {comment}' if comment else ''}", soft_wrap=True, markup=False)


def print_written(console: Console, text: str) -> None:
    """Print a sentence with paths in it, which are not to be broken."""
    console.print(text, soft_wrap=True, markup=False)


def log_to(console: Console, level: int = logging.INFO) -> None:
    """Send the log of symdyn's packages to a console, and of others only warnings."""
    handler = RichHandler(console=console, show_path=False, show_time=False)
    logging.basicConfig(level=logging.WARNING, handlers=[handler], format="%(message)s", force=True)
    for package in ("symdyn", "slip", "rl", "hardware"):
        logging.getLogger(package).setLevel(level)
