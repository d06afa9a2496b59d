"""A loop at a fixed rate. Deadlines lie on a grid, so that neither compute time nor a late wake-up shifts later ticks.

(loop-rate-limiters sets its next tick from the moment of waking, and so drifts by every wake-up's lateness.)
"""

from __future__ import annotations

import time
from collections.abc import Callable


class DeadlineLoop:
    """Waits for the next deadline.

    Args:
        period: s between deadlines.
        clock: s.
        sleep: waits for s.

    Attributes:
        ticks: waits that have ended.
        skipped: deadlines that passed before they were waited for: work that was never done.
        overruns: ticks that began more than a period late.
        overruns_in_row: up to now.
        lateness: of the present tick, s.
    """

    def __init__(
        self,
        period: float,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        self.period = period
        self._clock, self._sleep = clock, sleep
        self._start = clock()
        self._number = 0
        self.ticks = self.skipped = self.overruns = self.overruns_in_row = 0
        self.lateness = 0.0

    def wait(self) -> float:
        """Sleep until the next deadline; the time now, s. After a stall the missed deadlines are left out."""
        self._number += 1
        now = self._clock()
        # the deadline is computed from the grid, not from the last one: no sum of rounding errors
        while (remaining := self._start + self._number * self.period - now) > 0.0:
            self._sleep(remaining)
            now = self._clock()
        self.lateness = -remaining
        late = int(self.lateness / self.period)
        self.ticks += 1
        self.skipped += late
        self._number += late
        self.overruns += late > 0
        self.overruns_in_row = self.overruns_in_row + 1 if late else 0
        return now
