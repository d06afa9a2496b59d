"""The signals that ask a run to save and end."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager

STOPPING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


@contextmanager
def on_stop(handle: Callable[[int], None]) -> Iterator[list[int]]:
    """A list that the signals of :data:`STOPPING` fill.

    Args:
        handle: called with the number of each signal, before it is in the list.
    """
    received: list[int] = []

    def note(number: int, frame: object) -> None:
        handle(number)
        received.append(number)

    previous = {number: signal.signal(number, note) for number in STOPPING}
    try:
        yield received
    finally:
        for number, handler in previous.items():
            signal.signal(number, handler)
