"""One process at a time writes a run directory."""

from __future__ import annotations

import fcntl
import os
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import datetime
from pathlib import Path

from symdyn.errors import FileProblem

FILE = ".lock"


@contextmanager
def held(run: Path) -> Iterator[None]:
    """Be the only process that writes a run directory, until the block or the process ends.

    Args:
        run: directory, made if need be. The lock file in it stays; what counts is the lock that a process has on it.

    Raises:
        FileProblem: if another process has it, which is named; or if the directory cannot be written to.
    """
    try:
        run.mkdir(parents=True, exist_ok=True)
        stream = (run / FILE).open("a+", encoding="utf-8")
    except OSError as error:
        raise FileProblem(run, f"is not a writable directory: {error.strerror or error}.") from error
    with stream:
        try:
            fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            stream.seek(0)
            owner = stream.read().strip() or "another process"
            raise FileProblem(
                run, f"is being written by {owner}: wait for it, stop it, or choose another directory."
            ) from None
        stream.truncate(0)
        stream.write(f"process {os.getpid()} on {socket.gethostname()}, since {datetime.now():%Y-%m-%d %H:%M:%S}\n")
        stream.flush()
        yield
