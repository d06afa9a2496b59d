"""A helper process that must be ready before its parent goes on, and outlives it long enough to act on its end."""

from __future__ import annotations

import os
import select
import subprocess
import sys
from collections.abc import Sequence

_START_S = 20.0
_END_S = 2.0


class Child:
    """A module run in a process of its own, told things through a pipe whose end tells it that the parent is gone.

    Args:
        module: to run.
        arguments: of its command line; ``--last-words FD``, the pipe to read, is added.

    Attributes:
        ready: the words of the line with which it said that it is ready; empty if it did not within 20 s.
    """

    def __init__(self, module: str, arguments: Sequence[str]) -> None:
        read, write = os.pipe()
        # a session of its own: Ctrl-C in the terminal must not reach it
        self._process = subprocess.Popen(
            [sys.executable, "-m", module, *arguments, "--last-words", str(read)],
            pass_fds=(read,), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, start_new_session=True,
        )  # fmt: skip
        os.close(read)
        self._pipe = write
        os.set_blocking(write, False)
        assert self._process.stdout is not None
        heard = select.select([self._process.stdout], [], [], _START_S)[0]
        self.ready = self._process.stdout.readline().decode().split() if heard else []

    @property
    def alive(self) -> bool:
        """Whether it still runs."""
        return self._process.poll() is None

    def kill(self) -> None:
        """End it at once."""
        self._process.kill()

    def say(self, words: str) -> bool:
        """Tell it a line. Returns whether it could be told: False if it is gone or does not listen."""
        try:
            os.write(self._pipe, f"{words}\n".encode())
        except OSError:
            return False
        return True

    def end(self) -> None:
        """Close the pipe and wait for it to end; after 2 s it is killed."""
        os.close(self._pipe)
        try:
            self._process.wait(timeout=_END_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
