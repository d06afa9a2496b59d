"""Ctrl-C while a program closes its files: it ends at once, whatever a slow disk still keeps it waiting for."""

from __future__ import annotations

import contextlib
import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

from symdyn.io.exit_codes import INTERRUPTED

_TOLD = "\nsymdyn: interrupted while closing; the end of the log may be missing.\n"


@contextmanager
def leaving_at_once() -> Iterator[None]:
    """Within the block SIGINT and SIGTERM end the process, with exit code 130, without waiting for any thread."""
    if threading.current_thread() is not threading.main_thread():  # only there can signals be handled
        yield
        return
    before = {number: signal.signal(number, _leave) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _leave(_number: int, _frame: FrameType | None) -> None:
    with contextlib.suppress(OSError):
        os.write(sys.__stderr__.fileno() if sys.__stderr__ is not None else 2, _TOLD.encode())
    os._exit(INTERRUPTED)
