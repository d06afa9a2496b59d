"""The clock that arrivals and ticks are told by: whole microseconds, as in a log.

A log keeps its times in whole microseconds. Had the controller known them more exactly, its log could not be put
through it again: where an age lies next to a limit, a half of a microsecond decides.
"""

from __future__ import annotations

import time

_MICRO = 1_000_000


def now() -> float:
    """time.monotonic() in whole microseconds, s."""
    return whole_microseconds(time.monotonic())


def whole_microseconds(seconds: float) -> float:
    """The number that is nearest to a whole number of microseconds, s.

    Times that a log has kept, and sums and differences of them, come out with all their bits.
    """
    return round(seconds * _MICRO) / _MICRO
